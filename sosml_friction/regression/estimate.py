# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The values of given terms: sizes, inner parameters and one covariance of everything fitted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.model.terms.kinds.fading_term import ABOUT
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.evidence import (
    AT_BOUND,
    UNIFORM,
    CandidateColumns,
    Fit,
    NormalEquations,
    System,
    solve_bounded,
)
from sosml_friction.regression.inner_scale import moved, per_step, step_between
from sosml_friction.regression.inner_search import refine, turning_displacement
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.report_slopes import ReportSlopes
from sosml_friction.regression.rival import rival_probability
from sosml_friction.regression.whitened import WhitenedRegression

#: Step of an inner parameter for the slope of the columns, as of inner_scale.py: the error of
#: the central difference is of the order of its square.
_STEP = 1e-3
#: The search is over where a round lowers the cost by less than this [noise variances], which is a
#: thirtieth of a standard error, or after so many rounds. Chosen.
_SETTLED, _MOST_ROUNDS = 1e-3, 12
#: A row is beside a reversal where what a reversal may add is more than this share of its largest.
#: Halved and doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
_BESIDE = 0.1
#: Shares of a step that are tried, until one lowers the cost.
_SHARES = (1.0, 0.5, 0.25, 0.1, 0.03)


def far_from_reversals(laboratory: WhitenedRegression, Z: FloatArray) -> BoolArray:
    """
    Return where the joint of a row does not turn around, (rows, n).

    How friction turns around is no cause. The columns ``Z`` (rows, n, p) begin with the nominal's.
    """
    which = [k for k, name in enumerate(laboratory.nominal.names) if ' reversal ' in name]
    peaks = np.abs(Z[:, :, which])
    share = peaks / np.maximum(peaks.max(axis=0), np.finfo(float).tiny)
    return np.asarray((share < _BESIDE).all(axis=2))


@dataclass(frozen=True)
class RivalFit:
    """
    Hold the fit in which a rival of the term ``which`` stands in its place.

    ``x`` as of the fit with the term; ``inner``: inner parameters of each term;
    ``probability``: of the rival.
    """

    which: int
    x: FloatArray
    inner: tuple[Inner, ...]
    probability: float


@dataclass(frozen=True)
class Estimate:
    """
    Hold the values of terms beside the nominal model.

    ``fit``: of the nominal's deviations, then the amplitudes of ``placed`` in order; ``errors``:
    their standard errors (p + k,); ``inner_errors``: of each term, those of its inner parameters.
    ``shift`` and ``inner_shift``: the part of them by which terms differ from their rivals, of
    those that explain more. ``by_tolerance``: by how much the nominal's deviations within their
    tolerance move each, the standard deviation and the most, (2, p + k). ``covariance`` (m, m):
    of everything together if no rival is true, steps of the inner parameters ``owners`` last,
    number of the term and name. ``rivals``: the fits with those.
    """

    placed: tuple[Placed, ...]
    fit: Fit
    errors: FloatArray
    inner_errors: tuple[Mapping[str, float], ...]
    shift: FloatArray
    inner_shift: tuple[Mapping[str, float], ...]
    by_tolerance: FloatArray
    covariance: FloatArray
    owners: tuple[tuple[int, str], ...]
    rivals: tuple[RivalFit, ...]

    def in_torque(self, laboratory: WhitenedRegression) -> tuple[FloatArray, FloatArray]:
        """Return what was fitted (p + k,) of the torque, and its standard errors."""
        x, report = self.fit.baseline.x, ReportSlopes.of(laboratory, self.placed)
        return report.torque(x), report.errors(x, self.errors, self.covariance)

    def fitted(self, laboratory: WhitenedRegression) -> list[Fitted]:
        """
        Return what was found of each term, as the term is asked about it.

        Sizes of what makes a torque are those of the torque, and not of a report that is wrong.
        """
        parts = with_amplitudes(self.placed, len(laboratory.nominal.bound))
        torque, errors = self.in_torque(laboratory)
        return [
            Fitted(
                laboratory.signals[0],
                placed.joint,
                placed.inner,
                placed.term.whole(torque[part]),
                errors[part],
                inner_errors,
            )
            for (placed, part), inner_errors in zip(parts, self.inner_errors, strict=True)
        ]


