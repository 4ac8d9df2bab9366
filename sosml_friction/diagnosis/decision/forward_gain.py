# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How far the simulation of data left out of the fit goes astray, refitted and with causes."""

import itertools
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.known_terms import CONSTANTS, known_terms, model_friction
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import ChangedBody
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.simulated_term import Body, Motion, SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.model.terms.presliding_hysteresis import PreslidingHysteresis
from sosml_friction.regression.chance import BEYOND_CHANCE
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.nominal import EFFORT_HOLD, KNEE, LATE, SOFTER, TURNS
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.report_slopes import ReportSlopes
from sosml_friction.regression.signals import Signals, bump
from sosml_friction.regression.whitened import WhitenedRegression
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.stretch import can_be_simulated, simulate_windows
from sosml_friction.simulation.window_models import WindowModels

#: Length of a simulated window [s], from the measured state. By definition: the error of position
#: after it is what is told.
HORIZON_S = 0.3
#: Most windows of a block: those of 14 blocks know the size of an error to 1 / sqrt(2 140) = 6 %.
#: They do not overlap: their errors would not be independent.
_PER_BLOCK = 10


@dataclass(frozen=True)
class WindowSet:
    """Hold windows of one stretch that a fit did not see; ``fold`` None: no fit saw them."""

    signals: Signals
    at: IndexArray
    samples: int
    fold: int | None


