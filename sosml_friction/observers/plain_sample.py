# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What nearly every sample is, compiled: one in which nothing is to be judged."""

import math

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled


@compiled
def take_plain_sample(
    t_s: float,
    sample: FloatArray,
    last: FloatArray,
    elapsed_s: float,
    ranges: FloatArray,
    place: FloatArray,
    spans: FloatArray,
    steps: FloatArray,
) -> bool:
    """
    Remember a sample that is within all limits, can be reached and has no zero among its efforts.

    Return whether it is one; nothing is changed if it is not.

    :param t_s: its stamp [s].
    :param sample: q, v, tau and the way by velocities, (4, n); the way is written.
    :param last: those of the sample before.
    :param elapsed_s: since then [s].
    :param ranges: what effort and velocity may be, and the least and greatest position, (4, n).
    :param place: the position that was trusted last and since when it is there, (2, n); written.
    :param spans: since that was trusted, of a frame of a servo, and what is granted to stamps that
        bunch, (3,) [s].
    :param steps: the smallest step of each position that was seen, (n,); written.
    """
    n = len(steps)
    for i in range(n):
        q, v, tau = sample[0, i], sample[1, i], sample[2, i]
        if not (math.isfinite(q) and math.isfinite(v)) or tau == 0.0 or abs(tau) >= ranges[0, i]:
            return False
        if abs(v) > ranges[1, i] or q < ranges[2, i] or q > ranges[3, i]:
            return False
        passed = max(spans[0], min(t_s - place[1, i], spans[1]))
        if not abs(q - place[0, i]) <= ranges[1, i] * (passed + spans[2]) + 10.0 * steps[i]:
            return False
    for i in range(n):
        q = sample[0, i]
        step = abs(q - last[0, i])
        # Less than this is the rounding of the same position.
        if 1e-9 * (1.0 + abs(q)) < step < steps[i]:
            steps[i] = step
        sample[3, i] = last[3, i] + (0.5 * elapsed_s) * (last[1, i] + sample[1, i])
        if q != place[0, i]:
            place[0, i], place[1, i] = q, t_s
    return True


@compiled
def take_friction(
    estimate: FloatArray,
    moving: BoolArray,
    standing: BoolArray,
    most: FloatArray,
    step_s: float,
    settled: bool,
    stop_s: float,
    q: FloatArray,
    greatest: FloatArray,
    beyond_s: FloatArray,
    frozen_q: FloatArray,
) -> bool:
    """
    Remember the friction of a sample; return whether a joint stands still that could not.

    :param estimate: tau_f (n,), NaN where not known.
    :param most: what each joint holds against at rest (n,).
    :param step_s: since the sample before [s].
    :param settled: whether the observers are past their start.
    :param stop_s: a standstill that friction cannot explain is one for so long [s].
    :param q: the position (n,).
    :param greatest: the greatest in motion (n,); written.
    :param beyond_s: for how long friction cannot explain a standstill (n,) [s]; written.
    :param frozen_q: where a joint stands that could not (n,); written.
    """
    found = False
    for i in range(len(estimate)):
        size = abs(estimate[i])
        if not math.isfinite(size):
            continue
        if moving[i]:
            if settled and size > greatest[i]:
                greatest[i] = size
        elif standing[i] and size > most[i]:
            beyond_s[i] += step_s
            # A velocity made from steps of the encoder is a spike, and soon over.
            if beyond_s[i] > stop_s:
                frozen_q[i] = q[i]
                found = True
            continue
        beyond_s[i] = 0.0
    return found
