# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is left beside the causes that is neither noise nor the model's own uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.diagnosis.decision.bursts import bursts
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.further_curves import further_curves
from sosml_friction.diagnosis.decision.leftover import (
    AXES,
    BURSTS,
    FRICTION_BY,
    REST,
    TONE,
    TORQUE_BY,
    Leftover,
    curve_floor,
    share_beside,
)
from sosml_friction.diagnosis.decision.one_power import OnePower
from sosml_friction.diagnosis.decision.ripple import Stretch, strongest_ripple
from sosml_friction.diagnosis.decision.sliding import clear_of_turns, fit_within, sliding
from sosml_friction.diagnosis.decision.slow_effort import slow_effort
from sosml_friction.diagnosis.decision.slow_noise import noise_where
from sosml_friction.diagnosis.decision.tones import TONE_SHARE, tones
from sosml_friction.diagnosis.trust import scale_tolerance
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.effort_scale import EffortScale
from sosml_friction.regression.chance import SIGMAS
from sosml_friction.regression.curves.axes import NEIGHBOURS, POSITION, SPEED, TIME
from sosml_friction.regression.curves.elsewhere import Elsewhere
from sosml_friction.regression.evidence import CandidateColumns, Fit, System
from sosml_friction.regression.evidence_curves import fit_curves
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.structure import HATS
from sosml_friction.regression.whitened import WhitenedRegression

#: Share of what is left of a joint that all of its curves explain together, where there is no
#: cause: three times the largest of 42 recordings, 0.0076, which is 0.0025 since noise is as slow
#: as it is (``python -m validation.leftovers --seed 424242``).
ALL = 0.023
#: Energy of a ripple over position, as a share of that of noise in the part of the band in which
#: it is at top speed. Three times the largest share of all noise of 126 such recordings, of
#: friction alone, 0.0107 (``--recordings 42``; a curve of them has 0.0034, all curves together
#: 0.0087). Of a part of the band, and of friction or torque constant, the largest of 30 has 0.45
#: of its floor (``--seed 20261275 --recordings 10``).
RIPPLE = 0.03

#: Share of the sliding rows that has to be clear of turns for a curve over position to be asked
#: there alone: in fewer a true one may not stand out. Chosen, no measurement.
_CLEAR = 0.2


@dataclass(frozen=True)
class Remainder:
    """
    Hold what free curves, tones, ripples, bursts, slow effort and powers of speed explain.

    ``explained`` (n,): share of what is left of each joint that all free curves explain together;
    ``named``: whitened energy that the causes explain, but for numbers of the nominal model.
    ``powers``: one power of speed in the place of the causes by speed of each joint that has some.
    """

    found: tuple[Leftover, ...] = ()
    explained: FloatArray = field(default_factory=lambda: np.zeros(0))
    named: float = 0.0
    powers: tuple[OnePower, ...] = ()

    def with_powers(self, powers: Sequence[OnePower]) -> Remainder:
        """Return it with one power of speed where that is true in the place of causes by speed."""
        instead = [x for x in powers if x.gain > x.floor]
        where = {(SPEED, x.joint) for x in instead}
        found = [x for x in self.found if (x.axis, x.joint) not in where]
        found += [
            Leftover(SPEED, x.joint, x.gain, x.floor, 1.0, 0.0, instead=True) for x in instead
        ]
        return replace(self, found=tuple(found), powers=tuple(powers))

    def largest(self, joint: int) -> Leftover | None:
        """Return what exceeds its floor most in a joint."""
        own = [x for x in self.found if x.joint == joint]
        return max(own, key=lambda x: x.energy / max(x.floor, 1e-300), default=None)

    @property
    def beyond_chance(self) -> list[Leftover]:
        """Return what is more than noise and the model's own uncertainty make of it."""
        return [x for x in self.found if x.beyond_chance]

    @property
    def significant(self) -> list[Leftover]:
        """Return what is too much for the causes of its joint to be the whole."""
        return [x for x in self.found if x.significant]


