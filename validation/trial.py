# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Draw a hidden effect from a seed, and hide it: what the blind tests ask the diagnosis for."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory
from validation import plant as bp
from validation.effects import FAULTS, GLOBAL, OUTSIDE, TRANSMISSION, TYPICAL, hide, where
from validation.motion import JOINTS, reference
from validation.snr import USUAL_BAND, beyond_tolerance, residual, signal_to_noise

__all__ = [
    'FAULTS', 'GLOBAL', 'JOINTS', 'OUTSIDE', 'SINGLES', 'TRANSMISSION', 'TYPICAL', 'Spec', 'Trial',
    'build', 'make_trial', 'nominal_model', 'reference',
]  # fmt: skip

#: What single trials hide: encoder eccentricity is below the noise, thermal drift needs its own.
SINGLES = tuple(e for e in TYPICAL if e not in ('encoder_eccentricity', 'thermal_drift'))
#: Smallest share of the typical size, shoulder and elbow: the lower end of what joints of this
#: class have, and more than the 1 to 3 % by which every nominal
#: parameter is off in any trial. Coulomb 12 %, viscous 18 %, breakaway 10 % of Coulomb, asymmetry
#: 5 %, load 0.03, position 5 % of Coulomb, ripple 20 and 5 mNm, 0.9 mrad to build up, at most
#: 5 kNm/rad, gap 1 mrad, effort 4 %, saturation 2 %, bias 20 mNm, delay 0.5 ms, gravity about 5 %,
#: tilt 1 degree, inertia 0.02 and 0.005 kg m2, 0.1 kg, coupling 2 %, spring 0.05 Nm/rad.
LEAST = {
    'coulomb': (0.4, 0.4), 'viscous': (0.45, 0.45), 'stribeck': (0.25, 0.25),
    'asymmetric_friction': (0.4, 0.4), 'load_dependent_friction': (0.5, 0.5),
    'position_dependent_friction': (0.2, 0.2), 'cogging': (0.17, 0.17),
    'presliding_hysteresis': (0.2, 0.2), 'joint_elasticity': (0.3, 0.1),
    'backlash': (0.25, 0.25), 'effort_scale': (0.5, 0.5), 'effort_saturation': (0.33, 0.33),
    'effort_bias': (0.14, 0.33), 'effort_delay': (0.125, 0.125), 'gravity': (0.6, 0.6),
    'gravity_tilt': (0.3, 0.3), 'inertia': (0.4, 0.4), 'payload': (0.4, 0.4),
    'joint_coupling': (0.25, 0.25), 'spring': (0.125, 0.33), 'hysteresis': (0.3, 0.3),
}  # fmt: skip
#: Range in which the SNR of each bin is drawn; a trial reports the SNR that resulted.
BINS = {'high': (0.63, np.inf), 'middle': (0.37, 0.58), 'low': (0.12, 0.33)}
#: Least SNR of a twin beyond the tolerance of the nominal: the lower end of the bins that have a
#: bar. An effect that a nominal within its tolerance explains is no cause, and needs no set.
VISIBLE = 0.35
#: Shares of the typical size: drawn from, and the widest that fills a bin.
USUAL, WIDEST = (0.4, 1.6), (0.02, 8.0)
#: The recording on which the gain is measured: motion and length [s].
HOLDOUT = ('other', 60.0)


@dataclass(frozen=True)
class Spec:
    """
    State everything that makes a trial; nothing else goes into it.

    ``level``: the bin of SNR to draw the size for, None where ``scale`` gives it, or the usual
    range. ``noise``: usual, double or other (colour); ``nuisance``: largest error of a nominal
    parameter; ``shuffled``: blocks of the residual change places. ``without``: effects that the
    diagnosis does without. ``duration`` [s].
    """

    name: str
    kind: str
    seed: int
    effect: str | None = None
    joint: int | None = None
    second: str | None = None
    level: str | None = None
    scale: float | None = None
    motion: str = 'rich'
    duration: float | None = None
    noise: str = 'usual'
    nuisance: tuple[float, float] = (0.01, 0.03)
    shuffled: bool = False
    moving: bool = False
    holdout: bool = False
    without: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self)


