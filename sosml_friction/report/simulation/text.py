# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What forward simulation of a recording says, in sentences."""

import numpy as np

from sosml_friction.identification.log_analysis import BagAnalysis


def simulation_lines(analysis: BagAnalysis) -> list[str]:
    """Return how well simulation follows a recording, a line for each joint."""
    found = analysis.output_error
    if found is None:
        return []
    lines = [
        f'{joint}: closed loop simulated with the inverse model and the recorded controller: '
        f'position {check.position_error:.2g} %, effort {check.effort_error:.2f} % of the measured'
        for joint, check in found.closed_loop.items()
    ]
    for joint, fit in found.joints.items():
        how = (
            'under the recorded controller'
            if found.modes[joint] == 'controller'
            else ('by the measured effort')
        )
        effort = '' if np.isnan(fit.effort_error) else f', effort {fit.effort_error:.2f} %'
        lines.append(
            f'{joint}: output error, simulated {how}: position {fit.position_error:.2g} %{effort} '
            'of the measured'
        )
    lines += [f'{joint}: no output error: {why}' for joint, why in found.unavailable.items()]
    return lines
