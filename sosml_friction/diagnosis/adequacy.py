# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a named cause is the whole of what acts along its own axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.evidence import (
    Score,
    System,
    Target,
    fit_baseline,
    score,
)
from sosml_friction.diagnosis.kernels import hats
from sosml_friction.diagnosis.laboratory import Laboratory
from sosml_friction.diagnosis.signals import Signals
from sosml_friction.simulation.dahl import dahl_path

if TYPE_CHECKING:
    from sosml_friction.diagnosis.selection import Finding

_HATS = 6
#: Lowest knot of speed, as a share of the top speed: below it is the turning around.
_SLOWEST = 0.04
#: Displacement of the sign as shares of the fitted one, and smoothing of position, of the ways in
#: which friction may turn around at a reversal.
_TURNS = ((0.3, 1.0), (2.0, 1.0), (1.0, 3.0))
#: Axis along which each effect says how effort depends on it.
AXES: Mapping[str, str] = {
    'coulomb': 'speed',
    'viscous': 'speed',
    'stribeck': 'speed',
    'presliding_hysteresis': 'speed',
    'thermal_drift': 'speed',
}
#: Axes that no cause has.
NEIGHBOURS = 'the position of the next joint'
NEIGHBOUR_FRICTION = 'friction by the position of the next joint'
_BY_NEIGHBOURS = (NEIGHBOURS, NEIGHBOUR_FRICTION)
#: The axis of a curve of position that repeats nowhere, the causes that it could make up, and the
#: share of what it and they explain from which on they are not the whole.
POSITION = 'position'
_BY_POSITION = ('spring', 'gravity', 'encoder_eccentricity')
_POSITION_HATS, _POSITION_SHARE = 8, 0.1
#: Causes by speed that a single other power of it could stand for, and the powers tried.
_BY_SPEED = ('coulomb', 'viscous', 'stribeck')
_POWERS = (0.3, 0.5, 0.7, 1.4, 2.0, 3.0)
#: That power has to explain more by this, and by this share, beside the price of the parameters.
_MORE, _MORE_SHARE = 10.0, 0.005