@dataclass(frozen=True)
class Truth:
    """Hold one hidden effect: ``joint`` as the answer names it, ``size`` in its own unit."""

    effect: str
    joint: str
    size: float


@dataclass
class Trial:
    """
    Hold what was hidden and what it left in the data.

    ``exact``: the plant without nuisance; ``plant``: with it; ``holdout``: another recording of
    it.
    """

    spec: Spec
    truths: tuple[Truth, ...]
    log: JointLog
    exact: bp.Plant
    noise: bp.Noise
    plant: bp.Plant
    holdout: JointLog | None = None

    @property
    def effect(self) -> str:
        """Return the first hidden effect, or none."""
        return self.truths[0].effect if self.truths else 'none'

    @property
    def joint(self) -> str:
        """Return the joint of the first, '*' where there is none."""
        return self.truths[0].joint if self.truths else '*'

    @property
    def size(self) -> float:
        """Return the size of the first."""
        return self.truths[0].size if self.truths else 0.0

    def snr(self, band_hz: float) -> float | None:
        """Return the SNR in the joint of the first effect, or the largest of a whole robot's."""
        if not self.truths or self.effect in FAULTS:
            return None
        spec = self.spec
        both = signal_to_noise(self.exact, spec.motion, spec.duration, self.noise, band_hz)
        return float(both.max() if self.joint == '*' else both[JOINTS.index(self.joint)])


def nominal_model() -> RobotModelFile:
    """Return the exoskeleton with the friction the plant has where nothing is hidden."""
    shipped = read_model(share_directory() / 'config/exoskeleton')
    joints = {}
    for i, name in enumerate(JOINTS):
        parameters = {
            'coulomb': Parameter(float(bp.COULOMB[i]), 'Nm'),
            'viscous': Parameter(float(bp.VISCOUS[i]), 'Nm s/rad'),
            'bias': Parameter(0.0, 'Nm'),
        }
        friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
        joints[name] = JointModel(shipped.joints[name].armature, friction)
    return RobotModelFile('blind', joints, shipped.urdf)


def nuisance(rng: np.random.Generator, least: float = 0.01, largest: float = 0.03) -> bp.Plant:
    """Return a plant whose every nominal parameter is off by ``least`` to ``largest``."""

    def off(shape: tuple[int, ...] = ()) -> Any:
        return 1.0 + rng.uniform(least, largest, shape) * rng.choice([-1, 1], shape)

    plant = bp.Plant()
    plant.first *= float(off())
    plant.second *= float(off())
    plant.mass_2 *= float(off())
    plant.inertia = (plant.inertia[0] * float(off()), plant.inertia[1] * float(off()))
    for name in ('coulomb', 'viscous', 'armature'):
        plant.joint[name] = plant.joint[name] * off((2,))
    return plant


def scale_of_snr(spec: Spec, i: int, noise: bp.Noise, wanted: float) -> float:
    """Return the share of the typical size that makes an SNR, by a few secant steps."""
    scale = 1.0
    for _ in range(5):
        found = _snr(spec, i, noise, scale)
        if abs(found / wanted - 1.0) < 0.02:
            break
        scale = float(np.clip(scale * wanted / max(found, 1e-6), *WIDEST))
    return scale


def least_visible_scale(spec: Spec, i: int, noise: bp.Noise) -> float:
    """
    Return the smallest share of the typical size of which VISIBLE stays beyond tolerance.

    :raises ValueError: if not even the largest does.
    """
    low, high = np.log(USUAL[0]), np.log(WIDEST[1])
    for _ in range(8):
        scale = float(np.exp(0.5 * (low + high)))
        plant = _exact(spec, i, scale)
        found = beyond_tolerance(plant, spec.motion, spec.duration, noise, USUAL_BAND)
        low, high = (low, np.log(scale)) if found > VISIBLE else (np.log(scale), high)
    if high == np.log(WIDEST[1]):
        raise ValueError(f'{spec.effect} is never seen along {spec.motion}')
    return float(np.exp(high))


