# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The nominal model as columns: how far each of its parameters may be off without a cause."""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.finite_differences import first_derivative
from sosml_friction.model.known_terms import KnownTerm
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.effort_delay import effort_slope
from sosml_friction.model.terms.kinds.fading_term import FOLLOWS
from sosml_friction.model.terms.kinds.scales import Scales
from sosml_friction.regression.chance import SIGMAS
from sosml_friction.regression.column_norms import ROUNDING, joints_acted_in
from sosml_friction.regression.signals import Signals, Stated, bump, sign_state

#: Share of a sampling interval by which effort may be off, it holds at its start, middle or end,
#: and the instant at which friction turns around.
_HOLD = 0.55
#: After a reversal, friction builds up by a curve that the model does not know. Shares of Coulomb
#: friction that may come sooner or later, and in another shape. Of nine answers of ``python -m
#: validation.sensitivity --seed 1`` none changes where they are doubled, or the second is halved;
#: where the first is halved, a delay is no longer named, but an unknown structure.
_SOONER, _SHAPE = 0.2, 0.45
#: Displacements of the sooner and the later state, as shares of the fitted one.
TURNS = {'sooner': 0.3, 'later': 2.0}
#: The name of friction that turns around late by a time within a sampling interval.
LATE = 'late'
#: The name of friction whose sign is smooth over more velocity, and over how many times as much:
#: enough to show, and the column is nearly in proportion to it. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
SOFTER, _WIDER = 'softer', 1.5
#: The name of how a Stribeck term that the model states builds up after a reversal, and by how
#: many times what it lacks where it follows its level as the sign does. Chosen, no measurement.
KNEE, _LAGS = 'knee', 2.0
#: The name of how late effort of a joint is reported, within a sampling interval of the median
#: length: in a longer one, in which a command was held for longer, it is as much later.
EFFORT_HOLD = 'effort hold'
#: Direction of a first moment that is normally off, as a share of the tolerance of its size.
_ASKEW = 0.3
#: In a body's ten numbers: first moments, moments of inertia, products of inertia, mass.
_ORDER = (1, 2, 3, 4, 6, 9, 5, 7, 8, 0)


@dataclass(frozen=True)
class Nominal:
    """
    Hold how a nominal model may vary: deviations x (p,) of its parameters.

    ``names``: what each is. ``bound`` (p,): |x| <= bound, infinite where the model does not know
    the parameter. ``prior`` (p,): standard deviation, of a Gaussian about 0 [same units].
    ``rigid``: the base parameters, as indices into ten numbers per body and then the rotors;
    ``rigid_columns``: where they are among the deviations.
    ``recordings``: those that have friction and bias of their own, as differences from the mean
    over them; none where all have the same.
    ``silent``: joints that have no parameter of friction, as nothing is known of their effort.
    ``stated``: the terms that the model states besides, of the joints that are not silent.
    """

    names: tuple[str, ...]
    bound: FloatArray
    prior: FloatArray
    rigid: IndexArray
    rigid_columns: IndexArray
    silent: frozenset[int] = frozenset()
    stated: tuple[Stated, ...] = ()
    recordings: tuple[int, ...] = ()

    def columns(self, signals: Signals) -> FloatArray:
        """Return (N, n, p): effort per unit of each deviation."""
        n, count = signals.robot.n, len(signals.q)
        result = np.zeros((count, n, len(self.names)))
        k = 0
        told = [i for i in range(n) if i not in self.silent]
        shares = self._shares(signals.recording)
        for i in told:
            friction = friction_columns(signals, i).values()
            for share, column in itertools.product(shares, friction):
                result[:, i, k] = share * column
                k += 1
        for index in self.rigid:
            if index < 10 * n:
                result[:, :, k] = signals.through_gears(signals.regressor[:, :, index])
            else:
                result[:, index - 10 * n, k] = signals.a[:, index - 10 * n]
            k += 1
        for i in told:
            for column in reversal_columns(signals, i).values():
                result[:, i, k] = column
                k += 1
        for known in (each.known for each in self.stated):
            own = slice(k, k + len(known.names))
            result[:, :, own] = known.term.columns(signals, known.joint, known.inner)
            k = own.stop
        late = -effort_slope(signals) * np.reshape(signals.held, (-1, 1))
        for i in told:
            result[:, i, k] = late[:, i]
            k += 1
        for column in np.moveaxis(result, 2, 0):
            others = np.setdiff1d(np.arange(n), joints_acted_in(column[:, :, None]))
            column[:, others] = 0.0
        if k != len(self.names):
            raise ValueError(f'{len(self.names)} deviations have {k} columns in these signals')
        return result

    def _shares(self, recording: int) -> list[float]:
        """Return what the mean has in a recording, 1, and each difference of another one to it."""
        return [1.0] + [
            float(recording == own) - float(recording == self.recordings[0])
            for own in self.recordings[1:]
        ]


