# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One of several recordings over time."""

from __future__ import annotations

from sosml_friction.report.figures.fit.overview import Overview
from sosml_friction.report.fit.joint_view import JointView


class BagOverview(Overview):
    """Draw each of several recordings as a report of it alone does."""

    report = 'bags'

    def caption(self, view: JointView) -> str:
        """Return what is shaded."""
        return (
            f'Overview of joint {view.name}: shaded windows are used, hatched ones are not; their '
            'numbers are those of the table of windows.'
        )