def settle(
    laboratory: WhitenedRegression,
    placed: Sequence[Placed],
    step: Callable[[str], None] = lambda text: None,
    held: frozenset[tuple[int, str]] = frozenset(),
) -> list[Placed]:
    """
    Return terms with the inner parameters that are best beside one another.

    Gauss and Newton's steps of all of them together (inner_scale.py), within their physical
    ranges, shortened until the cost falls.

    :param held: inner parameters that stay as they are, by number of the term and name.
    """
    result = list(placed)
    x, cost = equations_of(laboratory, result).solve()
    for number in range(_MOST_ROUNDS):
        linear = Linear.make(laboratory, result, x, held)
        if not linear.owners:
            break
        step(f'settling the inner parameters, round {number + 1}')
        change, before = linear.newton(), cost
        for share in _SHARES:
            ahead = linear.moved(result, share * change)
            there, its = equations_of(laboratory, ahead).solve()
            if its < before:
                result, x, cost = ahead, there, its
                break
        if before - cost < _SETTLED:
            break
    return result


def taken_up(system: System, columns: Sequence[CandidateColumns]) -> System:
    """
    Return a system without the free parameters whose column a term has as well.

    Only the sum of both is known: the term has all of it, and the nominal none.
    """
    G, bound = system.total, system.bound
    if np.isfinite(bound).all():
        return system
    for each in columns:
        A, B = (x[:, 0].sum(axis=0) for x in (each.A, each.B))
        same = _alike(G, A, B[: len(G)]).any(axis=1)
        bound = np.where(same & np.isinf(bound), 0.0, bound)
    return replace(system, bound=bound)


def _alike(G: FloatArray, A: FloatArray, B: FloatArray) -> BoolArray:
    """Return which columns are one (p, k), of the products G (p, p), A (k, k) and B (p, k)."""
    a, b = (np.sqrt(np.maximum(np.diag(x), np.finfo(float).tiny)) for x in (G, A))
    return np.asarray(np.abs(B) / a[:, None] / b > 1.0 - ROUNDING)


def system_with(laboratory: WhitenedRegression, columns: Sequence[CandidateColumns]) -> System:
    """Return the system of a regression with the columns of terms."""
    return taken_up(laboratory.system, columns).extended(columns)


def equations_of(laboratory: WhitenedRegression, placed: Sequence[Placed]) -> NormalEquations:
    """Return the normal equations of the nominal and the amplitudes of terms."""
    columns = [each.columns for each in placed]
    return NormalEquations.make(taken_up(laboratory.system, columns), laboratory.target, columns)


