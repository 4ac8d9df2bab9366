# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One recording as the diagnosis sees it: even samples, smooth derivatives, nominal torque."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from sosml_friction.arrays import ColumnArray, FloatArray
from sosml_friction.bags.even_stretches import EvenStretch, even_stretches
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.finite_differences import first_derivative, second_derivative
from sosml_friction.model.known_terms import KnownTerm
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.model.smooth_sign import softened
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.scales import Scales
from sosml_friction.observers.signal_noise import counts_of, signal_noise
from sosml_friction.regression.band import Band
from sosml_friction.regression.chance import SIGMAS
from sosml_friction.regression.position_noise import PositionNoise
from sosml_friction.regression.rest import Rest
from sosml_friction.regression.rests import find_rests, stopping_joints
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.row_bases import RowBases
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.steady_acceleration import (
    largest_of,
    steady_accelerations,
)

#: Displacement over which the friction of a joint that turns around changes its sign: the larger
#: of a share of its range of motion and a number of quanta of position. Of nine answers of
#: ``python -m validation.sensitivity --seed 1`` none changes where either is doubled or the second
#: is halved; where the first is halved, a gap is named that is else not seen.
_SIGN_SHARE, _SIGN_QUANTA = 4e-4, 8.0
#: Displacements tried, as shares of that.
_SIGN_SHARES = (0.005, 0.02, 0.05, 0.1, 0.15, 0.2, 0.27, 0.36, 0.48, 0.62, 0.8, 1.0)
#: Least white noise of position that dithers its quantum, as a share of the quantum: beside less
#: it is the smallest step of a smooth signal. Halved and doubled, no answer of ``python -m
#: validation.sensitivity --seed 1`` changes.
_DITHER = 0.1
#: Widest sign, as a share of the top speed: three times as fast it is 99.5 % of itself, and what
#: still grows there is no sign but a law of velocity. Halved and doubled, no answer of ``python -m
#: validation.sensitivity --seed 1`` changes.
WIDEST_SIGN = 0.1
#: Widths tried where the model states none, as shares of the top speed. Halved and doubled, no
#: answer of ``python -m validation.sensitivity --seed 1`` changes.
_WIDTHS = (0.001, 0.002, 0.004, 0.007, 0.012, 0.02, 0.035, 0.06, WIDEST_SIGN)
#: And then, as shares of the best of these: a quarter of a step and half of one to both sides.
_NEARER = (0.76, 0.87, 1.0, 1.15, 1.32)
#: Widest sign beside a knee, as a share of its v_s: twice as wide, friction is largest at v_s / 2
#: and hardly more than half of S, and the two are one bend. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
_OF_KNEE = 0.25
#: Shapes of the build-up tried, as amplitudes of :func:`bump` beside the sign.
_BENDS = (-0.2, 0.0, 0.2, 0.4)
#: Shortest stretch without holes that is used, in periods of the low-pass's cut-off, of which the
#: low-pass takes two at each end: 7 %. With twelve, and gaps that parted a recording from five
#: samples on, two of ten trials of ``python -m validation.axis_campaign --seed 20261268 --lossy``
#: had a false name.
_SHORTEST_CYCLES = 60.0
#: Narrowest band [Hz]. Halved and doubled, no answer of ``python -m validation.sensitivity --seed
#: 1`` changes.
_NARROWEST = 12.0
#: Largest share of the sampling frequency that the band may be.
_HIGHEST = 0.1


@dataclass(frozen=True)
class Stated:
    """
    Hold a term that a model states: its amplitudes are nominal parameters, as C and B are.

    ``size`` (k,): what each of them is off in proportion to, in its own unit.
    """

    known: KnownTerm
    size: FloatArray


