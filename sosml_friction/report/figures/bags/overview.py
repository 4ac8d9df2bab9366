# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One of several recordings over time."""

from sosml_friction.report.figures.fit.overview import Overview
from sosml_friction.report.fit.joint_view import JointView


class BagOverview(Overview):
    """Draw each of several recordings as a report of it alone does."""

    report = 'bags'
    caption = (
        'Overview of joint {view.name}: shaded windows are used, hatched ones are not; their '
        'numbers are those of the table of windows.'
    )

    def caption_of(self, view: JointView) -> str:
        """Return the same for all joints."""
        return self.caption.format(view=view)