@dataclass(frozen=True)
class Linear:
    """
    Hold a fit linearised in its inner parameters.

    ``equations``: of deviations, ``known`` of them with the amplitudes, and of the ``slopes`` over
    steps of the inner parameters ``owners``: which term, which parameter, its value and
    physical range. ``stands_for``: which amplitudes may stand for a nominal parameter.
    """

    laboratory: WhitenedRegression
    equations: NormalEquations
    known: int
    slopes: tuple[CandidateColumns, ...]
    stands_for: BoolArray
    owners: tuple[tuple[int, str, float, tuple[float, float]], ...]

    @classmethod
    def make(
        cls,
        laboratory: WhitenedRegression,
        placed: Sequence[Placed],
        x: FloatArray,
        held: frozenset[tuple[int, str]] = frozenset(),
    ) -> Linear:
        """Return the fit ``x`` of settled terms, linearised in all but what is held."""
        slopes: list[CandidateColumns] = []
        owners: list[tuple[int, str, float, tuple[float, float]]] = []
        for k, (each, part) in enumerate(with_amplitudes(placed, len(laboratory.nominal.bound))):
            for name, ends in each.term.searched_inner(laboratory.signals[0], each.joint).items():
                if (k, name) not in held:
                    slopes.append(_slope(laboratory, each, name, ends, x[part]))
                    owners.append((k, name, float(each.inner[name]), ends))
        stands_for = [
            each.term.axis != 'acceleration'
            and (each.term.parameter_error or each.term.axis != 'body')
            for each in placed
            for _ in range(each.columns.C.shape[3])
        ]
        own = [each.columns for each in placed]
        system = taken_up(laboratory.system, own)
        equations = NormalEquations.make(system, laboratory.target, [*own, *slopes])
        stands = np.array(stands_for, bool)
        return cls(laboratory, equations, len(x), tuple(slopes), stands, tuple(owners))

    def newton(self) -> FloatArray:
        """Return the steps of the inner parameters to where the linearised cost is least."""
        count, sums = len(self.owners), self.equations
        ends = [[step_between(own, end, reach) for end in reach] for *_, own, reach in self.owners]
        low, high = np.minimum(np.array(ends).T, [[0.0], [np.inf]])
        known = sums.bound[: self.known]
        lower, upper = np.concatenate([-known, low]), np.concatenate([known, np.maximum(high, 0)])
        return solve_bounded(sums.G + np.diag(sums.penalty), sums.r, lower, upper)[-count:]

    def moved(self, placed: Sequence[Placed], change: FloatArray) -> list[Placed]:
        """Return terms whose inner parameters are changed."""
        inner = [dict(each.inner) for each in placed]
        for (k, name, own, ends), x in zip(self.owners, change.tolist(), strict=True):
            inner[k][name] = moved(own, x, ends)
        return [
            each if now == each.inner else each.with_inner(self.laboratory, now)
            for each, now in zip(placed, inner, strict=True)
        ]

    def covariance(self) -> tuple[FloatArray, IndexArray]:
        """
        Return the inverse of the curvature of the cost (m, m), and nominal parameters left out.

        A nominal parameter that a term stands for, with the same column, is no other parameter:
        the term has all of its change. Not so of a payload, which comes on top of a body that is
        as unsure as before, nor of an inertia, whose regressor is differentiated twice: the
        tolerance of the nominal one stays in its error, where it has one.
        """
        data, own, known = self.equations.G, len(self.laboratory.nominal.bound), self.known
        parts = data[:own, :own], data[own:known, own:known], data[:own, own:known]
        stands_for = self.stands_for | np.isinf(self.laboratory.system.bound)[:, None]
        named = np.flatnonzero((_alike(*parts) & stands_for).any(axis=1))
        return self._inverse(data, named, self.equations.penalty), named

    @staticmethod
    def _inverse(data: FloatArray, without: IndexArray, penalty: FloatArray) -> FloatArray:
        G = data.copy()
        G[without], G[:, without] = 0.0, 0.0
        G += np.diag(penalty)
        scale = 1.0 / np.sqrt(np.diag(G))
        return np.asarray(np.linalg.pinv(G * scale * scale[:, None]) * scale * scale[:, None])

    def variances(self, fit: Fit) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Return variances (m,) of all parameters of the ``fit``, and :meth:`_by_tolerance`, (2, m).

        Besides how all go together, (m, m): the sum of what noise says, the blocks, and each of
        the other causes, of which each moves all parameters at once.

        The variance is a sum over three causes:

        * noise: the curvature's, scaled by what is left where that is more than noise, or what the
          blocks of the recording say, each with its own sum of scores, where this is larger: noise
          and misfit may be correlated within a block;
        * the nominal model: each of its parameters is anywhere within its tolerance alike, which
          has three times the variance of the Gaussian that draws it there; where one sits at its
          bound, what that moves is an error too;
        * the build-up of friction: what the rows beside reversals move, beyond chance.
        """
        wide, x = fit.system.extended(self.slopes), fit.baseline.x
        covariance, named = self.covariance()
        data = self.equations.G.copy()
        data[named], data[:, named] = 0.0, 0.0
        left = fit.target.y - wide.Z[:, :, : len(x)] @ x
        scores = np.array(
            [np.einsum('rnp,rn->p', wide.Z[a:b], left[a:b]) for a, b in wide.blocks.ranges]
        )
        scores[:, named] = 0.0
        count = len(scores)
        # The prior pulls at all blocks alike.
        spread = (scores - scores.mean(axis=0)) @ covariance
        between = spread.T @ spread * count / (count - 1)
        ratio = max(fit.baseline.cost / float(self.laboratory.noise_energy.sum()), 1.0)
        noise = covariance @ data @ covariance * ratio
        tolerance = self._by_tolerance(covariance, wide)
        within = covariance * (UNIFORM * wide.prior_weight())
        others = within @ covariance.T
        for by in (
            self._beyond(x, named, scores.sum(axis=0)),
            self._by_reversals(x, wide.Z, left, named, covariance),
        ):
            others += np.outer(by, by)
        result = np.maximum(np.diag(noise), np.diag(between)) + np.diag(others)
        return result, tolerance, noise + between + others

    @staticmethod
    def _by_tolerance(covariance: FloatArray, system: System) -> FloatArray:
        """
        Return by how much deviations within their tolerance move all parameters, (2, m).

        The standard deviation, each anywhere within its bound b alike, with the variance b^2 / 3;
        and the most, all of them at their bounds.
        """
        weight = system.prior_weight()
        most = np.where(weight > 0.0, system.bound, 0.0)
        return np.array(
            [np.sqrt((covariance**2) @ (UNIFORM * weight)), np.abs(covariance) @ (weight * most)]
        )

    def _by_reversals(
        self,
        x: FloatArray,
        Z: FloatArray,
        left: FloatArray,
        named: IndexArray,
        covariance: FloatArray,
    ) -> FloatArray:
        """Return what the rows beside reversals move, (m,), beyond what chance would."""
        penalty = self.equations.penalty
        far = far_from_reversals(self.laboratory, Z)
        kept = Z * far[:, :, None]
        G = np.einsum('rnp,rnq->pq', kept, kept, optimize=True)
        alone = self._inverse(G, named, penalty)
        pull = np.einsum('rnp,rn->p', kept, left)
        pull[: len(x)] -= penalty[: len(x)] * x
        pull[named] = 0.0
        chance = np.maximum(np.diag(alone) - np.diag(covariance), 0.0)
        moved = alone @ pull
        return np.asarray(np.copysign(np.sqrt(np.maximum(moved**2 - chance, 0.0)), moved))

    def _beyond(self, x: FloatArray, named: IndexArray, score: FloatArray) -> FloatArray:
        """Return how all parameters would move if none of the nominal's were held by its bound."""
        bound = self.laboratory.nominal.bound
        at = np.abs(x[: len(bound)]) >= AT_BOUND * bound
        held = np.setdiff1d(np.flatnonzero(at & (bound > 0.0)), named)
        if not len(held):
            return np.zeros_like(score)
        penalty = self.equations.penalty.copy()
        penalty[held] -= self.laboratory.system.prior_weight()[held]
        pull = score.copy()
        pull[: len(x)] -= penalty[: len(x)] * x
        result = self._inverse(self.equations.G, named, penalty) @ pull
        # No further than to where it may be at all.
        return np.asarray(result * min(1.0, np.min(2.0 * bound[held] / np.abs(result[held]))))


