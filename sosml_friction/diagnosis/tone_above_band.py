# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A tone of the effort above the band, where a diagnosis does not look."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.decision.tone import Tone, strongest_tone
from sosml_friction.regression.chance import CHANCE, NEGLIGIBLE
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.noise_model import NoiseModel
from sosml_friction.regression.signals import Signals

#: No colour: what a tone is compared with is what is beside it.
_WHITE = NoiseModel(np.zeros(0), 1.0)
#: Samples that are looked at: of so many a tone of 2 % of an energy is 100 times what white noise
#: has of it in a line, and more say nothing more.
_MOST = 10_000


def tone_above_band(stretches: Sequence[Signals], i: int) -> Check | None:
    """
    Return the strongest tone above the band of what the nominal leaves of a joint's effort.

    In the longest stretch; None where it is by chance, next to nothing of what is above the band,
    or may follow the motion: friction that turns around in a motion that repeats makes tones, as
    the signs of velocity have, and cogging at constant speed makes one. Effort that is held over
    several samples has mirror images of its motion there: nothing is said of it.
    """
    longest = max(stretches, key=lambda s: len(s.time))
    band, own = longest.band, slice(_MOST)
    tau, sign, q = (x[own] for x in (longest.tau[:, i], longest.sign, longest.q[:, [i]]))
    # Of an effort that does not change rounding has tones.
    if np.median(longest.held) > 1.0 or np.ptp(tau) <= ROUNDING * np.abs(tau).max():
        return None
    tone = _strongest(tau - longest.torque[own, i], band.step, band.cutoff, 0.5 / band.step)
    if not (tone.chance < CHANCE and tone.share > NEGLIGIBLE):
        return None
    near = 2.0 / (len(tau) * band.step)
    turning = (_strongest(s, band.step, tone.hertz - near, tone.hertz + near) for s in sign.T)
    if any(each.chance < CHANCE for each in turning) or tone.follows(q, band.step):
        return None
    size = float(np.sqrt(2.0 * tone.energy / len(tau)))
    name, unit = longest.robot.names[i], longest.robot.effort_units[i]
    return Check(
        'tone',
        'warning',
        name,
        f'the effort of {name} has a tone of {tone.hertz:.1f} Hz and {size:.3g} {unit}, as of '
        f'mains, a drive or a resonance: it is above the band of {band.cutoff:.0f} Hz, where '
        'nothing is looked for',
        {'hertz': tone.hertz, 'size': size},
    )


def _strongest(x: FloatArray, step: float, above: float, below: float) -> Tone:
    return strongest_tone(x - x.mean(), _WHITE, step, below, above)
