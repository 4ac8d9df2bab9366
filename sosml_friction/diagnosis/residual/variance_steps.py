# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the unexplained variance goes: to the causes, to noise, or nowhere."""

from typing import Literal, NamedTuple

import numpy as np
from scipy.signal import lfilter

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.regression.noise_model import NoiseModel

#: Length of an impulse response that is long beside any noise's memory.
_RESPONSE = 4000


class Step(NamedTuple):
    """Hold one step: from ``low`` to ``high``, in percent of the variance at the start."""

    label: str
    low: float
    high: float
    kind: Literal['start', 'cause', 'rest', 'noise']


def noise_variance(noise: NoiseModel) -> float:
    """Return the variance of such noise: the energy of its impulse response times sigma^2."""
    impulse = np.zeros(_RESPONSE)
    impulse[0] = noise.sigma
    response = lfilter([1.0], np.concatenate([[1.0], -noise.coefficients]), impulse)
    return float(np.sum(np.asarray(response) ** 2))


def variance_steps(diagnosis: Diagnosis, i: int) -> list[Step]:
    """
    Return the steps of a joint, from the variance the refitted model leaves to what is left.

    On folds left out. Noise is what the whole catalogue and the free curves leave: an estimate
    from below. A stage that leaves more than the one before is part of the rest.
    """
    laboratory = diagnosis.laboratory
    assert laboratory is not None
    name = diagnosis.names[i]
    error = [stage['relative_error_percent'][name] ** 2 for stage in diagnosis.stages]
    whole = max(error[0], 1e-300)
    shares = [100.0 * x / whole for x in error]
    steps = [Step('refitted model', 0.0, 100.0, 'start')]
    for k, stage in enumerate(diagnosis.stages[1:], 1):
        where = '' if stage['joint'] == name else f' ({stage["joint"]})'
        label = f'{stage["effect"].replace("_", " ")}{where}'
        low, high = sorted((shares[k - 1], shares[k]))
        kind: Literal['cause', 'rest'] = 'cause' if shares[k] <= shares[k - 1] else 'rest'
        steps.append(Step(label, low, high, kind))
    tau = np.concatenate([s.band.apply(s.tau[:, i]) for s in laboratory.signals])
    unit = 1e4 / max(float(np.mean(tau**2)), 1e-300)
    noise = min(100.0 * noise_variance(laboratory.noise[i]) * unit / whole, shares[-1])
    steps.append(Step('unexplained', noise, shares[-1], 'rest'))
    steps.append(Step('noise', 0.0, noise, 'noise'))
    return steps