@dataclass(frozen=True)
class Signals:
    """
    Hold one uninterrupted stretch of a recording at its own rate, N samples of n joints.

    ``q``, ``v``, ``a`` (N, n): measured position smoothed at twice the band, and its derivatives,
    the second of :func:`~.steady_acceleration.steady_accelerations`;
    ``shaken`` (N, n): effort that the nominal bodies need beyond it for the acceleration as it is
    measured: in the residual it is noise of known size, but in a column it would take that off;
    ``doubted`` (N, n): effort of the bodies for what may be noise in ``a``;
    ``rough`` (N, n): that acceleration less ``a``; ``jitter`` (n,): standard deviation of what the
    noise of position is in ``v``;
    ``held`` (N,): how long the recorded effort about each sample holds, in steps;
    ``tau`` (N, n): measured effort; ``sign`` (N, n): the state of
    :func:`sign_state`; ``rigid`` (N, n): M q'' + C q' + g of
    the nominal model, rotors included; ``friction`` (N, n): its friction;
    ``known`` (N, n): what the effects in the model's own list add, ``by_load`` (N, n): its slope
    over the load; ``stated``: these terms, and those of its laws; ``more_load`` (N, n): what
    bodies with the causes that were found need more than the nominal's; ``untold``: Coulomb
    and viscous friction of each joint that the model does not tell, see :mod:`.untold_friction`;
    ``rests``: where joints rest and friction is not known, see :func:`with_rests`, else none;
    ``turns``: joints whose friction is not known where they turn around either;
    ``silent``: joints whose effort is not known, or says nothing: their rows are zero, and
    ``tau`` is what the nominal model expects, so that a simulation holds them on their way;
    ``regressor`` (N, n, 10 n) and ``temperature`` (N, n) or None. ``time`` (N,) [s] counts from
    the start of the first recording; ``recording``: of which it is, 0 for the first.
    """

    time: FloatArray
    q: FloatArray
    v: FloatArray
    a: FloatArray
    tau: FloatArray
    sign: FloatArray
    rigid: FloatArray
    friction: FloatArray
    regressor: FloatArray
    robot: Robot
    scales: Scales
    band: Band
    temperature: FloatArray | None = None
    known: FloatArray | float = 0.0
    stated: tuple[Stated, ...] = ()
    by_load: FloatArray | float = 0.0
    more_load: FloatArray | float = 0.0
    untold: tuple[tuple[float, float], ...] = ()
    shaken: FloatArray | float = 0.0
    doubted: FloatArray | float = 0.0
    rough: FloatArray | float = 0.0
    jitter: FloatArray | float = 0.0
    held: FloatArray | float = 1.0
    rests: tuple[Rest, ...] = ()
    silent: frozenset[int] = frozenset()
    turns: frozenset[int] = frozenset()
    recording: int = 0
    cache: dict[object, FloatArray] = field(default_factory=dict)

    @property
    def torque(self) -> FloatArray:
        """Return the effort that the nominal model expects, (N, n)."""
        return np.asarray(self.rigid + self.friction + self.known)

    @property
    def whole_torque(self) -> FloatArray:
        """Return the same with the friction that the model does not tell, (N, n)."""
        if not self.untold:
            return self.torque
        coulomb, viscous = np.array(self.untold).T
        return np.asarray(self.torque + coulomb * self.sign + viscous * self.v)

    @property
    def sure_torque(self) -> FloatArray:
        """
        Return that of the model for an acceleration that is no noise, (N, n).

        Noise of position is in what is left of effort, too: a free curve over a load that has it
        would explain it.
        """
        return np.asarray(self.torque - self.doubted)

    @cached_property
    def motion(self) -> Motion:
        """Return the motion as terms see it; its load is the bodies', behind rotor and gear."""
        warm = np.full_like(self.q, np.nan)
        if self.temperature is not None:
            warm = self.temperature - self.temperature[0]
        load = self.rigid - np.array(self.robot.armature) * self.a + self.more_load
        return Motion(self.time, self.q, self.v, self.sign, load, warm)

    @cached_property
    def _at_rest(self) -> RowBases:
        return RowBases(self.rests)

    @property
    def unexplained(self) -> FloatArray:
        """Return the effort beyond what the nominal model expects of the motion as measured."""
        return np.asarray(self.tau - self.torque - self.shaken)

    def through_gears(self, load: FloatArray) -> FloatArray:
        """Return load (1 + df / dload), (N, n, ...): with what known friction by load takes."""
        share = np.broadcast_to(1.0 + self.by_load, self.q.shape)
        return np.asarray(load * share.reshape(*share.shape, *(1,) * (load.ndim - 2)))

    def effort_unit(self, joint: int) -> str:
        """Return the unit of effort of a joint, Nm or N."""
        return self.robot.effort_units[joint]

    def length_unit(self, joint: int) -> str:
        """Return the unit of position of a joint, rad or m."""
        return 'rad' if self.effort_unit(joint) == 'Nm' else 'm'

    def part(self, rows: slice) -> Signals:
        """Return some of the samples, views of the same arrays."""
        own: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray) and len(value) == len(self.q):
                own[each.name] = value[rows]
        return replace(self, **own, rests=(), cache={})

    def in_joint(self, joint: int, *columns: FloatArray) -> FloatArray:
        """Return (N, n, k) that is zero but for ``columns`` (N,) in one joint."""
        result = np.zeros((len(self.q), self.robot.n, len(columns)))
        for k, column in enumerate(columns):
            result[:, joint, k] = column
        return result

    def in_band(self, x: FloatArray, joints: Sequence[int] | None = None) -> FloatArray:
        """
        Return efforts (N, m, ...) in the band, without what joints at rest may take (K, m, ...).

        What is of silent joints is zero.

        :param joints: which joint each of the m is; None for all n.
        """
        joints = range(self.robot.n) if joints is None else joints
        return self.without_unknown(self.band.apply(x), joints)

    def without_unknown(self, x: ColumnArray, joints: Sequence[int]) -> ColumnArray:
        """Take what joints at rest may take, and all of silent ones, out of x (K, m, ...)."""
        x[:, [k for k, joint in enumerate(joints) if joint in self.silent]] = 0.0
        return self._at_rest.take_out(x, joints)


