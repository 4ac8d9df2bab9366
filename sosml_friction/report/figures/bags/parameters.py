# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that several recordings say, each alone and together."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.parameter_bars import draw_parameters
from sosml_friction.report.fit.consolidation_view import BagsJoint, consolidated_rows


class BagsParameters(Figure[BagsJoint]):
    """Draw the parameters of each recording alone, by the paper's rule, and by the joint fit."""

    identifier = 'parameters'
    title = 'Parameters'
    report = 'bags'
    order = 20
    caption = (
        'Parameters of joint {view.entry.joint} with their 95 % intervals: each recording '
        'alone, the rule of the paper, the joint fit. What is not identifiable is a bare '
        'range, with an arrow where it is open.'
    )

    def draw(self, view: BagsJoint) -> Drawing:
        return draw_parameters(consolidated_rows(view), view.known or None)