def _snr(spec: Spec, i: int, noise: bp.Noise, scale: float) -> float:
    assert spec.effect is not None
    plant = _exact(spec, i, scale)
    both = signal_to_noise(plant, spec.motion, spec.duration, noise, USUAL_BAND)
    joint = where(spec.effect, i)
    return float(both.max() if joint == '*' else both[JOINTS.index(joint)])


def _exact(spec: Spec, i: int, scale: float) -> bp.Plant:
    """Return a plant that hides the first effect of a trial, and is the nominal otherwise."""
    assert spec.effect is not None
    plant = bp.Plant()
    _hide(plant, spec, 0, spec.effect, i, scale)
    return plant


def _hide(plant: bp.Plant, spec: Spec, k: int, effect: str, i: int, scale: float) -> float:
    """Hide the k-th effect of a trial, alike in every plant, and return its size."""
    duration = len(reference(spec.motion, spec.duration)[0]) * bp.PERIOD
    return hide(plant, effect, i, scale, np.random.default_rng([spec.seed, 2, k]), duration)


def draw_scale(spec: Spec, i: int, noise: bp.Noise, rng: np.random.Generator) -> float:
    """Return the share of the typical size: as given, log-uniform, or for a bin of SNR."""
    u = float(rng.uniform())
    if spec.scale is not None:
        return spec.scale
    assert spec.effect is not None
    smallest = LEAST.get(spec.effect, (0.0, 0.0))[i]
    low, high = max(USUAL[0], smallest), USUAL[1]
    if spec.level is not None and spec.effect not in FAULTS:
        least, most = BINS[spec.level]
        # The same effect is as large in other motions: the bin is that of the rich one.
        rich = replace(spec, motion='rich', duration=None)
        if spec.kind == 'twin':
            low = max(low, least_visible_scale(spec, i, noise))
            high = max(high, 1.3 * low)
        elif spec.level == 'high':
            low = max(low, scale_of_snr(rich, i, noise, least))
            high = max(high, 1.3 * low)
        else:
            if smallest:
                least = max(least, min(_least_snr(spec.effect, i), most))
            wanted = float(least * (most / least) ** u)
            return max(scale_of_snr(rich, i, noise, wanted), smallest)
    return float(low * (high / low) ** u)


def reaches(effect: str, joint: int, level: str) -> bool:
    """Tell whether an effect of a size that occurs can have so small an SNR."""
    if effect not in LEAST or level == 'high':
        return True
    return _least_snr(effect, joint) < BINS[level][1]


@lru_cache(maxsize=64)
def _least_snr(effect: str, joint: int) -> float:
    return _snr(Spec('', '', 0, effect), joint, bp.Noise(), LEAST[effect][joint])


def build(spec: Spec) -> Trial:
    """Return the trial that a spec describes."""
    rng = np.random.default_rng([spec.seed, 20261121])
    plant, exact = nuisance(rng, *spec.nuisance), bp.Plant()
    noise = {
        'usual': bp.Noise(),
        'double': bp.Noise(2.0, 2.0),
        'other': bp.Noise(0.7, 2.0, float(rng.choice([0.03, 1.0]))),
    }[spec.noise]
    truths = []
    draw = np.random.default_rng([spec.seed, 1])
    for k, effect in enumerate((spec.effect, spec.second)):
        if effect is None or effect in FAULTS:
            continue
        i = int(draw.integers(2)) if spec.joint is None or k else spec.joint
        scale = draw_scale(spec, i, noise, draw)
        if spec.second is not None:
            # Two effects have a size each, 0.3 typical or more.
            least = max(0.3, LEAST.get(effect, (0.0, 0.0))[i])
            scale = float(np.exp(draw.uniform(np.log(least), np.log(1.6))))
        for body in (exact, plant):
            size = _hide(body, spec, k, effect, i, scale)
        truths.append(Truth(effect, where(effect, i), size))
    motion = reference(spec.motion, spec.duration)
    run = bp.simulate(plant, *motion, np.random.default_rng([spec.seed, 3]), noise)
    if spec.moving:
        # Without the rest before and after.
        still = round(3.0 / bp.PERIOD)
        run = bp.Run(*(x[still:-still] for x in (run.t, run.q, run.v, run.tau)))
    if spec.shuffled:
        run = _shuffled(run, np.random.default_rng([spec.seed, 5]))
        truths = []
    log = _log(run)
    if spec.effect in FAULTS:
        log, truth = _faulty(log, run, spec)
        truths = [truth]
    holdout = None
    if spec.holdout:
        other = np.random.default_rng([spec.seed, 4])
        holdout = _log(bp.simulate(plant, *reference(*HOLDOUT), other, noise))
    return Trial(spec, tuple(truths), log, exact, noise, plant, holdout)