def friction_columns(signals: Signals, joint: int) -> dict[str, FloatArray]:
    """Return the columns of a joint's nominal friction, by the name of their parameter."""
    s, v = signals.sign[:, joint], signals.v[:, joint]
    return {'coulomb': s, 'viscous': v, 'bias': np.ones(len(s))}


def reversal_columns(signals: Signals, joint: int) -> dict[str, FloatArray]:
    """
    Return what the sign s of motion lacks where friction builds up in another way, by name.

    z - s of states z that change over less and over more than the fitted displacement,
    s (1 - s^2), which is 0 before and after the build-up, and -s': how friction turns around at a
    reversal, and at which instant, is not known to a model of Coulomb friction, and no cause. Nor
    is over which velocity exactly, where the sign is smooth in it, nor how a Stribeck term of the
    model builds up there.
    """
    s = signals.sign[:, joint]
    late = -first_derivative(s, signals.band.step)
    over, width = (x[joint] for x in (signals.scales.displacement, signals.scales.width))
    q, v = signals.q[:, joint], signals.v[:, joint]
    turns = {name: sign_state(q, v, share * over, width) - s for name, share in TURNS.items()}
    columns = {**turns, 'shape': bump(s), LATE: late}
    if width > 0.0:
        columns[SOFTER] = sign_state(q, v, over, _WIDER * width) - s
    behind = [_behind(signals, joint, each.known) for each in signals.stated]
    if own := [column for column in behind if column is not None]:
        columns[KNEE] = np.asarray(np.sum(own, axis=0) / signals.scales.level(joint))
    return columns


def _behind(signals: Signals, joint: int, known: KnownTerm) -> FloatArray | None:
    """Return what a term has more where it follows its level (N,), None of others."""
    slow = known.following(float(signals.scales.displacement[joint]))
    if slow is None or known.joint != joint:
        return None
    once = {name: value for name, value in known.inner.items() if name != FOLLOWS}
    return replace(known, inner=once).lacks(signals, slow)[:, joint]


def make_nominal(
    signals: Signals,
    tolerance: float,
    silent: frozenset[int] = frozenset(),
    free_inertia: tuple[str, ...] = (),
    unknown_armature: tuple[str, ...] = (),
    recordings: tuple[int, ...] = (),
) -> Nominal:
    """
    Return the deviations of a nominal model and their bounds.

    A known parameter may be off by ``tolerance`` of itself, a friction of zero by ``tolerance`` of
    one that would need all of the measured effort, a bias by ``tolerance`` of Coulomb
    friction, each component of a first moment by ``tolerance`` of itself, at least of 0.3 of the
    whole vector, whose direction is known better than its length. Bodies whose inertias act
    together are combined (base parameters), and so are their bounds. Terms that the model states
    besides have a deviation for each amplitude, by ``tolerance`` of their ``size``.

    :param signals: of any stretch; only the model's own numbers are used.
    :param free_inertia: joints whose rotor may be off by all but the tolerance of the inertia that
        they have in the middle of the motion.
    :param recordings: those that have friction and bias of their own. They differ by no more than
        would need all of the measured effort.
    """
    scales, robot = signals.scales, signals.robot
    names: list[str] = []
    bound: list[float] = []
    told = [(i, joint) for i, joint in enumerate(robot.names) if i not in silent]
    for i, joint in told:
        for name in friction_columns(signals, i):
            value = float(getattr(scales, name)[i])
            known = np.isfinite(value)
            if name == 'bias' and known:
                value = np.nan_to_num(scales.coulomb[i])
            names.append(f'{joint} {name}')
            size = abs(value) or _of_all_effort(scales, i, name)
            bound.append(tolerance * size if known else np.inf)
        for own, name in itertools.product(recordings[1:], friction_columns(signals, i)):
            names.append(f'{joint} {name} of recording {own + 1}')
            bound.append(_of_all_effort(scales, i, name))
    rigid, rigid_bound = _base(robot, tolerance)
    rigid_columns = len(names) + np.arange(len(rigid))
    for index, its_bound in zip(rigid, rigid_bound, strict=True):
        if index < 10 * robot.n:
            names.append(f'{robot.names[index // 10]} body {index % 10}')
        else:
            joint = robot.names[index - 10 * robot.n]
            names.append(f'{joint} armature')
            if joint in free_inertia:
                i = index - 10 * robot.n
                whole = robot.inertia(np.median(signals.q, axis=0))[i, i]
                # Some stays: nothing can be simulated without.
                its_bound = (1.0 - tolerance) * whole
            if joint in unknown_armature:
                its_bound = np.inf
        bound.append(float(its_bound))
    for i, joint in told:
        for name in reversal_columns(signals, i):
            share = {'shape': _SHAPE, LATE: _HOLD * signals.band.step, KNEE: _LAGS}.get(
                name, _SOONER
            )
            names.append(f'{joint} reversal {name}')
            bound.append(share * signals.scales.level(i))
    stated = tuple(
        each
        for each in signals.stated
        if each.known.term.of_robot or each.known.joint not in silent
    )
    for each in stated:
        names += each.known.names
        bound += (tolerance * each.size).tolist()
    for _, joint in told:
        names.append(f'{joint} {EFFORT_HOLD}')
        bound.append(_HOLD * signals.band.step)
    bounds = np.array(bound)
    priors = bounds / SIGMAS
    return Nominal(tuple(names), bounds, priors, rigid, rigid_columns, silent, stated, recordings)


