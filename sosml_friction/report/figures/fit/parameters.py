# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of one recording with their intervals."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common.figure import METHOD, Figure
from sosml_friction.report.common.labels import fit_label
from sosml_friction.report.common.parameter_bars import ParameterRow, draw_parameters
from sosml_friction.report.fit.joint_view import JointView


class Parameters(Figure[JointView]):
    """Draw the parameters of each observer: by the method in use, and by the other one."""

    identifier = 'parameters'
    title = 'Parameters'
    report = 'fit'
    order = 30
    part = METHOD
    caption = (
        'Parameters of joint {view.name} with their 95 % intervals. What is not identifiable '
        'is a bare range, with an arrow where it is open.'
    )

    def applies(self, view: JointView) -> bool:
        return view.preferred is not None

    def draw(self, view: JointView) -> Drawing:
        return draw_parameters(parameter_rows(view), view.known or None)


def parameter_rows(view: JointView) -> list[ParameterRow]:
    """Return the rows of a joint: for each observer the fit in use, then the other method's."""
    return [
        ParameterRow(
            fit_label(observer, fit.method),
            fit.fit.parameters,
            view.style(observer),
            fits is view.fits,
            fits is view.fits and observer == view.preferred,
        )
        for observer in view.fits
        for fits in (view.fits, view.alternatives)
        if (fit := fits.get(observer)) is not None
    ]
