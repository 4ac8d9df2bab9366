# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which plateau speeds a ladder needs for a wanted standard error, by the Cramer-Rao bound."""

import inspect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.segments import SegmentSettings
from sosml_friction.model.laws import FRICTION_LAWS
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder

#: From information (..., 5, 5) to what is minimised (...).
Score = Callable[[FloatArray], FloatArray]

PARAMETERS = FRICTION_LAWS['stribeck'].parameter_names
#: Four speeds are the fewest that determine C, B, S and v_s; both directions give the bias.
FEWEST_SPEEDS = 4
LONGEST_S = 3600.0
_TOP_SPEED: float = inspect.signature(speed_ladder).parameters['top_speed'].default


@dataclass(frozen=True)
class PlanSettings:
    """
    Say what is known before the experiment.

    ``noise``: standard deviation of a sample of friction [Nm or N], and ``correlation_s`` the time
    tau of its autocorrelation exp(-|t| / tau) [s]. The ladder has plateaus of ``plateau_s``, of
    which the evaluation drops ``trim_s``, and ramps of ``ramp_s`` [s]; its speeds are among
    ``candidates`` between ``slowest`` and ``fastest`` [rad/s or m/s], evenly apart in the
    logarithm.
    """

    noise: float = 0.05
    correlation_s: float = 0.005
    plateau_s: float = 1.0
    ramp_s: float = 0.3
    trim_s: float = SegmentSettings().trim_s + SegmentSettings().window_s
    slowest: float = 0.01
    fastest: float = 0.7
    candidates: int = 24

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < np.inf:
                raise ConfigurationError(f'{name} is {value}: give a positive number')
        if not self.plateau_s > self.trim_s + SegmentSettings().minimum_s:
            raise ConfigurationError(
                f'a plateau of {self.plateau_s} s is too short: {self.trim_s:g} s are trimmed and '
                f'{SegmentSettings().minimum_s:g} s must be left'
            )
        if not self.slowest < self.fastest:
            raise ConfigurationError(
                f'the slowest speed is {self.slowest} and the fastest {self.fastest}: make the '
                'first smaller'
            )
        if not FEWEST_SPEEDS <= self.candidates <= 40:
            raise ConfigurationError(
                f'there are {self.candidates} candidates: give {FEWEST_SPEEDS} to 40'
            )

    @property
    def speeds(self) -> FloatArray:
        """Return the candidates, rising."""
        return np.geomspace(self.slowest, self.fastest, int(self.candidates))

    @property
    def level_std(self) -> float:
        """
        Return the standard deviation of the mean friction of one plateau [Nm or N].

        sigma sqrt(2 x (1 - x (1 - exp(-1 / x)))), x = tau / length: that of the mean of noise with
        an exponential autocorrelation. A median is up to sqrt(pi / 2) times worse.
        """
        x = self.correlation_s / (self.plateau_s - self.trim_s)
        return float(self.noise * np.sqrt(2.0 * x * (1.0 - x * (1.0 - np.exp(-1.0 / x)))))


@dataclass(frozen=True)
class ExperimentPlan:
    """
    Hold a ladder and what it can give.

    ``speeds``: plateau speeds of :func:`~.speed_ladder.speed_ladder`,
    rising, one as often as it is to be listed. ``std_errors``: the Cramer-Rao bound of every
    parameter; ``wanted`` those asked for. ``needed_s``: how long the ladder lasts that reaches all
    wanted errors, an extrapolation where that is more than an hour.
    """

    speeds: tuple[float, ...]
    duration_s: float
    std_errors: Mapping[str, float]
    wanted: Mapping[str, float]
    level_std: float
    needed_s: float

    @property
    def missed(self) -> list[str]:
        """Return the parameters whose wanted error is not reached."""
        return [name for name, error in self.wanted.items() if self.std_errors[name] > error]