def with_rests(
    stretches: Sequence[Signals],
    like: Sequence[Signals] | None = None,
    turns: Collection[int] | None = None,
) -> tuple[Signals, ...]:
    """
    Return the same with the rests of the joints, in which their effort says nothing.

    :param like: stretches that say which joints stop; None: these.
    :param turns: joints in which that is so where they turn around, too; None: those of ``like``.
    """
    scales, like = stretches[0].scales, like or stretches
    sizes = scales.sign_limit, scales.speed
    joints = stopping_joints([(s.q, s.band) for s in like], *sizes)
    at = like[0].turns if turns is None else frozenset(turns)
    return tuple(
        replace(s, rests=find_rests(s.q, s.band, *sizes, joints, at), turns=at) for s in stretches
    )


def choose_cutoff(
    stretches: Sequence[JointLog], robot: Robot, settings: DiagnosisSettings
) -> float:
    """
    Return the band's cut-off [Hz], up to where position makes as much noise as effort.

    White noise s_q of position, twice differentiated within a band f, makes an inertial effort of
    M (2 pi f)^2 s_q / sqrt(5) for each unit that white noise s_tau of effort leaves in the same
    band: they are equal at f = sqrt(sqrt(5) s_tau / (M s_q)) / (2 pi). The lowest of the joints'
    is taken, each with the mean squares of all samples: a joint at rest shows less noise.
    """
    if settings.band is not None:
        return settings.band
    noises = [_position_noise(each, robot, _step(each)) for each in stretches]
    share = np.array([len(each) for each in stretches], dtype=np.float64)
    share /= share.sum()
    position = np.sqrt(share @ [seen**2 for _, seen in noises])
    efforts = np.sqrt(share @ [each.effort**2 for each, _ in noises])
    inertias = share @ [np.diag(each.inertia) for each, _ in noises]
    found = [settings.widest_band]
    for noise, effort, inertia in zip(position, efforts, inertias, strict=True):
        if noise > 0.0 and effort > 0.0 and inertia > 0.0:
            found.append(float(np.sqrt(np.sqrt(5.0) * effort / (inertia * noise)) / (2.0 * np.pi)))
    widest = min(settings.widest_band, _HIGHEST / max(map(_step, stretches)))
    return float(np.clip(min(found), min(_NARROWEST, widest), widest))


def _step(stretch: JointLog) -> float:
    return float(np.median(np.diff(stretch.time)))


def _position_noise(log: JointLog, robot: Robot, step: float) -> tuple[PositionNoise, FloatArray]:
    """Return the noise of position, and the standard deviation of what is seen of it (n,)."""
    steps, effort, seen = np.zeros((3, robot.n))
    for i in range(robot.n):
        quantum, noise = signal_noise(log.q[:, i])
        steps[i] = counts_of(log.q[:, i])
        # A joint that stands most of the time shows no noise, but moves in steps all the same.
        if noise > _DITHER * quantum or steps[i] > 0.0:
            noise = max(noise, quantum / np.sqrt(12.0))
        seen[i] = noise
        # The effort of a silent joint is no part of the regression.
        if np.isfinite(log.tau[:, i]).any():
            effort[i] = signal_noise(log.tau[:, i])[1]
    motion = Band(min(_NARROWEST, _HIGHEST / step), step).smooth(log.q, 1.0)
    inertia = robot.inertia(np.nanmedian(log.q, axis=0))
    return PositionNoise.seen(log.q, motion, steps, effort, inertia), seen


