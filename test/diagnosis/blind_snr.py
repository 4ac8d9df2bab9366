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

Of an effect a nominal that is off within its tolerance takes up a part, and a small one whole: a
bias along a motion of one posture is a little more mass. What stays beyond the tolerance is the
least that any such nominal leaves of the effect, both joints together.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import blind_plant as bp
import numpy as np
from blind_motion import reference
from numba import njit
from scipy.optimize import lsq_linear

from sosml_friction.diagnosis.band import Band, first_derivative

#: The band that the diagnosis chooses for the default noise, [Hz]; SNR is drawn in it, and
#: stated in the one that was used.
USUAL_BAND = 22.5
#: By how much a nominal parameter may be off without a cause (docs/diagnosis.md), a bias by that
#: share of Coulomb friction; first moments are turned by 0.3 of it.
TOLERANCE, _ASKEW = 0.035, 0.3


@njit(cache=True)
def _nominal(q, v, a, slip):
    """Return the nominal effort (N, 2) along a measured motion."""
    share = np.array([0.4, 0.3, 0.2, 0.1])
    width = np.array([0.5, 1.0, 1.6, 2.5])
    z = np.zeros((2, 4))
    tau = np.empty_like(q)
    for k in range(len(q)):
        c2, s2 = np.cos(q[k, 1]), np.sin(q[k, 1])
        m12 = bp.I2 + bp.L1 * bp.C2 * c2
        m11 = bp.I1 + bp.I2 + bp.M2 * bp.L1**2 + 2.0 * bp.L1 * bp.C2 * c2 + bp.ARMATURE[0]
        m22 = bp.I2 + bp.ARMATURE[1]
        h = bp.L1 * bp.C2 * s2
        g1 = bp.GRAVITY * bp.C2 * np.cos(q[k, 0] + q[k, 1])
        g0 = bp.GRAVITY * (bp.C1 + bp.M2 * bp.L1) * np.cos(q[k, 0]) + g1
        v0, v1 = v[k, 0], v[k, 1]
        tau[k, 0] = m11 * a[k, 0] + m12 * a[k, 1] - h * (2.0 * v0 * v1 + v1**2) + g0
        tau[k, 1] = m12 * a[k, 0] + m22 * a[k, 1] + h * v0**2 + g1
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
    left = run.tau - _nominal(q, v, a, bp.SLIP)
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
    exactly = residual(_nothing_hidden(motion, duration, soft, None), band_hz)
    columns = []
    for plant in plants:
        rng = np.random.default_rng(0)
        run = bp.simulate(plant, *reference(motion, duration), rng, bp.Noise(exact=True))
        columns.append(residual(run, band_hz) - exactly)
    return np.stack(columns, axis=-1)


def beyond_tolerance(
    plant: bp.Plant, motion: str, duration: float | None, noise: bp.Noise, band_hz: float
) -> float:
    """Return the SNR of what no nominal within its tolerance takes up, in its best joint."""
    soft = plant.two_mass
    rng = np.random.default_rng(0)
    on = bp.simulate(plant, *reference(motion, duration), rng, replace(noise, exact=True))
    effect = residual(on, band_hz)
    effect = effect - residual(_nothing_hidden(motion, duration, soft, None), band_hz)
    size = np.array(noise_rms(motion, duration, soft, noise, band_hz))
    columns = _tolerated(motion, duration, soft, band_hz)
    A = (columns / size[:, None]).reshape(-1, columns.shape[-1])
    taken = lsq_linear(A, (effect / size).ravel(), bounds=(-1.0, 1.0)).x
    return float((rms(effect - columns @ taken) / size).max())


def signal_to_noise(
    plant: bp.Plant, motion: str, duration: float | None, noise: bp.Noise, band_hz: float
) -> np.ndarray:
    """Return the SNR by joint (2,) of what ``plant``, without nuisance, hides."""
    on = bp.simulate(
        plant, *reference(motion, duration), np.random.default_rng(0), replace(noise, exact=True)
    )
    off = _nothing_hidden(motion, duration, plant.two_mass, None)
    effect = rms(residual(on, band_hz) - residual(off, band_hz))
    return effect / np.array(noise_rms(motion, duration, plant.two_mass, noise, band_hz))