class Reversal(Effect):
    """Add the differences between ways to turn around at a reversal and the fitted one."""

    identifier: ClassVar[str] = 'reversal'
    amplitudes: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ('faster', 'slower', 'smoother'), '{effort}'
    )

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the differences of the sign."""
        scale = float(signals.scales.displacement[joint])
        columns = []
        for share, wider in _TURNS:
            q = signals.q[:, joint : joint + 1]
            if wider != 1.0:
                q = signals.band.smooth(q, wider)
            z = dahl_path(np.ascontiguousarray(q[:, 0]), share * scale)
            columns.append(z - signals.sign[:, joint])
        return signals.in_joint(joint, *columns)


class SpeedPower(Effect):
    """Add s |q'|^p: friction by speed that is neither Coulomb's nor viscous, in one term."""

    identifier: ClassVar[str] = 'power_of_speed'
    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'power': '1'}

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return powers well away from 0 and 1, which have names."""
        return [{'power': p} for p in _POWERS]

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s (|q'| / top speed)^p."""
        speed = np.abs(signals.v[:, joint]) / float(signals.scales.speed[joint])
        return signals.in_joint(joint, signals.sign[:, joint] * speed ** inner['power'])


class SpeedCurve(Effect):
    """Add s f(|q'|) with any piecewise linear f: what friction by speed could explain at most."""

    identifier: ClassVar[str] = 'speed'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(_HATS)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s times hat functions on knots of |q'| in geometric steps."""
        speed = np.abs(signals.v[:, joint])
        knots = float(signals.scales.speed[joint]) * np.geomspace(_SLOWEST, 1.0, _HATS)
        s = signals.sign[:, joint]
        return signals.in_joint(
            joint, *(s * np.interp(speed, knots, hat) for hat in np.eye(_HATS))
        )


class PositionCurve(Effect):
    """Add f(q) with any piecewise linear f: a spring that is not straight, a cable, a stop."""

    identifier: ClassVar[str] = 'position'
    amplitudes: ClassVar[Mapping[str, str]] = {
        f'hat_{k}': '{effort}' for k in range(_POSITION_HATS)
    }

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q, (N, n, hats)."""
        result = np.zeros((len(signals.q), signals.robot.n, _POSITION_HATS))
        x = np.ascontiguousarray(signals.q[:, joint])
        knots = np.unique(np.quantile(x, np.linspace(0.01, 0.99, _POSITION_HATS)))
        result[:, joint, : len(knots)] = hats(x, knots)
        return result


class NeighbourCurve(Effect):
    """Add f(q_k) + s g(q_k), q_k of the joint before and after: no cause of the catalogue does."""

    identifier: ClassVar[str] = 'neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(4 * _HATS)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q_k, and s times each, (N, n, 4 hats)."""
        result = np.zeros((len(signals.q), signals.robot.n, 4 * _HATS))
        s = signals.sign[:, joint]
        first = 0
        for k in _neighbours(signals.robot.n, joint):
            x = np.ascontiguousarray(signals.q[:, k])
            knots = np.unique(np.quantile(x, np.linspace(0.01, 0.99, _HATS)))
            hat = hats(x, knots)
            result[:, joint, first : first + len(knots)] = hat
            first += _HATS
            result[:, joint, first : first + len(knots)] = hat * s[:, None]
            first += _HATS
        return result


class NeighbourFriction(Effect):
    """
    Add s (a x_k + b x_k^2), x_k where the joint before and after is: friction that follows them.

    x_k is q_k in halves of its range over all recordings; beside a free s its origin is any. The
    curves above hold it too, among so many others that a little of it is lost in their chance.
    """

    identifier: ClassVar[str] = 'friction_by_neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'power_{k}': '{effort}' for k in range(4)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the powers, (N, n, 4), the last two zero where there is one neighbour."""
        result = np.zeros((len(signals.q), signals.robot.n, 4))
        s = signals.sign[:, joint]
        for k, other in enumerate(_neighbours(signals.robot.n, joint)):
            x = 2.0 * signals.q[:, other] / float(signals.scales.span[other])
            result[:, joint, 2 * k] = s * x
            result[:, joint, 2 * k + 1] = s * x**2
        return result


class FreeLevel(Effect):
    """Add s: Coulomb friction without the bounds of the nominal's, beside what modulates it."""

    identifier: ClassVar[str] = 'level'
    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s."""
        return signals.in_joint(joint, signals.sign[:, joint])


def _neighbours(n: int, joint: int) -> list[int]:
    return [k for k in (joint - 1, joint + 1) if 0 <= k < n]


@dataclass(frozen=True)
class Leftover:
    """
    Hold what a free curve along an axis of a joint still predicts beside the named causes.

    ``gain``: whitened energy it removes, ``energy``: on data left out; ``floor``: what ``gain``
    has to exceed, from recordings simulated without anything more; ``share``: ``gain`` of all
    that the causes of this axis and the curve explain together. ``instead``: it is one power of
    speed that explains more than all the named causes by speed, in their stead. ``foreign``: the
    curve is one that no cause of the catalogue has. ``least``: the share from which on the causes
    are not the whole.
    """

    axis: str
    joint: int
    gain: float
    energy: float
    floor: float
    share: float
    least: float
    instead: bool = False
    foreign: bool = False

    @property
    def significant(self) -> bool:
        """Tell whether it is beyond chance, and too much for the causes to be the whole."""
        return self.gain > self.floor and self.energy > 0.0 and self.share > self.least


def leftovers(
    laboratory: Laboratory,
    accepted: Sequence[Finding],
    credible: Callable[[FloatArray, System], FloatArray],
) -> tuple[Leftover, ...]:
    """
    Return what a free curve still predicts beside the causes of each joint with such an axis.

    Friction that turns around in another way at reversals is taken out of both sides first. The
    floor is ``axis_margin`` times the largest gain over simulated recordings that hold the
    accepted causes, nominal deviations, other turning around and noise, and nothing else.

    :param credible: scales a variant of friction to what the data show beside a system.
    """
    n = laboratory.robot.n
    own = [f for f in accepted if not f.effect.of_robot]
    probes: list[tuple[str, int, Effect, list[Finding]]] = []
    for i in range(n):
        mine = [f for f in own if f.joint == i]
        by_speed = [f for f in mine if f.effect.identifier in AXES]
        if by_speed:
            probes.append(('speed', i, SpeedCurve(), by_speed))
        by_position = [f for f in mine if f.effect.identifier in _BY_POSITION]
        if by_position:
            probes.append((POSITION, i, PositionCurve(), by_position))
        if mine and n > 1:
            probes.append((NEIGHBOURS, i, NeighbourCurve(), mine))
            probes.append((NEIGHBOUR_FRICTION, i, NeighbourFriction(), mine))
    if not probes:
        return ()
    joints = sorted({i for _, i, _, _ in probes})
    turns = [laboratory.single(Reversal(), i, {}) for i in joints]
    system = laboratory.system.extended([*(f.columns for f in accepted), *turns])
    # Beside a joint that hardly moves, what follows it is a constant: of Coulomb friction.
    free = system.extended([laboratory.single(FreeLevel(), i, {}) for i in joints])
    beside = [free if axis in _BY_NEIGHBOURS else system for axis, _, _, _ in probes]
    curves = [
        laboratory.single(effect, i, {}).beside(its)
        for (_, i, effect, _), its in zip(probes, beside, strict=True)
    ]

    def gains(y: FloatArray) -> list[Score]:
        fits = []
        for its in (system, free):
            target = Target.make(its, y)
            fits.append((target, fit_baseline(its, target)))
        result = []
        for its, curve in zip(beside, curves, strict=True):
            target, base = fits[its is free]
            result.append(score(its, target, base, curve, curve.products(its, y)))
        return result

    base = fit_baseline(system, Target.make(system, laboratory.y))
    found = gains(laboratory.y)
    settings = laboratory.settings
    rng = np.random.default_rng([settings.seed, 1000 + len(accepted)])
    largest = np.zeros(len(probes))
    p = len(laboratory.nominal.bound)
    bounded = np.isfinite(laboratory.nominal.bound)
    for _ in range(settings.axis_nulls):
        x = np.array(base.x)
        x[:p][bounded] = (
            rng.uniform(-0.9, 0.9, int(bounded.sum())) * laboratory.nominal.bound[bounded]
        )
        y = np.einsum('tip,p->ti', system.Z, x, optimize=True)
        y += credible(laboratory.friction_variants(rng), system)
        y += laboratory.white(rng)
        largest = np.maximum(largest, [s.gain for s in gains(y)])
    # Causes that follow the nominal's load are off by its tolerance: in energy, by the square.
    least = {POSITION: _POSITION_SHARE, NEIGHBOUR_FRICTION: settings.tolerance**2}
    price = float(np.log(laboratory.y.shape[0]))
    result = []
    for (axis, i, _, mine), s, most in zip(probes, found, largest, strict=True):
        named = sum(max(f.score.gain, 0.0) for f in mine)
        share = s.gain / max(named + s.gain, 1e-300)
        floor = settings.axis_margin * float(most)
        if axis == NEIGHBOUR_FRICTION:
            # Of so few columns the largest of some nulls says little: the evidence of a cause.
            k = int((s.amplitude != 0.0).sum())
            floor = max(floor, k * price + settings.least_bic)
        result.append(
            Leftover(
                axis, i, s.gain, s.energy, floor, share, least.get(axis, settings.axis_share),
                foreign=axis in (*_BY_NEIGHBOURS, POSITION),
            )
        )  # fmt: skip
    instead = _instead(laboratory, accepted)
    where = {(x.axis, x.joint) for x in instead}
    return (*(x for x in result if (x.axis, x.joint) not in where), *instead)


def _instead(laboratory: Laboratory, accepted: Sequence[Finding]) -> list[Leftover]:
    """Return where one power of speed explains more than the causes by speed of a joint."""
    result = []
    price = np.log(laboratory.y.shape[0])
    power = SpeedPower()
    for i in range(laboratory.robot.n):
        mine = [f for f in accepted if f.joint == i and f.effect.identifier in _BY_SPEED]
        if not mine:
            continue
        others = [f.columns for f in accepted if f not in mine]
        system = laboratory.system.extended(others)
        target = Target.make(system, laboratory.y)
        base = fit_baseline(system, target)
        whole = system.extended([f.columns for f in mine])
        named = base.cost - fit_baseline(whole, Target.make(whole, laboratory.y)).cost
        k = sum(1 + len(f.effect.refined) for f in mine)
        best: Score | None = None
        for inner in power.grid(laboratory.signals[0], i):
            its = laboratory.single(power, i, inner).beside(system)
            found = score(system, target, base, its, its.products(system, laboratory.y))
            if best is None or found.gain > best.gain:
                best = found
        assert best is not None
        floor = float(named + (2 - k) * price + max(_MORE, _MORE_SHARE * named))
        if best.gain > floor:
            result.append(Leftover('speed', i, best.gain, best.energy, floor, 1.0, 0.0, True))
    return result