def find_scales(logs: Sequence[JointLog], model: RobotModelFile, robot: Robot) -> Scales:
    """Return the scales of the joints over all recordings."""
    n = robot.n
    quantum = np.max([[signal_noise(x)[0] for x in log.q.T] for log in logs], axis=0)
    q = np.concatenate([log.q for log in logs])
    tau = np.concatenate([log.tau for log in logs])
    # What is not known takes no part.
    known_q = np.isfinite(q)
    low = np.min(q, axis=0, where=known_q, initial=np.inf)
    high = np.max(q, axis=0, where=known_q, initial=-np.inf)
    span = np.where(known_q.any(axis=0), high - low, 0.0)
    speed = np.zeros(n)
    for log in logs:
        steps = np.diff(log.time)
        if not (steps > 0.0).any():
            raise DataError(
                f'the recording has {len(log)} samples of one stamp: record a motion, each sample '
                'with the time of its measurement'
            )
        dt = float(np.median(steps[steps > 0.0]))
        wide = max(1, round(0.05 / dt))
        if len(log) > 2 * wide:
            slope = np.abs(log.q[wide:] - log.q[:-wide]) / (wide * dt)
            slope[~np.isfinite(slope)] = 0.0
            speed = np.maximum(speed, np.quantile(slope, 0.99, axis=0))
    friction = {
        name: np.full(n, np.nan)
        for name in ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias')
    }
    width = np.array([joint.sign_width for joint in model.joints.values()])
    for i, joint in enumerate(model.joints.values()):
        if joint.friction is None:
            continue
        stated = {name: p.value for name, p in joint.friction.parameters.items()}
        if any(np.isfinite(stated.get(name, np.nan)) for name in ('coulomb', 'viscous')):
            # A model with numbers of friction says that there is none of what it leaves out.
            stated = {**dict.fromkeys(('coulomb', 'viscous', 'bias'), 0.0), **stated}
        for name, values in friction.items():
            values[i] = stated.get(name, np.nan)
    limit = np.maximum(np.maximum(_SIGN_SHARE * span, _SIGN_QUANTA * quantum), 1e-12)
    known = np.isfinite(tau).any(axis=0)
    effort = np.zeros(n)
    effort[known] = np.sqrt(np.nanmean(tau[:, known] ** 2, axis=0))
    return Scales(
        displacement=limit,
        sign_limit=limit,
        speed=np.maximum(speed, 1e-12),
        span=np.maximum(span, 1e-12),
        effort=effort,
        width=width,
        **friction,
    )


def make_signals(
    stretch: JointLog, robot: Robot, scales: Scales, band: Band, start_s: float
) -> Signals:
    """Return the signals of one even stretch that begins at ``start_s`` [s]."""
    step = band.step
    q = band.smooth(stretch.q)
    v = first_derivative(q, step)
    a = first_derivative(v, step)
    sign = _signs(q, v, scales)
    found = _position_noise(stretch, robot, step)[0]
    drawn, scale = found.drawn(np.random.default_rng(0)), found.scale
    noise, per_scale = band.smooth(drawn), second_derivative(band.smooth(drawn / scale), step)
    sigmas = SIGMAS, largest_of(len(a))
    steady, sure = steady_accelerations(a, per_scale, scale, band, sigmas)
    regressor = robot.torque_regressors(q, v, steady)
    bodies, rotors = robot.inertial_parameters().ravel(), np.array(robot.armature)
    rigid = regressor @ bodies + rotors * steady
    if robot.followers:
        # Their bodies are not in the regressor.
        rigid = robot.inverse_dynamics_along(q, v, steady)
    whole, least = (robot.inverse_dynamics_along(q, v, each) for each in (a, sure))
    friction = nominal_friction(v, sign, scales)
    silent = ~np.isfinite(stretch.tau).any(axis=0)
    return Signals(
        time=start_s + np.arange(len(q), dtype=np.float64) * step,
        q=q,
        v=v,
        a=steady,
        tau=np.where(silent, rigid + friction, np.nan_to_num(stretch.tau)),
        sign=sign,
        rigid=rigid,
        friction=friction,
        regressor=regressor,
        robot=robot,
        scales=scales,
        band=band,
        temperature=stretch.temperature,
        shaken=whole - rigid,
        doubted=rigid - least,
        rough=a - steady,
        jitter=np.std(first_derivative(noise, step), axis=0),
        silent=frozenset(np.flatnonzero(silent).tolist()),
    )


