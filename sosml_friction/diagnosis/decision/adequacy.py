# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a named cause is the whole of what acts along its own axis."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.leftover import (
    NEIGHBOUR_FRICTION,
    NEIGHBOURS,
    POSITION,
    SPEED,
    Leftover,
)
from sosml_friction.diagnosis.decision.null_recordings import null_recordings
from sosml_friction.model.terms.kinds.term import Term
from sosml_friction.regression.curves.neighbour_curve import NeighbourCurve
from sosml_friction.regression.curves.neighbour_friction import NeighbourFriction
from sosml_friction.regression.curves.position_curve import PositionCurve
from sosml_friction.regression.curves.reversal import Reversal
from sosml_friction.regression.curves.speed_curve import SpeedCurve
from sosml_friction.regression.curves.speed_power import SpeedPower
from sosml_friction.regression.evidence import Fit, Score
from sosml_friction.regression.whitened import WhitenedRegression

#: Axes of free curves that could stand for causes (``Term.free_axis``); of the curve of position,
#: the largest share of what it and the causes explain with which these are the whole. Chosen, no
#: measurement.
_POSITION_SHARE = 0.1
#: That power has to explain this much more energy [noise variances] beside the price of the
#: parameters; in the place of one cause, as simple as it is, also this share more: columns are not
#: known any better. Chosen, no measurement.
_MORE, _MORE_SHARE = 10.0, 0.005
#: Causes are clearly more than what noise of position feigns from this many times as much on.
#: Chosen, no measurement.
_CLEARLY = 2.0


@dataclass(frozen=True)
class _Probe:
    """
    Hold a free curve to try in one joint, and the causes that it could make up.

    ``least`` and ``foreign`` as in :class:`Leftover`. ``beside_speed``: beside any friction by
    speed, of which what is left within its own share would show here; and beside a joint that
    hardly moves, what follows it is a constant. ``few``: its columns are so few that the largest
    of some nulls says little, and it needs the evidence of a cause.
    """

    axis: str
    joint: int
    effect: Term
    causes: Sequence[Finding]
    least: float
    beside_speed: bool = False
    foreign: bool = False
    few: bool = False


def _probes(laboratory: WhitenedRegression, accepted: Sequence[Finding]) -> list[_Probe]:
    """Return the free curves to try beside the causes of each joint."""
    accepted = [f for f in accepted if not f.effect.of_robot]
    if not accepted:
        return []
    settings, stretches = laboratory.settings, laboratory.signals
    share = settings.axis_share
    # Causes that follow the nominal's load are off by its tolerance: in energy, by the square.
    square = settings.tolerance**2
    position, neighbour = PositionCurve(stretches), NeighbourCurve(stretches)
    probes = []
    for i in range(laboratory.robot.n):
        mine = [f for f in accepted if f.joint == i]
        if by_speed := [f for f in mine if f.effect.free_axis == SPEED]:
            probes.append(_Probe(SPEED, i, SpeedCurve(), by_speed, share))
        if by_position := [f for f in mine if f.effect.free_axis == POSITION]:
            probes.append(
                _Probe(POSITION, i, position, by_position, _POSITION_SHARE, foreign=True)
            )
        if mine and laboratory.robot.n > 1:
            of_next = partial(_Probe, joint=i, causes=mine, beside_speed=True, foreign=True)
            probes.append(of_next(NEIGHBOURS, effect=neighbour, least=share))
            friction = NeighbourFriction()
            probes.append(of_next(NEIGHBOUR_FRICTION, effect=friction, least=square, few=True))
    return probes


def _price(laboratory: WhitenedRegression) -> float:
    """Return what a parameter costs in evidence."""
    return float(np.log(laboratory.y.shape[0]))


def leftovers(laboratory: WhitenedRegression, accepted: Sequence[Finding]) -> tuple[Leftover, ...]:
    """
    Return what a free curve still predicts beside the causes of each joint with such an axis.

    Friction that turns around in another way at reversals is taken out of both sides first. The
    floor is ``axis_margin`` times the largest gain over simulated recordings that hold the
    accepted causes and nothing else; beside causes that are clearly more than that also what noise
    of position feigns, which these recordings do not hold.
    """
    probes = _probes(laboratory, accepted)
    if not probes:
        return ()
    joints = sorted({probe.joint for probe in probes})
    turns = [laboratory.single(Reversal(), i, {}) for i in joints]
    system = laboratory.system.extended([*(f.columns for f in accepted), *turns])
    free = system.extended([laboratory.single(SpeedCurve(), i, {}) for i in joints])
    curves = [
        laboratory.single(probe.effect, probe.joint, {}).beside(
            free if probe.beside_speed else system
        )
        for probe in probes
    ]

    def scored(y: FloatArray) -> tuple[list[Score], FloatArray]:
        """Return the score of each curve, and the parameters of ``system`` without it."""
        fits = Fit.make(system, y), Fit.make(free, y)
        result = [
            fits[probe.beside_speed].score(curve)
            for probe, curve in zip(probes, curves, strict=True)
        ]
        return result, fits[0].baseline.x

    found, x = scored(laboratory.y)
    settings = laboratory.settings
    largest = np.zeros(len(probes))
    seed = [settings.seed, 1000 + len(accepted)]
    for y in islice(null_recordings(laboratory, system, x, system, seed), settings.axis_nulls):
        largest = np.maximum(largest, [s.gain for s in scored(y)[0]])
    result = []
    for probe, s, most in zip(probes, found, largest, strict=True):
        named = sum(max(f.score.gain, 0.0) for f in probe.causes)
        share = s.gain / max(named + s.gain, 1e-300)
        floor = settings.axis_margin * float(most)
        feigned = laboratory.feigned * float(laboratory.known[probe.joint])
        if probe.few:
            k = int((s.amplitude != 0.0).sum())
            floor = max(floor, k * _price(laboratory) + settings.least_bic)
        elif named > _CLEARLY * feigned:
            floor += feigned
        result.append(
            Leftover(
                probe.axis, probe.joint, s.gain, s.energy, floor, share, probe.least,
                foreign=probe.foreign,
            )
        )  # fmt: skip
    instead = _instead(laboratory, accepted)
    where = {(x.axis, x.joint) for x in instead}
    return (*(x for x in result if (x.axis, x.joint) not in where), *instead)


def _instead(laboratory: WhitenedRegression, accepted: Sequence[Finding]) -> list[Leftover]:
    """Return where one power of speed explains more than the causes by speed of a joint."""
    result = []
    power = SpeedPower()
    for i in range(laboratory.robot.n):
        mine = [f for f in accepted if f.joint == i and f.effect.one_power]
        if not mine:
            continue
        # By place and not by equality: arrays have no one truth value.
        others = [f.columns for f in accepted if all(f is not own for own in mine)]
        fit = Fit.make(laboratory.system.extended(others), laboratory.y)
        whole = Fit.make(fit.system.extended([f.columns for f in mine]), laboratory.y)
        named = fit.baseline.cost - whole.baseline.cost
        k = sum(1 + len(f.effect.refined) for f in mine)
        grid = power.grid(laboratory.signals[0], i)
        scores = [fit.score(laboratory.single(power, i, inner)) for inner in grid]
        best = max(scores, key=lambda s: s.gain)
        more = _MORE if len(mine) > 1 else max(_MORE, _MORE_SHARE * named)
        floor = named + (2 - k) * _price(laboratory) + more
        if best.gain > floor:
            result.append(Leftover(SPEED, i, best.gain, best.energy, floor, 1.0, 0.0, True))
    return result