class ForwardGain:
    """
    Simulate windows of data left out of a fit, from the measured state by the measured effort.

    :param model: the nominal, with the effects in its list.
    :param others: signals of another recording to simulate, in the place of folds left out.
    """

    def __init__(
        self,
        laboratory: WhitenedRegression,
        model: RobotModelFile,
        others: Sequence[Signals] | None = None,
    ) -> None:
        self._laboratory = laboratory
        self._friction = model_friction(model)
        self._known = known_terms(model)
        self._windows = (
            _of_folds(laboratory)
            if others is None
            else _of_recording(others, _PER_BLOCK * laboratory.settings.blocks)
        )

    def squares(
        self, findings: Sequence[Finding], x: FloatArray, fold_x: FloatArray
    ) -> FloatArray:
        """
        Return the mean square of the error of position in each window, (W, n) [rad2 or m2].

        Infinite where the simulation runs away or is impossible; (0, n) where no window fits in.

        :param x: deviations of the nominal, then the amplitudes of the findings (p + k,).
        :param fold_x: the same without each fold (folds, p + k).
        """
        x, fold_x = (self._in_torque(findings, own) for own in (x, fold_x))
        result = [np.zeros((0, self._laboratory.robot.n))]
        # The windows of a stretch are simulated together, each by the model of its fold.
        for _, group in itertools.groupby(self._windows, key=lambda own: id(own.signals)):
            sets = list(group)
            numbers = [x if own.fold is None else fold_x[own.fold] for own in sets]
            result.append(self._together(sets, findings, numbers))
        return np.concatenate(result)

    def _in_torque(self, findings: Sequence[Finding], x: FloatArray) -> FloatArray:
        """Return parameters (..., p + k) in torque."""
        lab = self._laboratory
        report = ReportSlopes.of(lab, [finding.placed for finding in findings])
        own = [report.torque(each) for each in np.atleast_2d(x)]
        return np.array(own).reshape(x.shape)

    def _together(
        self,
        sets: Sequence[WindowSet],
        findings: Sequence[Finding],
        numbers: Sequence[FloatArray],
    ) -> FloatArray:
        """Return the mean squares in the windows of one stretch, set after set."""
        signals, samples = sets[0].signals, sets[0].samples
        at = np.concatenate([own.at for own in sets])
        parts = []
        ends = np.cumsum([0, *(len(own.at) for own in sets)])
        for x, (first, last) in zip(numbers, itertools.pairwise(ends), strict=True):
            # No inertia left: it is no model of anything.
            with suppress(ConfigurationError):
                parts.append((self._model(signals, findings, x), np.arange(first, last)))
        found = np.full((len(at), self._laboratory.robot.n), np.inf)
        while parts:
            able = np.concatenate([own for _, own in parts])
            # Their posture, in which all are simulated, is another one without those of a model
            # that is too stiff for any step.
            kept = [part for part in parts if can_be_simulated(part[0], signals, at[able])]
            if len(kept) == len(parts):
                of = np.repeat(np.arange(len(parts)), [len(own) for _, own in parts])
                models = WindowModels([model for model, _ in parts], of)
                with np.errstate(all='ignore'):
                    run = simulate_windows(models, signals, at[able], samples)
                    error = run.q - signals.q[at[able, None] + np.arange(samples)]
                    square = np.mean(error**2, axis=1)
                # What single precision cannot hold has run away; its square is a number still.
                found[able] = np.where(square < np.finfo(np.float32).max, square, np.inf)
                break
            parts = kept
        return found

    def _model(self, signals: Signals, findings: Sequence[Finding], x: FloatArray) -> ForwardModel:
        """Return the nominal with deviations and causes."""
        nominal, robot = self._laboratory.nominal, self._laboratory.robot
        stated = {name for each in nominal.stated for name in each.known.names}
        friction: dict[str, FloatArray] = {}
        body = Body.unchanged(robot.n)
        off = self._off(findings, x)
        delay = np.zeros(robot.n)
        terms: list[SimulatedTerm] = []
        for known in self._known:
            amplitude = known.amplitude + [off.pop(key, 0.0) for key in known.names]
            terms.append(replace(known, amplitude=amplitude).simulated(robot))
        for name, value in off.items():
            joint, _, what = name.rpartition(' ')
            friction.setdefault(what, np.zeros(robot.n))[robot.names.index(joint)] += value
        displacement = signals.scales.displacement
        for name, value in zip(nominal.names, x, strict=False):
            joint, _, what = name.partition(' ')
            i = robot.names.index(joint) if joint in robot.names else -1
            if i >= 0 and what in CONSTANTS:
                friction.setdefault(what, np.zeros(robot.n))[i] += value
            elif i >= 0 and what.startswith('body '):
                body.inertias[i, int(what.removeprefix('body '))] += value
            elif i >= 0 and what == 'armature':
                body.rotors[i] += value
            elif i >= 0 and what.startswith('reversal '):
                turn = what.removeprefix('reversal ')
                # It would need the state of the future; left out with the causes and without.
                if turn not in (LATE, SOFTER, KNEE):
                    terms.append(
                        reversal_term(robot, i, turn, float(value), float(displacement[i]))
                    )
            elif i >= 0 and what == EFFORT_HOLD:
                # Of steps of the median length; the simulation has one delay for all.
                delay[i] += float(value) * float(np.mean(signals.held))
            elif name not in stated:
                raise ValueError(f'the simulation does not know the parameter {name!r}')

        terms.append(ChangedBody([body], [1.0]))
        for finding, own in with_amplitudes(findings, len(nominal.names)):
            if finding.effect.stated is None:
                terms.append(finding.effect.simulated(robot, finding.joint, finding.inner, x[own]))
        return ForwardModel(robot, self._friction.changed(friction), displacement, terms, delay)

    def _off(self, findings: Sequence[Finding], x: FloatArray) -> dict[str, float]:
        """Return by how much each number of the stated terms is off, by its name."""
        nominal = self._laboratory.nominal
        names = [name for each in nominal.stated for name in each.known.names]
        off = {name: float(x[nominal.names.index(name)]) for name in names}
        for finding, own in with_amplitudes(findings, len(nominal.names)):
            for name, change in zip(finding.effect.stated_names, x[own], strict=False):
                off[name] += float(change)
        return off


