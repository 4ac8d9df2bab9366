# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An effort in another scale than all that the model needs, further than a cause may be."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.identification.joint_checks import FAR
from sosml_friction.model.terms.effort_scale import LARGEST
from sosml_friction.regression.signals import Signals


def whole_effort(stretches: Sequence[Signals], i: int) -> Check | None:
    """
    Return that the effort of a joint is a multiple of all that its model needs, else None.

    tau = scale (bodies + friction) + constant, by least squares in the band. Beyond the range of
    ``effort_scale`` a search finds it as a payload, frictions and an inertia, each off by as much.
    """
    signals = stretches[0]
    if not np.isfinite(signals.scales.coulomb[i] + signals.scales.viscous[i]):
        return None
    both = [s.in_band(np.column_stack([s.tau[:, i], s.torque[:, i]]), [i, i]) for s in stretches]
    tau, need = np.concatenate(both).T
    tau, need = tau - tau.mean(), need - need.mean()
    square = float(need @ need)
    scale = float(tau @ need) / square if square > 0.0 else 1.0
    if abs(scale - 1.0) < LARGEST:
        return None
    as_it_is, scaled = (float(np.linalg.norm(tau - x * need)) for x in (1.0, scale))
    if scaled > FAR * as_it_is:
        return None
    name, whole = signals.robot.names[i], max(float(np.linalg.norm(tau)), 1e-300)
    return Check(
        'effort_scale',
        'warning',
        name,
        f'the effort of joint {name} is {scale:.3g} times all that its model needs, bodies and '
        f'friction: by that alone {100.0 * scaled / whole:.2g} % of it are left unexplained, and '
        f'{100.0 * as_it_is / whole:.2g} % as it is; see whether its torque constant, gear ratio '
        'or unit is wrong, or a hand moves it, before you believe causes that are each off by as '
        'much',
        {'scale': scale},
    )