def _log(run: bp.Run) -> JointLog:
    return JointLog(JOINTS, np.rint(run.t * 1e9).astype(np.int64), run.q, run.v, run.tau)


def _shuffled(run: bp.Run, rng: np.random.Generator, block_s: float = 4.0) -> bp.Run:
    """
    Return a run with the blocks of its effort's residual in another order: real, without a cause.

    The mean is removed, because shuffling keeps it, and a constant by errors of gravity is a bias.
    """
    step = round(block_s / bp.PERIOD)
    # All of the residual, hence a band that is none; the noise of position is smoothed off.
    usual = run.tau - residual(run, None)
    left = run.tau - usual
    left = left - left.mean(axis=0)
    count = len(run.t) // step
    order = rng.permutation(count)
    moved = left.copy()
    for new, old in enumerate(order):
        moved[new * step : (new + 1) * step] = left[old * step : (old + 1) * step]
    return replace(run, tau=usual + moved)


def _faulty(log: JointLog, run: bp.Run, spec: Spec) -> tuple[JointLog, Truth]:
    """Return a log with a fault of the data in it."""
    rng = np.random.default_rng([spec.seed, 6])
    assert spec.effect is not None
    scale = spec.scale or float(np.exp(rng.uniform(*np.log(USUAL))))
    size = scale * FAULTS[spec.effect][0]
    i = int(rng.integers(2)) if spec.joint is None else spec.joint
    if spec.effect == 'velocity_lag':
        # A first-order filter of the drive, as late as its time constant.
        v = run.v.copy()
        share = 1.0 - np.exp(-bp.PERIOD / size)
        for k in range(1, len(v)):
            v[k, i] = v[k - 1, i] + share * (run.v[k, i] - v[k - 1, i])
        return replace(log, v=v), Truth(spec.effect, JOINTS[i], size)
    hit = np.flatnonzero(rng.uniform(size=len(run.t) - 2) < size) + 1
    if rng.uniform() < 0.5:
        keep = np.delete(np.arange(len(run.t)), hit)
        log = JointLog(JOINTS, log.t_ns[keep], log.q[keep], log.v[keep], log.tau[keep])
    else:
        # The sample before once more, under a stamp of its own.
        source = np.arange(len(run.t))
        source[hit] -= 1
        log = replace(log, q=log.q[source], v=log.v[source], tau=log.tau[source])
    return log, Truth(spec.effect, '*', size)


def make_trial(
    seed: int, effect: str | None = None, trajectory: str = 'rich', scale: float | None = None,
    joint: int | None = None, noise: float = 1.0, duration: float | None = None,
    second: str | None = None,
) -> Trial:  # fmt: skip
    """Return a trial; ``effect`` None hides nothing, ``draw`` one at random."""
    if effect == 'draw':
        effect = str(np.random.default_rng([seed, 7]).choice(SINGLES))
    kind = 'null' if effect is None else 'single'
    return build(
        Spec(
            f'{kind}-{seed}', kind, seed, effect, joint, second, None, scale, trajectory, duration,
            'double' if noise == 2.0 else 'usual',
        )
    )  # fmt: skip