def remainder(laboratory: WhitenedRegression, fit: Fit, accepted: Sequence[Finding]) -> Remainder:
    """
    Return what is left beside accepted causes.

    The nominal is that of the rows in which joints slide, as curves are sought in these alone.

    :param fit: with the accepted causes.
    """
    far, settings = sliding(laboratory), laboratory.settings
    # A number of the nominal that is wrong has no structure, however much it explains.
    wrong = [finding.columns for finding in accepted if finding.effect.parameter_error]
    alone = laboratory.system.extended(wrong)
    scales = scale_columns(laboratory)
    alone_fit, fit = (
        fit_within(with_scales(laboratory, x, scales), fit.target.y, far)
        for x in (alone, fit.system)
    )
    rows = laboratory.known * far.mean(axis=0)
    told = [i for i in range(laboratory.robot.n) if rows[i] > 0.0]
    curves: list[tuple[int, FloatArray]] = []
    axes: list[tuple[str, bool]] = []
    elsewhere = Elsewhere(laboratory.signals)
    for i in told:
        for g, hats in enumerate(free_curves(laboratory, elsewhere, i)):
            curves.append((i, hats))
            axes.append((AXES[g // 2], g % 2 == 1))
    result = fit_curves(fit, curves, far)
    energies = np.array(result.energy)
    # Motion that repeats turns around at the same places: where enough rows are clear of them, a
    # curve over position has to stand out in these alone.
    clear = far & clear_of_turns(laboratory)
    kept = clear.sum(axis=0) / np.maximum(far.sum(axis=0), 1)
    joint = np.array([i for i, _ in curves], dtype=np.intp)
    position = np.array([axis == POSITION for axis, _ in axes], dtype=np.bool_)
    at = np.flatnonzero(position & (kept[joint] > _CLEAR) & (energies > 0.0))
    if len(at):
        there = fit_within(fit.system, fit.target.y, clear)
        again = fit_curves(there, [curves[k] for k in at], clear).energy
        energies[at] = np.minimum(energies[at], again)
    residuals = _residual(alone_fit), _residual(fit), result.left
    energy = np.array([np.sum(x**2, axis=0) for x in residuals])
    named = np.maximum(energy[0] - energy[1], 0.0)
    left = np.where(energy[1] > 0.0, energy[2] / np.where(energy[1] > 0.0, energy[1], 1.0), 1.0)
    explained = np.clip(1.0 - left, 0.0, 1.0)
    # A joint that no cause acts in has none that could be the whole.
    acted = {int(row) for finding in accepted for row in finding.columns.rows}
    warming = {f.joint for f in accepted if f.effect.axis == TIME}
    own_axes = {(f.effect.free_axis, f.joint) for f in accepted if not f.effect.of_robot}
    found = []
    slow = [noise_where(hats, result.left[:, i]) for i, hats in curves]
    for curve, (axis, friction), own, noise in zip(curves, axes, energies, slow, strict=True):
        i = curve[0]
        floor = curve_floor(float(rows[i]))
        # Along the axis of a cause nothing is left where it is the right one.
        least = settings.axis_share if (axis, i) in own_axes else REST
        if axis in NEIGHBOURS:
            # No cause of the catalogue is a function of another joint's motion; but those that
            # follow the nominal's load are off by its tolerance, in energy by the square.
            least = settings.tolerance**2
            # Neither is any friction of the nominal: of 300 recordings of two joints one other had
            # such a curve. The best of several joints is one by chance more often.
            price = 2.0 * float(np.log(rows[i]) + np.log(len(told)))
            floor = price if friction else floor
        floor *= noise
        share = 1.0
        if i in acted:
            beside = named[i]
            if own > floor and axis == TIME and i not in warming:
                # No other cause is a function of time: what such a curve could stand for as well
                # speaks for neither.
                without, with_it = (
                    float(np.sum(fit_curves(one, [curve], far).left[:, i] ** 2))
                    for one in (alone_fit, fit)
                )
                beside = max(without - with_it, 0.0)
            share = share_beside(own, float(beside))
        name = f'{FRICTION_BY}{axis}' if friction else axis
        found.append(Leftover(name, i, own, floor, share, least))
    for i in told:
        own_curves = [x for x in found if x.joint == i]
        seen = sum(x.energy > 0.0 for x in own_curves)
        floor = max(ALL * energy[1][i], 2.0 * seen * float(np.log(rows[i])) + VERY_STRONG)
        floor *= max(noise for (joint, _), noise in zip(curves, slow, strict=True) if joint == i)
        whole = all_together(own_curves, explained[i] * energy[1][i], floor, named[i])
        found += [] if whole is None else [whole]
    for i, tone in tones(laboratory, result.left, told):
        floor = tone.energy * TONE_SHARE / tone.share
        found.append(Leftover(TONE, i, tone.energy, floor, tone.share, 0.0, hertz=tone.hertz))
    found += further_curves(laboratory, fit, result.left, far, told, named)
    found += _ripples(laboratory, result.left, far, told, named)
    for i, burst in bursts(laboratory, result.left, far, told):
        share = share_beside(burst.energy, float(named[i]))
        beyond = Leftover(BURSTS, i, burst.energy, burst.floor, share, REST)
        found.append(replace(beyond, bursts=burst.count, at_s=burst.at_s))
    powers = [OnePower.of(laboratory, accepted, i) for i in range(laboratory.robot.n)]
    left_over = Remainder(tuple(found), explained, float(named.sum()))
    left_over = left_over.with_powers([power for power in powers if power is not None])
    # What says more of it comes first.
    told_of = {x.joint for x in left_over.significant}
    slid = [np.where(far, x, 0.0) for x in residuals[:2]]
    lasting = [slow_effort(laboratory, slid, i) for i in told if i not in told_of]
    return replace(left_over, found=(*left_over.found, *(x for x in lasting if x is not None)))


def scale_columns(laboratory: WhitenedRegression) -> list[CandidateColumns]:
    """Return the column of the torque constant of each joint that says something."""
    told = [i for i in range(laboratory.robot.n) if i not in laboratory.nominal.silent]
    return [laboratory.single(EffortScale(), i, {}) for i in told]


def with_scales(
    laboratory: WhitenedRegression, system: System, scales: Sequence[CandidateColumns]
) -> System:
    """Return a system in which torque constants may be off by their tolerance besides."""
    result, most = system.extended(scales), np.full(len(scales), scale_tolerance(laboratory))
    bound, prior = (
        np.concatenate([own, more])
        for own, more in ((system.bound, most), (system.prior, most / SIGMAS))
    )
    return replace(result, bound=bound, prior=prior)


def all_together(
    curves: Sequence[Leftover], energy: float, floor: float, named: float
) -> Leftover | None:
    """
    Return what all curves of a joint explain together where it is more than its causes do.

    Curves that are alike share what they explain: where a friction is spread over several of them
    none stands out. None where one does, or where the causes are the larger part.

    :param energy: of all curves together; ``floor``: what it has to exceed.
    :param named: energy that the causes explain.
    """
    share = share_beside(energy, named)
    if energy <= floor or share <= REST or any(x.significant for x in curves):
        return None
    most = max(curves, key=lambda x: x.energy)
    return Leftover(most.axis, most.joint, energy, floor, share, REST, together=True)


def free_curves(
    laboratory: WhitenedRegression, elsewhere: Elsewhere, joint: int
) -> list[FloatArray]:
    """Return the whitened hats of each curve of a joint, (rows, hats) each, as AXES has them."""
    columns = laboratory.structure_columns[joint]
    (at,) = np.flatnonzero(columns.rows == joint)
    own = columns.C[:, at].reshape(len(columns.C), -1)
    found = []
    for C in (own, laboratory.of_curve(elsewhere, joint)):
        found += [C[:, k : k + HATS] for k in range(0, C.shape[1], HATS)]
    return found


def _residual(fit: Fit) -> FloatArray:
    return np.asarray(fit.target.y - fit.system.Z @ fit.baseline.x)


def _ripples(
    laboratory: WhitenedRegression,
    left: FloatArray,
    far: BoolArray,
    joints: Sequence[int],
    named: FloatArray,
) -> list[Leftover]:
    """Return the strongest ripple of each joint, of its friction or of its torque constant."""
    # Motion that repeats turns around at the same places.
    clear = laboratory.split(far & clear_of_turns(laboratory))
    parts = laboratory.split(left)
    found = []
    for i in joints:
        friction, torque, speeds = [], [], []
        for signals, rows, own in zip(laboratory.signals, parts, clear, strict=True):
            q, v, sign, effort = (
                signals.band.at_rows(x[:, i])[ORDER:][own[:, i]]
                for x in (signals.q, signals.v, signals.sign, signals.whole_torque)
            )
            friction.append(Stretch(rows[own[:, i], i], q, sign))
            torque.append(Stretch(rows[own[:, i], i], q, effort))
            speeds.append(np.abs(v))
        first = laboratory.signals[0]
        # Where cogging is looked for, as far as half of the rows have it within the band.
        usual = max(float(np.median(np.concatenate([*speeds, [0.0]]))), 1e-300)
        tried = np.array([float(inner['frequency']) for inner in Cogging().grid(first, i)])
        tried = tried[tried < 2.0 * np.pi * first.band.cutoff / usual]
        what = {FRICTION_BY: friction, TORQUE_BY: torque}
        ripples = {name: strongest_ripple(each, tried) for name, each in what.items()}
        name, ripple = max(ripples.items(), key=lambda item: item[1].energy)
        if not ripple.tried:
            continue
        count = sum(len(x.left) for x in friction)
        # The price of three parameters, one of them the best of many, and clear evidence.
        lines = sum(each.tried for each in ripples.values())
        price = 3.0 * float(np.log(count)) + 2.0 * float(np.log(lines))
        # Of the rows, as many say something of it as a band up to it at top speed would have.
        hertz = ripple.frequency * float(first.scales.speed[i]) / (2.0 * np.pi)
        floor = max(RIPPLE * count * min(1.0, hertz / first.band.cutoff), price + VERY_STRONG)
        share = share_beside(ripple.energy, float(named[i]))
        period = 2.0 * np.pi / ripple.frequency
        found.append(
            Leftover(f'{name}{POSITION}', i, ripple.energy, floor, share, REST, period=period)
        )
    return found