def estimate(laboratory: WhitenedRegression, placed: Sequence[Placed]) -> Estimate:
    """
    Return sizes and errors of terms whose inner parameters are settled.

    One covariance of deviations, amplitudes and inner parameters together, these by the slope of
    their columns times the amplitudes.
    """
    fit = Fit.make(system_with(laboratory, [each.columns for each in placed]), laboratory.y)
    linear = Linear.make(laboratory, placed, fit.baseline.x)
    variance, tolerance, covariance = linear.variances(fit)
    for each, part in with_amplitudes(placed, len(laboratory.nominal.bound)):
        variance[part] += (_regressor_error(laboratory, each) * fit.baseline.x[part]) ** 2
    rivals = _rivals(laboratory, placed, fit)
    known, shift = linear.known, np.sqrt(_rival_variance(rivals, placed, linear, fit))
    errors = np.hypot(np.sqrt(variance), shift)
    inner: list[dict[str, float]] = [{} for _ in placed]
    shifts: list[dict[str, float]] = [{} for _ in placed]
    at = zip(linear.owners, errors[known:].tolist(), shift[known:].tolist(), strict=True)
    for (k, name, own, ends), error, by in at:
        body = _tolerance(laboratory) if name in placed[k].term.with_body else 0.0
        unit = per_step(own, ends)
        inner[k][name], shifts[k][name] = unit * float(np.hypot(error, body)), unit * by
    return Estimate(
        tuple(placed),
        fit,
        errors[:known],
        tuple(inner),
        shift[:known],
        tuple(shifts),
        tolerance[:, :known],
        covariance,
        tuple((k, name) for k, name, _, _ in linear.owners),
        tuple(rivals),
    )


def _rivals(laboratory: WhitenedRegression, placed: Sequence[Placed], fit: Fit) -> list[RivalFit]:
    """Return the fits in which a rival of a term stands in its place."""
    rivals = [(k, each, rival) for k, each in enumerate(placed) for rival in each.term.rivals()]
    if not rivals:
        return []
    found = []
    cost = equations_of(laboratory, placed).solve()[1]
    ratio = max(fit.baseline.cost / float(laboratory.noise_energy.sum()), 1.0)
    for k, each, rival in rivals:
        one = replace(each, term=rival).with_inner(laboratory, each.inner)
        others = settle(laboratory, [*placed[:k], one, *placed[k + 1 :]])
        x, its = equations_of(laboratory, others).solve()
        inner = tuple(other.inner for other in others)
        found.append(RivalFit(k, x, inner, rival_probability((its - cost) / ratio)))
    return found


