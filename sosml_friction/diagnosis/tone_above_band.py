# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A tone of the effort above the band, where a diagnosis does not look."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.decision.tone import strongest_tone
from sosml_friction.regression.chance import CHANCE, NEGLIGIBLE
from sosml_friction.regression.noise_model import NoiseModel
from sosml_friction.regression.signals import Signals

#: No colour: what a tone is compared with is what is beside it.
_WHITE = NoiseModel(np.zeros(0), 1.0)


def tone_above_band(stretches: Sequence[Signals], i: int) -> Check | None:
    """
    Return the strongest tone of a joint's effort above the band, in the longest stretch.

    None where there is none beyond chance, or it is next to nothing of what is above the band. The
    effort of a tone A sin(2 pi f t) is |2 / N sum tau exp(-2 pi i f t)| = A, of N samples.
    """
    longest = max(stretches, key=lambda s: len(s.time))
    band, tau = longest.band, longest.tau[:, i]
    nyquist = 0.5 / band.step
    fast = tau - band.smooth(tau, 1.0)
    tone = strongest_tone(fast, _WHITE, band.step, nyquist, band.cutoff)
    if not (tone.chance < CHANCE and tone.share > NEGLIGIBLE):
        return None
    turn = np.exp(-2j * np.pi * tone.hertz * band.step * np.arange(len(tau)))
    size = float(np.abs(2.0 / len(tau) * (turn @ (tau - tau.mean()))))
    name, unit = longest.robot.names[i], longest.robot.effort_units[i]
    return Check(
        'tone',
        'warning',
        name,
        f'the effort of {name} has a tone of {tone.hertz:.1f} Hz and {size:.3g} {unit}, as of '
        f'mains, a drive or a resonance: it is above the band of {band.cutoff:.0f} Hz, where nothing is '
        'looked for',
        {'hertz': tone.hertz, 'size': size},
    )