def nominal_friction(v: FloatArray, sign: FloatArray, scales: Scales) -> FloatArray:
    """Return the friction of the model along a motion, (N, n); 0 where the model has none."""
    known = {
        name: np.nan_to_num(getattr(scales, name))
        for name in ('coulomb', 'viscous', 'stribeck', 'bias')
    }
    vs = np.where(np.isfinite(scales.stribeck_velocity), scales.stribeck_velocity, 1.0)
    level = known['coulomb'] + known['stribeck'] * fade(v, vs, np.ones_like(vs))
    return np.asarray(level * sign + known['viscous'] * v + known['bias'])


def prepare(
    logs: Sequence[JointLog],
    model: RobotModelFile,
    robot: Robot,
    settings: DiagnosisSettings,
    known: Scales | None = None,
    shortest_s: float | None = None,
    knees: Sequence[float] = (),
) -> list[Signals]:
    """
    Return the signals of all recordings, stretch after stretch.

    :param known: scales found on other recordings, to be used as they are.
    :param shortest_s: shortest stretch that is of use [s]; None: as the diagnosis needs.
    :param knees: v_s, as shares of the top speed, of Stribeck friction that may be found as well.
    :raises DataError: if nothing is long enough.
    """
    scales = known or find_scales(logs, model, robot)
    begins = np.cumsum([0.0, *(float(log.time[-1]) + 1.0 for log in logs)])

    def lasting(cycles: float, cutoff: float) -> list[tuple[EvenStretch, float, int]]:
        """Return stretches without what is a hole in that band, where each begins, and of what."""
        return [
            (stretch, float(begin) + float(stretch.t_ns[0] - log.t_ns[0]) * 1e-9, number)
            for number, (log, begin) in enumerate(zip(logs, begins, strict=False))
            for stretch in even_stretches(log, cutoff)
            if len(stretch) * _step(stretch) >= cycles / cutoff
        ]

    # What is too short in any band has no say in which.
    widest = settings.band or settings.widest_band
    used = lasting(_SHORTEST_CYCLES if shortest_s is None else 0.0, widest)
    # One for all: what is compared must be filtered alike.
    cutoff = choose_cutoff([own[0] for own in used], robot, settings) if used else widest
    fewest = _SHORTEST_CYCLES if shortest_s is None else max(shortest_s * cutoff, 5.0)
    used = lasting(fewest, cutoff)
    if not used:
        longest = max(
            (len(own) * _step(own) for log in logs for own in even_stretches(log, cutoff)),
            default=0.0,
        )
        raise DataError(
            f'{longest:.3g} s is the longest stretch without a hole in position or effort, and '
            f'{fewest / cutoff:.3g} s are needed in the band of {cutoff:.3g} Hz, which noise and '
            'rate leave: record longer at one go, or at a higher rate'
        )
    prepared = [
        replace(
            make_signals(stretch, robot, scales, Band(cutoff, _step(stretch)), begin),
            recording=number,
            held=stretch.held,
        )
        for stretch, begin, number in used
    ]
    return prepared if known else _with_fitted_sign(prepared, knees)


def sign_state(q: FloatArray, v: FloatArray, displacement: float, width: float) -> FloatArray:
    """
    Return the sign of a joint's motion (N,) as its friction has it, (N,).

    It changes over a displacement, and smoothly over a width of velocity.
    """
    return softened(dahl_path(np.ascontiguousarray(q), displacement), v, width)


def _signs(q: FloatArray, v: FloatArray, scales: Scales) -> FloatArray:
    """Return the signs of all joints' motion, (N, n)."""
    columns = zip(q.T, v.T, scales.displacement, scales.width, strict=True)
    return np.column_stack([sign_state(*column) for column in columns])


def bump(sign: FloatArray) -> FloatArray:
    """Return s (1 - s^2): 0 before and after a reversal's build-up, another shape within."""
    return sign * (1.0 - sign * sign)