def plan_experiment(
    wanted: Mapping[str, float],
    budget_s: float,
    assumed: Mapping[str, float],
    settings: PlanSettings | None = None,
) -> ExperimentPlan:
    """
    Return the shortest ladder that reaches the wanted standard errors, or the best in the budget.

    Minimises the largest ratio of standard error to wanted error; among ladders that are alike in
    that, it takes one that tells the other parameters too. It begins with the best four of
    the candidate speeds (all sets are tried), adds the best one at a time, and after each
    exchanges a chosen speed for another as long as that improves it. Bounds are for unbiased
    estimates from independent levels at known speeds, with the law true; they depend on the
    assumed parameters, most on v_s.

    :param assumed: parameters of the Stribeck law (17), see
        :mod:`~sosml_friction.model.laws`.
    :raises ConfigurationError: if a name or number cannot be used, or the budget is too short for
        four speeds.
    """
    settings = settings or PlanSettings()
    _check(wanted, budget_s, assumed)
    speeds = settings.speeds
    of_each = np.array([information([w], assumed, settings.level_std) for w in speeds])
    names = [PARAMETERS.index(name) for name in wanted]
    errors = np.array(list(wanted.values()))

    def worst(total: FloatArray) -> FloatArray:
        return np.sqrt(np.max(_variances(total)[..., names] / errors**2, axis=-1))

    # All ladders of a length tell the bias alike, many the friction: of these, one that leaves no
    # other parameter unknown. Where all are known to some percent it is the ratio to 1e-4.
    size = np.array([abs(assumed[name]) or settings.level_std for name in PARAMETERS])

    def score(total: FloatArray) -> FloatArray:
        others = np.minimum(np.sqrt(_variances(total)) / size, 1e3).mean(axis=-1)
        return np.asarray(worst(total) * (1.0 + 1e-3 * others))

    def ratio_and_duration(counts: IndexArray) -> tuple[float, float]:
        ratio = float(worst(np.tensordot(counts, of_each, axes=1)))
        return ratio, ladder_duration(np.repeat(speeds, counts), settings)

    counts = _best_four(of_each, score)
    ratio, duration = ratio_and_duration(counts)
    if duration > budget_s:
        raise ConfigurationError(
            f'{budget_s:g} s are too short: the law needs {FEWEST_SPEEDS} speeds, and these take '
            f'{duration:.0f} s: allow more, or shorter plateaus'
        )
    best, best_ratio = counts, ratio
    # On beyond the budget, for the time that all wanted errors take.
    while ratio > 1.0 and duration <= LONGEST_S:
        added = score(np.tensordot(counts, of_each, axes=1) + of_each)
        counts = counts.copy()
        counts[int(np.argmin(added))] += 1
        counts = _exchange(counts, of_each, score)
        ratio, duration = ratio_and_duration(counts)
        if duration <= budget_s and ratio < best_ratio:
            best, best_ratio = counts, ratio
    chosen = np.repeat(speeds, best).tolist()
    found = np.sqrt(_variances(np.tensordot(best, of_each, axes=1)))
    return ExperimentPlan(
        tuple(float(f'{w:.4g}') for w in chosen),
        ladder_duration(chosen, settings),
        dict(zip(PARAMETERS, found.tolist(), strict=True)),
        dict(wanted),
        settings.level_std,
        # Where it ended early, errors fall with the root of the time.
        duration * max(1.0, ratio**2),
    )


def information(
    speeds: Sequence[float], assumed: Mapping[str, float], level_std: float
) -> FloatArray:
    """
    Return the Fisher information (5, 5) of a ladder, in the order of :data:`PARAMETERS`.

    A listed speed has four plateaus, two in each direction. The derivative of a level
    s (C + S exp(-|v| / v_s)) + B v + bias, s = sgn v, is
    (s, v, s exp(-|v| / v_s), s S |v| / v_s^2 exp(-|v| / v_s), 1).
    """
    w = np.asarray(speeds, dtype=float)
    v = np.concatenate([w, -w])
    s, vs = np.sign(v), assumed['stribeck_velocity']
    e = s * fade(v, vs, 1.0)
    rows = np.column_stack([s, v, e, e * assumed['stribeck'] * np.abs(v) / vs**2, np.ones(len(v))])
    return np.asarray(2.0 * rows.T @ rows / level_std**2)