def _rival_variance(
    rivals: Sequence[RivalFit], placed: Sequence[Placed], linear: Linear, fit: Fit
) -> FloatArray:
    """
    Return the variance of all parameters (m,) by not knowing which of a term's rivals is true.

    w d^2, with d what changes with the rival and w its probability. Of inner parameters it is
    that of their steps.
    """
    result = np.zeros(linear.known + len(linear.owners))
    for rival in rivals:
        steps = [
            step_between(own, float(rival.inner[k][name]), ends)
            for k, name, own, ends in linear.owners
        ]
        d = np.concatenate([rival.x - fit.baseline.x, steps])
        result += rival.probability * d**2
    return result


def _regressor_error(laboratory: WhitenedRegression, each: Placed) -> float:
    """
    Return by which share a term's columns may be wrong, and its sizes with them.

    Where they are computed from the bodies, or the effort, of the nominal model, these are wrong
    by their tolerance, anywhere within it alike.
    """
    more = 1.0 + _tolerance(laboratory)
    own = laboratory.signals[0].robot
    robot = own.changed(
        more * own.inertial_parameters(), more * np.array(own.armature), own.gravity_acceleration
    )
    signals = tuple(
        replace(s, robot=robot, rigid=more * s.rigid, friction=more * s.friction, cache={})
        for s in laboratory.signals
    )
    other = replace(laboratory, rows=replace(laboratory.rows, signals=signals))
    C = each.columns.C
    changed = other.single(each.term, each.joint, each.inner).C
    return float(np.vdot(changed - C, C) / max(float(np.vdot(C, C)), np.finfo(float).tiny))


def _tolerance(laboratory: WhitenedRegression) -> float:
    """Return the standard deviation of what is anywhere within its tolerance, as a share."""
    return float(laboratory.settings.tolerance / np.sqrt(3.0))


def _slope(
    laboratory: WhitenedRegression,
    each: Placed,
    name: str,
    ends: tuple[float, float],
    amplitude: FloatArray,
) -> CandidateColumns:
    """Return the slope over an inner parameter's step of what a term explains."""
    own = float(each.inner[name])
    unit = _STEP * per_step(own, ends)
    ahead, behind = (
        laboratory.single(each.term, each.joint, {**each.inner, name: own + sign * unit})
        for sign in (1.0, -1.0)
    )
    change = (ahead.C - behind.C) @ amplitude / (2.0 * _STEP)
    return CandidateColumns.make(laboratory.system, each.columns.rows, change[..., None])


def refined_again(laboratory: WhitenedRegression, placed: Sequence[Placed]) -> list[Placed]:
    """
    Return terms, refined anew where friction turns around over another displacement by now.

    A term that says so may have been found after them, or have been taken out again.
    """
    result = list(placed)
    for k, each in enumerate(placed):
        others = [*result[:k], *result[k + 1 :]]
        now = turning_displacement(laboratory, each.joint, others)
        before = each.term.about or turning_displacement(laboratory, each.joint, ())
        # What was tried or taken then goes as far.
        if ABOUT[0] * before <= now <= ABOUT[1] * before or each.term.further(now) is None:
            continue
        fit = Fit.make(system_with(laboratory, [own.columns for own in others]), laboratory.y)
        plain = type(each.term)()
        start = {name: each.inner[name] for name in plain.inner}
        term, inner, _, columns = refine(laboratory, fit, plain, each.joint, start, others)
        result[k] = Placed(term, each.joint, inner, columns)
    return result


def place(
    laboratory: WhitenedRegression,
    wanted: Sequence[tuple[str, int]],
    step: Callable[[str], None] = lambda text: None,
) -> list[Placed]:
    """
    Return candidates with their inner parameters, in the order of what they explain.

    As a diagnosis accepts causes: the one that explains most at the best point of its grid first,
    refined beside those before it.
    """
    left = [
        (candidate, columns)
        for candidate, columns in zip(laboratory.candidates, laboratory.columns, strict=True)
        if (candidate.effect.identifier, candidate.joint) in wanted
    ]
    placed: list[Placed] = []
    while left:
        fit = Fit.make(system_with(laboratory, [each.columns for each in placed]), laboratory.y)
        scores = [fit.score(its, own.effect.amplitude_range) for own, its in left]
        k = int(np.argmax([s.gain for s in scores]))
        candidate, _ = left.pop(k)
        term, joint = candidate.effect, candidate.joint
        step(f'fitting {term.identifier}')
        start = candidate.grid[scores[k].best]
        term, inner, _, columns = refine(laboratory, fit, term, joint, start, placed)
        placed.append(Placed(term, joint, inner, columns))
    return placed
