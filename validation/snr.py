# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
How large a hidden effect is against the noise, and what the true model would leave.

The residual is measured effort minus the closed-form nominal (with the plant's own slip elements,
no nuisance) on the measured motion, seen in the diagnosis's band. Noise is its root mean square
where nothing is hidden: noise of effort, and of position through the inertia. The effect is the
difference of two residuals that are measured exactly, with the effect and without, so that the
noise, the same in both, cancels. Its mean is part of it: a bias is nothing but mean.

    SNR = rms(effect) / rms(noise), per joint.

A nominal model that is off within its tolerance explains a part of an effect, and all of a small
one: in one posture a bias is the same as a little more mass. The effect beyond the tolerance is
the least that any such nominal leaves of it, both joints together.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.optimize import lsq_linear

from sosml_friction.compiled import compiled
from sosml_friction.model.finite_differences import first_derivative
from sosml_friction.regression.band import Band
from validation import plant as bp
from validation.motion import reference

#: Band that the diagnosis chooses for the default noise [Hz]. A trial's SNR is drawn in it, and
#: reported in the band that the diagnosis used.
USUAL_BAND = 22.5
#: By how much a nominal parameter may be off without a cause (docs/diagnosis.md), a bias by that
#: share of Coulomb friction; first moments are turned by 0.3 of it.
TOLERANCE, _ASKEW = 0.035, 0.3


@compiled
def _nominal(q, v, a, body, slip):
    """Return the nominal effort (N, 2) along a measured motion."""
    share = np.array([0.4, 0.3, 0.2, 0.1])
    width = np.array([0.5, 1.0, 1.6, 2.5])
    z = np.zeros((2, 4))
    tau = np.empty_like(q)
    for k in range(len(q)):
        tau[k, 0], tau[k, 1] = bp.effort_of(body, q[k], v[k], a[k], bp.ARMATURE)
        for i in range(2):
            dx = q[k, i] - q[k - 1, i] if k else 0.0
            state = 0.0
            for j in range(4):
                w = width[j] * slip
                z[i, j] = min(max(z[i, j] + dx, -w), w)
                state += share[j] * z[i, j] / w
            tau[k, i] += bp.COULOMB[i] * state + bp.VISCOUS[i] * v[k, i]
    return tau


def residual(run: bp.Run, band_hz: float | None) -> np.ndarray:
    """Return measured minus nominal effort in the band, (rows, 2); for None all of it, (N, 2)."""
    band = Band(band_hz or USUAL_BAND, bp.PERIOD)
    q = band.smooth(run.q)
    v = first_derivative(q, bp.PERIOD)
    a = first_derivative(v, bp.PERIOD)
    left = run.tau - _nominal(q, v, a, bp.Plant().body(), bp.SLIP)
    return left if band_hz is None else band.apply(left)


def rms(x: np.ndarray) -> np.ndarray:
    """Return the root mean square of each column."""
    return np.sqrt(np.mean(x**2, axis=0))


@lru_cache(maxsize=16)
def _nothing_hidden(motion: str, duration: float | None, soft: bool, noise: bp.Noise | None):
    """Return what is measured of the exact nominal plant; exactly so without ``noise``."""
    rng = np.random.default_rng(20261121)
    return bp.simulate(
        bp.Plant(soft=soft), *reference(motion, duration), rng, noise or bp.Noise(exact=True)
    )


@lru_cache(maxsize=64)
def noise_rms(
    motion: str, duration: float | None, soft: bool, noise: bp.Noise, band_hz: float
) -> tuple[float, float]:
    """Return what the true model leaves of a recording, by joint [Nm]."""
    left = rms(residual(_nothing_hidden(motion, duration, soft, noise), band_hz))
    return float(left[0]), float(left[1])


def _effect(plant: bp.Plant, motion: str, duration: float | None, band_hz: float) -> np.ndarray:
    """Return what ``plant``, without nuisance, adds to the effort in the band, (rows, 2)."""
    on = bp.simulate(
        plant, *reference(motion, duration), np.random.default_rng(0), bp.Noise(exact=True)
    )
    off = _nothing_hidden(motion, duration, plant.two_mass or plant.soft, None)
    return residual(on, band_hz) - residual(off, band_hz)


@lru_cache(maxsize=8)
def _tolerated(motion: str, duration: float | None, soft: bool, band_hz: float) -> np.ndarray:
    """Return what each nominal parameter does where it is off by its tolerance, (rows, 2, p)."""
    off = bp.Plant(soft=soft)
    plants = []
    for name in ('first', 'second', 'mass_2'):
        plants.append(replace(off, **{name: getattr(off, name) * (1.0 + TOLERANCE)}))
    for i in range(2):
        share = np.where(np.arange(2) == i, TOLERANCE, 0.0)
        plants.append(replace(off, inertia=tuple(np.array(off.inertia) * (1.0 + share))))
        plants.append(replace(off, bias=share * bp.COULOMB))
        for name in ('coulomb', 'viscous', 'armature'):
            joint = {**off.joint, name: off.joint[name] * (1.0 + share)}
            plants.append(replace(off, joint=joint))
    plants.append(replace(off, tilt=_ASKEW * TOLERANCE))
    effects = [_effect(plant, motion, duration, band_hz) for plant in plants]
    return np.stack(effects, axis=-1)


def beyond_tolerance(
    plant: bp.Plant, motion: str, duration: float | None, noise: bp.Noise, band_hz: float
) -> float:
    """Return the SNR of what no nominal within its tolerance takes up, in its best joint."""
    soft = plant.two_mass
    effect = _effect(plant, motion, duration, band_hz)
    size = np.array(noise_rms(motion, duration, soft, noise, band_hz))
    columns = _tolerated(motion, duration, soft, band_hz)
    A = (columns / size[:, None]).reshape(-1, columns.shape[-1])
    taken = lsq_linear(A, (effect / size).ravel(), bounds=(-1.0, 1.0)).x
    return float((rms(effect - columns @ taken) / size).max())


def signal_to_noise(
    plant: bp.Plant, motion: str, duration: float | None, noise: bp.Noise, band_hz: float
) -> np.ndarray:
    """Return the SNR by joint (2,) of what ``plant``, without nuisance, hides."""
    effect = rms(_effect(plant, motion, duration, band_hz))
    return effect / np.array(noise_rms(motion, duration, plant.two_mass, noise, band_hz))