def ladder_duration(speeds: Sequence[float] | FloatArray, settings: PlanSettings) -> float:
    """
    Return how long :func:`~.speed_ladder.speed_ladder` lasts [s].

    For one joint that starts at the centre, with the top speed that the ladder has by default.
    """
    w = np.concatenate([speeds, speeds[::-1]])
    # Where each pair of plateaus begins, and the rests at the centre before and after all.
    begins = np.pad(0.5 * w * (settings.plateau_s + settings.ramp_s), 1)
    moves = np.maximum(0.4, 15.0 / 8.0 * np.abs(np.diff(begins)) / _TOP_SPEED)
    return float(moves.sum() + len(w) * (2.0 * settings.plateau_s + 4.0 * settings.ramp_s))


def _check(wanted: Mapping[str, float], budget_s: float, assumed: Mapping[str, float]) -> None:
    if not wanted:
        raise ConfigurationError(
            f'no standard error is wanted: name one or more of {", ".join(PARAMETERS)}'
        )
    for name, value in wanted.items():
        if name not in PARAMETERS or not 0.0 < value < np.inf:
            raise ConfigurationError(
                f'the wanted standard error {name}={value} cannot be used: give a positive number '
                f'for one of {", ".join(PARAMETERS)}'
            )
    if not 0.0 < budget_s <= LONGEST_S:
        raise ConfigurationError(
            f'the budget is {budget_s} s: give a positive time up to {LONGEST_S:.0f} s'
        )
    for name in PARAMETERS:
        value = assumed.get(name, np.nan)
        positive = name in ('stribeck', 'stribeck_velocity')
        if not np.isfinite(value) or (positive and not value > 0.0):
            raise ConfigurationError(
                f'the assumed {name} is {value}: give a {"positive " if positive else ""}number '
                '(without a Stribeck term its velocity cannot be found)'
            )


def _variances(total: FloatArray) -> FloatArray:
    """Return the diagonals of the inverses (..., 5), infinite where there is no inverse."""
    # In units that make the diagonal one, the eigenvalues do not depend on those of parameters.
    unit = 1.0 / np.sqrt(np.diagonal(total, axis1=-2, axis2=-1))
    values, vectors = np.linalg.eigh(total * unit[..., :, None] * unit[..., None, :])
    good = values[..., 0] > 1e-12
    safe = np.where(good[..., None], values, 1.0)
    variances = np.einsum('...ij,...j->...i', vectors**2, 1.0 / safe) * unit**2
    return np.where(good[..., None], variances, np.inf)


def _best_four(of_each: FloatArray, score: Score) -> IndexArray:
    sets = np.array(list(itertools.combinations(range(len(of_each)), FEWEST_SPEEDS)))
    counts = np.zeros(len(of_each), dtype=np.int64)
    counts[sets[int(np.argmin(score(of_each[sets].sum(axis=1))))]] = 1
    return counts


def _exchange(counts: IndexArray, of_each: FloatArray, score: Score) -> IndexArray:
    """Swap one chosen speed for another, the best swap each time, until none improves."""
    while True:
        total = np.tensordot(counts, of_each, axes=1)
        chosen = np.flatnonzero(counts)
        scores = score(total + of_each[None] - of_each[chosen][:, None])
        out, into = np.unravel_index(int(np.argmin(scores)), scores.shape)
        if not scores[out, into] < float(score(total)) * (1.0 - 1e-9):
            return counts
        counts = counts.copy()
        counts[chosen[out]] -= 1
        counts[into] += 1