def _with_fitted_sign(prepared: list[Signals], knees: Sequence[float]) -> list[Signals]:
    """
    Return the signals with the displacement of the sign that fits each joint best.

    It is a number of the gear and not of the nominal model. What :func:`find_scales` says is the
    most that still counts as a sign; friction that builds up over more is a cause. Where the model
    does not state over which velocity the sign is smooth, that is found as well, beside knees,
    which would make it narrower: it is smooth if it fits very strongly better than the
    displacement.
    """
    scales, n = prepared[0].scales, prepared[0].robot.n
    displacement, width = scales.displacement.copy(), scales.width.copy()
    for i in range(n):
        sign = np.concatenate([signals.sign[:, i] for signals in prepared])
        if sign.min() >= 0.0 or sign.max() <= 0.0:
            # Of a joint that never turns around it is a constant, whatever it changes over.
            continue
        U, y = _beside_sign(prepared, i)
        over = (scales.displacement[i] * np.array(_SIGN_SHARES)).tolist()
        tried = [(x, float(width[i])) for x in over]
        _, found = _best_sign(prepared, i, U, y, tried)
        displacement[i] = found[0]
        if width[i] > 0.0:
            continue
        at = [share * float(scales.speed[i]) for share in knees]
        most, _ = _best_sign(prepared, i, U, y, [found], at)
        tried = [(over[0], scales.speed[i] * x) for x in _WIDTHS]
        _, (_, near) = _best_sign(prepared, i, U, y, tried, at)
        tried = [(over[0], near * x) for x in _NEARER]
        more, found = _best_sign(prepared, i, U, y, tried, at)
        noise = max(float(y @ y) - most, 0.0) / max(len(y) - U.shape[1], 1)
        if more - most > VERY_STRONG * noise:
            displacement[i], width[i] = found
    fitted = replace(
        scales, displacement=displacement, sign_limit=scales.displacement, width=width
    )
    result = []
    for signals in prepared:
        sign = _signs(signals.q, signals.v, fitted)
        friction = nominal_friction(signals.v, sign, fitted)
        result.append(replace(signals, sign=sign, friction=friction, scales=fitted))
    return result


def _beside_sign(prepared: Sequence[Signals], joint: int) -> tuple[FloatArray, FloatArray]:
    """Return what acts beside the sign as an orthonormal basis, and the effort without it."""
    known, effort = [], []
    for signals in prepared:
        columns = np.column_stack(
            [
                signals.regressor[:, joint],
                signals.a[:, joint],
                signals.v[:, joint],
                np.ones(len(signals.q)),
            ]
        )
        known.append(signals.band.apply(columns[:, np.abs(columns).max(axis=0) > 0.0]))
        effort.append(signals.band.apply(signals.tau[:, joint]))
    shared = min(part.shape[1] for part in known)
    X = np.concatenate([part[:, :shared] for part in known])
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    basis = np.linalg.svd(X, full_matrices=False)
    U = basis[0][:, basis[1] > 1e-7 * basis[1][0]]
    y = np.concatenate(effort)
    return U, y - U @ (U.T @ y)


def _best_sign(
    prepared: Sequence[Signals],
    joint: int,
    U: FloatArray,
    y: FloatArray,
    tried: Sequence[tuple[float, float]],
    knees: Sequence[float] = (),
) -> tuple[float, tuple[float, float]]:
    """
    Return the most that a sign explains of an effort, and its displacement and width.

    :param knees: v_s of Stribeck friction that may act besides, any of them or none.
    """
    best, found = -1.0, tried[0]
    for over, width in tried:
        parts = []
        for signals in prepared:
            v = signals.v[:, joint]
            state = sign_state(signals.q[:, joint], v, over, width)
            faded = [state * fade(v, v_s, 1.0) for v_s in knees if width < _OF_KNEE * v_s]
            columns = map(signals.band.apply, (state, bump(state), *faded))
            parts.append(np.column_stack(list(columns)))
        both = np.concatenate(parts)
        both = both - U @ (U.T @ both)
        # How it builds up beside the exponential is fitted too, and forgotten: it would be made
        # up for by a displacement that is not the gear's.
        for bend in _BENDS:
            state = both[:, 0] + bend * both[:, 1]
            size = max(float(state @ state), 1e-300)
            explained = max(float(state @ y), 0.0) ** 2 / size
            own = both[:, 2:] - np.outer(state, state @ both[:, 2:]) / size
            S = own.T @ y
            more = np.maximum(S, 0.0) ** 2 / np.maximum(np.sum(own**2, axis=0), 1e-300)
            explained += float(np.max(more, initial=0.0))
            if explained > best:
                best, found = explained, (over, width)
    return best, found
