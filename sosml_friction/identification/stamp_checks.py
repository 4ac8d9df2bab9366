# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether stamps are the times of measurement, and how much viscous friction they feign if not."""

import itertools
from collections.abc import Iterator

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.data_finding import NOTE, WARNING, DataFinding
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.segments import centred_difference

#: Steps longer than this many periods are holes, across which nothing is compared.
_HOLE = 10.0
#: Fewest samples in motion that say something.
_FEWEST = 100
#: Stretches of the recording whose noise is one.
_CLUSTERS = 50
#: Standard errors by which the stamps must be wrong to count. Chosen, no measurement.
SURE = 4.0
#: Time to either side over which velocity and change of effort are taken [s]: the noise of a
#: position that a control loop answers would feign a relation of the two. Chosen, no measurement.
_HALF_S = 0.01
#: Share of the effort that may be feigned without a warning, and of the period by which stamps may
#: be wrong without a word. Chosen, no measurement.
_FEIGNED, _MISSED = 0.01, 0.1


def lateness(log: JointLog, column: int, period_s: float) -> tuple[float, float]:
    """
    Return by how much stamps miss the times of measurement, (rms [s], its standard errors from 0).

    A sample lies e later than the middle of its neighbours. If it was measured then, a joint at
    the velocity v has gone v e beyond the middle of their positions; if it was measured on time
    and stamped late, it has not. The share of e^2 that the positions do not follow is wrong. Each
    of three stamps has a part in e, so that a single one has 2/3 of its square.
    """
    t, q = log.time, log.q[:, column]
    ends = np.linspace(1, len(t) - 1, _CLUSTERS + 1).astype(int)
    # A stretch at a time, and not N rows of all: an hour has millions.
    moments = np.array(
        [
            _moments(t[first - 1 : last + 1], q[first - 1 : last + 1], _HOLE * period_s)
            for first, last in itertools.pairwise(ends)
            if last > first
        ]
    ).reshape(-1, 4)
    used, square, missed, uneven = moments.sum(0)
    if used < _FEWEST or not square > 0.0:
        return 0.0, 0.0
    share = missed / square
    # One row of each stretch has its sums.
    root = np.sqrt(moments[:, 1])
    left = np.divide(moments[:, 2], root, out=np.zeros_like(root), where=root > 0.0) - share * root
    error = float(jackknife_errors(root[:, None], left, np.arange(len(root)))[0])
    if not share > 0.0 or not error > 0.0:
        return 0.0, 0.0
    return float(np.sqrt(min(share, 1.0) * 2.0 / 3.0 * uneven / used)), float(share) / error


def _moments(t: FloatArray, q: FloatArray, hole: float) -> tuple[float, float, float, float]:
    """Return sums of 1, (v e)^2, v e (v e - what q goes), e^2 over samples but those at holes."""
    steps, span = np.diff(t), t[2:] - t[:-2]
    v = np.divide(q[2:] - q[:-2], span, out=np.zeros_like(span), where=span != 0.0)
    used = (np.maximum(steps[1:], steps[:-1]) < hole) & (v != 0.0) & np.isfinite(v + q[1:-1])
    e = (t[1:-1] - 0.5 * (t[:-2] + t[2:]))[used]
    x = v[used] * e
    missed = x - (q[1:-1] - 0.5 * (q[:-2] + q[2:]))[used]
    return float(used.sum()), float(x @ x), float(x @ missed), float(e @ e)


def feigned_viscous(log: JointLog, column: int, period_s: float) -> tuple[float, FloatArray]:
    """
    Return the viscous friction that effort feigns for each second it is late, and v (N,).

    tau(t - d) is tau - d tau', and the part of that along the velocity is -d (tau' . v) / (v . v)
    [Nm s/rad or N s/m]: d times inertia and the square of a frequency, less d times the slope of
    gravity over position.
    """
    half = max(1, round(_HALF_S / period_s))
    v = centred_difference(log.time, log.q[:, column], half)
    rate = centred_difference(log.time, log.tau[:, column], half)
    known: BoolArray = np.isfinite(v) & np.isfinite(rate)
    square = float(v[known] @ v[known])
    return (-float(rate[known] @ v[known]) / square if square > 0.0 else 0.0), v[known]


def check_stamps(log: JointLog, period_s: float) -> Iterator[DataFinding]:
    """Yield what is to be said of each joint with effort."""
    for i, name in enumerate(log.names):
        tau = log.tau[np.isfinite(log.tau[:, i]), i]
        late_s, sure = lateness(log, i, period_s)
        if len(tau) < _FEWEST or sure < SURE or late_s < _MISSED * period_s:
            continue
        slope, v = feigned_viscous(log, i, period_s)
        feigned = abs(slope) * late_s
        share = feigned * float(np.sqrt(np.mean(v**2)) / (np.std(tau) or np.inf))
        yield DataFinding(
            'late_stamps',
            name,
            WARNING if share > _FEIGNED else NOTE,
            f'the stamps miss the times at which joint {name} was measured by {1e3 * late_s:.2g} '
            'ms (rms): effort that is as far from its position reads as viscous friction of '
            f'{feigned:.2g}; stamp each sample when it is measured, on a machine with less to do',
        )