def _of_all_effort(scales: Scales, joint: int, name: str) -> float:
    """Return the parameter of friction that would need all effort of a joint, at top speed."""
    effort, speed = float(scales.effort[joint]), float(scales.speed[joint])
    return effort / max(speed, np.finfo(float).tiny) if name == 'viscous' else effort


def _base(robot: Robot, tolerance: float) -> tuple[IndexArray, FloatArray]:
    """
    Return which of the 10 n body parameters and n rotors are base parameters, and their bounds.

    The columns at random states, rotors first, then first moments, inertias and masses; one that
    those before it explain is combined into them.
    """
    n = robot.n
    rng = np.random.default_rng(0)
    rows = []
    for _ in range(20 * n):
        q, v, a = rng.uniform(-2.0, 2.0, (3, n))
        rows.append(np.column_stack([robot.torque_regressor(q, v, a), np.diag(a)]))
    Y = np.concatenate(rows)
    own = robot.inertial_parameters()
    allowed = np.zeros((n, 10))
    allowed[:, 0] = np.abs(own[:, 0])
    length = np.linalg.norm(own[:, 1:4], axis=1)
    allowed[:, 1:4] = np.maximum(np.abs(own[:, 1:4]), _ASKEW * length[:, None])
    allowed[:, 4:] = np.abs(own[:, [4, 6, 9]]).max(axis=1)[:, None]
    # A rotor that nobody stated may be of the size of what it moves.
    moved = np.abs(np.diag(robot.inertia(np.zeros(n))))
    rotors = np.where(np.array(robot.armature) > 0.0, robot.armature, moved)
    limits = tolerance * np.concatenate([allowed.ravel(), rotors])
    order = [10 * n + i for i in range(n)]
    order += [10 * i + k for k in _ORDER[:3] for i in range(n)]
    order += [10 * i + k for k in _ORDER[3:] for i in range(n)]
    chosen: list[int] = []
    for index in order:
        size = float(np.linalg.norm(Y[:, index]))
        if size < 1e-12:
            continue
        rest = Y[:, index]
        if chosen:
            rest = rest - Y[:, chosen] @ np.linalg.lstsq(Y[:, chosen], rest, rcond=None)[0]
        if float(np.linalg.norm(rest)) > ROUNDING * size:
            chosen.append(index)
    bounds = limits[chosen]
    others = [k for k in order if k not in chosen and limits[k] > 0.0]
    if others and chosen:
        combination = np.linalg.lstsq(Y[:, chosen], Y[:, others], rcond=None)[0]
        bounds = bounds + np.abs(combination) @ limits[others]
    free = bounds > 0.0
    return np.array(chosen, dtype=np.int64)[free], bounds[free]
