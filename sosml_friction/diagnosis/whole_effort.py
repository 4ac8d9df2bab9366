# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An effort in another scale than all that the model needs, further than a cause may be."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.identification.joint_checks import FAR
from sosml_friction.model.terms.effort_scale import LARGEST
from sosml_friction.regression.signals import Signals


def whole_effort(stretches: Sequence[Signals], i: int) -> Check | None:
    """
    Return that the effort of a joint is a multiple of all that its model needs, else None.

    tau = scale (bodies + friction) + constant, by least squares in the band. Beyond the range of
    ``effort_scale`` a search finds it as a payload, frictions and an inertia, each off by as much.
    Where bodies alone, or friction alone, in another scale are far from explaining as much, it is
    no cause but another unit, sign or gear: the effort is bad.
    """
    signals = stretches[0]
    if not np.isfinite(signals.scales.coulomb[i] + signals.scales.viscous[i]):
        return None
    parts = [np.column_stack([s.tau[:, i], s.rigid[:, i], s.torque[:, i]]) for s in stretches]
    both = [s.in_band(x, [i, i, i]) for s, x in zip(stretches, parts, strict=True)]
    tau, bodies, need = (x - x.mean() for x in np.concatenate(both).T)
    scale, scaled = _scaled(tau, need)
    as_it_is = float(np.linalg.norm(tau - need))
    if abs(scale - 1.0) < LARGEST or scaled > FAR * as_it_is:
        return None
    friction = need - bodies
    alone = min(_scaled(tau - friction, bodies)[1], _scaled(tau - bodies, friction)[1])
    bad = scaled < FAR * alone
    then = 'before anything is said of it'
    if not bad:
        then = 'before you believe causes that are each off by as much'
    name, whole = signals.robot.names[i], max(float(np.linalg.norm(tau)), 1e-300)
    return Check(
        'effort_scale',
        'bad' if bad else 'warning',
        name,
        f'the effort of joint {name} is {scale:.3g} times all that its model needs, bodies and '
        f'friction: by that alone {100.0 * scaled / whole:.2g} % of it are left unexplained, and '
        f'{100.0 * as_it_is / whole:.2g} % as it is; see whether its torque constant, gear ratio '
        f'or unit is wrong, or a hand moves it, {then}',
        {'scale': scale},
    )


def _scaled(y: FloatArray, x: FloatArray) -> tuple[float, float]:
    """Return the scale of x that is nearest to y, and the norm of what it leaves."""
    square = float(x @ x)
    scale = float(y @ x) / square if square > 0.0 else 1.0
    return scale, float(np.linalg.norm(y - scale * x))