def reversal_term(
    robot: Robot, joint: int, turn: str, size: float, displacement: float
) -> SimulatedTerm:
    """
    Return friction that turns around at a reversal otherwise than the sign s does.

    size (z - s) of a state z that changes ``sooner`` or ``later``, or, its ``shape``, size s (1 -
    s^2): what a nominal whose friction builds up in another way is refitted with.
    """
    term: EffortTerm = _ReversalShape() if turn == 'shape' else PreslidingHysteresis()
    inner = {} if turn == 'shape' else {'displacement': TURNS[turn] * displacement}
    return term.simulated(robot, joint, inner, np.array([size]))


class _ReversalShape(EffortTerm):
    """s (1 - s^2): 0 before and after a reversal's build-up, another shape within."""

    amplitudes: ClassVar[Mapping[str, str]] = {'size': '{effort}'}

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        return (bump(motion.sign[:, joint]),)


def _of_folds(laboratory: WhitenedRegression) -> list[WindowSet]:
    """Return windows inside of the blocks, evenly spread, those of one fold together."""
    blocks = laboratory.blocks
    found: dict[tuple[int, int], list[int]] = {}
    counts = [len(x) for x in laboratory.split(laboratory.y)]
    ends = np.cumsum(counts)
    for b, (first, last) in enumerate(itertools.pairwise(blocks.edges)):
        for s, signals in enumerate(laboratory.signals):
            begin = int(ends[s] - counts[s])
            low, high = max(int(first), begin), min(int(last), int(ends[s]))
            samples = _samples(signals)
            # The row of a sample, and back.
            band = signals.band
            start = band.first + (low - begin + ORDER) * band.factor
            stop = band.first + (high - 1 - begin + ORDER) * band.factor - samples
            if high <= low or stop < start:
                continue
            at = _spread(start, stop, samples, _PER_BLOCK)
            found.setdefault((s, int(blocks.fold[b])), []).extend(at.tolist())
    return [
        WindowSet(laboratory.signals[s], np.array(at), _samples(laboratory.signals[s]), fold)
        for (s, fold), at in sorted(found.items())
    ]


def _of_recording(others: Sequence[Signals], most: int) -> list[WindowSet]:
    """Return windows evenly spread over another recording, in proportion to its stretches."""
    whole = sum(len(s.q) for s in others)
    result = []
    for s in others:
        samples = _samples(s)
        room = len(s.q) - 2 * s.band.half - samples
        count = round(most * len(s.q) / whole)
        if room > 0 and count > 0:
            at = _spread(s.band.half, s.band.half + room, samples, count)
            result.append(WindowSet(s, at, samples, None))
    return result


def _spread(first: int, last: int, samples: int, most: int) -> IndexArray:
    """Return evenly spread begins of windows that do not overlap, from ``first`` to ``last``."""
    count = min(most, (last - first) // samples + 1)
    if count < 2:
        return np.array([(first + last) // 2], dtype=np.int64)
    return np.linspace(first, last, count).astype(np.int64)


def _samples(signals: Signals) -> int:
    return max(2, round(HORIZON_S / signals.band.step)) + 1


def gets_worse(before: FloatArray, after: FloatArray, rows: IndexArray) -> bool:
    """
    Tell whether the errors of windows (W, n) got larger, beyond chance, in the joints ``rows``.

    Each joint counts alike; the mean of the differences between the same windows is put beside its
    standard error: most of the error of both is the noise of the measured effort.
    """
    before, after = before[:, rows], after[:, rows]
    if (np.isinf(after) & ~np.isinf(before)).any():
        return True
    # What runs away with and without says nothing.
    both = np.isfinite(before).all(axis=1) & np.isfinite(after).all(axis=1)
    if not both.any():
        return False
    before, after = before[both], after[both]
    size = np.maximum(before.mean(axis=0), 1e-300)
    change = ((after - before) / size).mean(axis=1)
    error = float(np.std(change)) / np.sqrt(len(change))
    return bool(change.mean() > BEYOND_CHANCE * error)
