# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Is what was fitted friction at all: checks of a fitted law."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_problem import LawProblem, LawSolution
from sosml_friction.identification.number_text import rounded
from sosml_friction.model.laws import unit_of
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.model.terms.nonlinear_viscous import power_of_speed
from sosml_friction.regression.chance import CHANCE

DISSIPATION = 'dissipation'
ODD_EVEN = 'odd_even'
KNEE = 'knee'
BEND = 'bend'
#: Smaller than this share of friction it does not matter.
MATTERS = 0.02


@dataclass(frozen=True)
class LawCheck:
    """
    Hold what one check says of a fitted law.

    ``passed`` is False where the law is not friction as it stands; ``sentence`` says so with its
    numbers, in one sentence with its full stop.
    """

    name: str
    passed: bool
    sentence: str


def dissipation_check(
    best: Mapping[str, tuple[float, tuple[float, float] | None]],
    effort_unit: str,
    slowest: float,
    fastest: float,
    exponent: float = 1.0,
) -> LawCheck:
    """
    Ask whether friction with its bias takes energy at every speed of the data.

    tau_f v >= 0 needs C + S exp(-(w / v_s)^d) + B w + P w^p >= |bias| at every w from ``slowest``
    to ``fastest``. Where it is less the law drives the joint in one direction: no friction does.

    :param best: best fit and 95 % interval by parameter.
    :param exponent: d.
    """
    value = {name: each[0] for name, each in best.items()}
    w = np.geomspace(max(slowest, 1e-6 * fastest), fastest, 200)
    level = value['coulomb'] + value['viscous'] * w
    if 'stribeck_velocity' in value:
        level = level + value['stribeck'] * fade(w, value['stribeck_velocity'], exponent)
    if 'power' in value:
        level = level + value['nonlinear_viscous'] * power_of_speed(w, value['power'])
    bias, coulomb, speed_unit = value['bias'], value['coulomb'], unit_of('velocity', effort_unit)
    beyond = abs(bias) > level
    if not beyond.any():
        share = 100.0 * abs(bias) / float(level.min()) if level.min() > 0.0 else 0.0
        return LawCheck(
            DISSIPATION,
            True,
            f'The law takes energy at every speed: the bias of {bias:.3g} {effort_unit} is '
            f'{rounded(share)} % of the least friction, {level.min():.3g} {effort_unit}.',
        )
    way = 'backwards' if bias > 0.0 else 'forwards'
    first, last = w[beyond][[0, -1]]
    start = f'The bias {abs(bias):.3g} {effort_unit} is larger than '
    what = (
        f'Coulomb friction {coulomb:.3g} {effort_unit}'
        if abs(bias) > coulomb
        else f'friction from {first:.3g} to {last:.3g} {speed_unit}'
    )
    return LawCheck(
        DISSIPATION,
        False,
        f'{start}{what}, so that the law drives the joint {way} from {first:.3g} to {last:.3g} '
        f'{speed_unit}: this is an offset of gravity or of the current, not friction.',
    )


def knee_check(law: Mapping[str, float], effort_unit: str) -> LawCheck:
    """Say that the broad knee, with whose parameters ``law`` is, explains more than the fitted."""
    letters = {'coulomb': 'C', 'viscous': 'B', 'stribeck': 'S', 'stribeck_velocity': 'v_s'}
    values = ', '.join(
        f'{letter} {law[name]:.3g} {unit_of(name, effort_unit)}'
        for name, letter in letters.items()
    )
    return LawCheck(
        KNEE,
        True,
        'Friction falls from standstill more like 1 / (1 + (v / v_s)^2) than like the fitted '
        f'law, whose errors allow for it: with that knee it has {values}.',
    )


def bend_check(
    speeds: FloatArray,
    law: FloatArray,
    bent: FloatArray,
    power: float,
    terms: str,
    effort_unit: str,
) -> LawCheck | None:
    """
    Say where friction bends otherwise than the law, None if that is too little to matter.

    :param speeds: of the data, standstill before them (N,) [rad/s or m/s]; ``law`` friction by the
        law there (N,) [Nm or N], ``bent`` with a power of speed beside it; ``terms`` of the law.
    """
    apart = bent - law
    k = int(np.argmax(np.abs(apart)))
    if abs(apart[k]) < MATTERS * float(np.abs(law).max()):
        return None
    where = f'{speeds[k]:.3g} {unit_of("velocity", effort_unit)}' if k else 'standstill'
    return LawCheck(
        BEND,
        False,
        f'Friction bends with speed otherwise than the law: with |v|^{power:g} beside it, it is '
        f'{abs(apart[k]):.3g} {effort_unit} {"more" if apart[k] > 0.0 else "less"} at '
        f'{where} (by chance alone: p < {CHANCE:g}). The errors allow for that; '
        f'--terms {terms},nonlinear_viscous fits it.',
    )


def unfaded_check(law: Mapping[str, float], terms: str, effort_unit: str) -> LawCheck:
    """Say that a law of ``terms`` without a Stribeck term explains more; ``law``: its values."""
    return LawCheck(
        BEND,
        False,
        f'Friction bends with speed more as |v|^{law["power"]:g} does than by extra friction near '
        f'standstill: with that in its place C is {law["coulomb"]:.3g} {effort_unit} and B '
        f'{law["viscous"]:.3g} {unit_of("viscous", effort_unit)}. The errors allow for that; '
        f'--terms {terms} fits it.',
    )


def in_place_check(law: Mapping[str, float], terms: str, effort_unit: str) -> LawCheck:
    """Say that the law of ``terms`` has a power of speed and no Stribeck term; its values."""
    size, speed = law['nonlinear_viscous'], unit_of('velocity', effort_unit)
    return LawCheck(
        BEND,
        False,
        f'Friction bends with speed as |v|^{law["power"]:.3g} does, not by extra friction near '
        f'standstill: the law has that, {size:.3g} {effort_unit} at 1 {speed}, and C is friction '
        f'at standstill. --terms {terms} fits it beside other terms.',
    )


def odd_even_check(
    speeds: FloatArray,
    odd: FloatArray,
    even: FloatArray,
    chance: float,
    effort_unit: str,
    asymmetric: bool = False,
) -> LawCheck:
    """
    Ask whether the part that does not change its sign with direction changes with speed.

    Half of tau_f(w) - tau_f(-w) is friction, half of their sum is an offset if it is the same at
    every speed w, else an asymmetry.

    :param speeds: slowest and fastest speed (2,) [rad/s or m/s].
    :param odd: odd part at these (2,) [Nm or N]; ``even`` (2,) the even part.
    :param chance: probability that noise alone changes the even part by as much.
    :param asymmetric: whether the law has an asymmetry: such a part is then in it, and no fault.
    """
    unit = unit_of('velocity', effort_unit)
    parts = (
        f'the odd part, friction, is {odd[0]:.3g} {effort_unit} at {speeds[0]:.3g} {unit} and '
        f'{odd[1]:.3g} at {speeds[1]:.3g}'
    )
    change = float(abs(even[1] - even[0]))
    if chance > CHANCE or change < MATTERS * float(np.abs(odd).max()):
        return LawCheck(
            ODD_EVEN,
            True,
            f'Friction is the same in both directions beside a constant offset of '
            f'{float(np.mean(even)):.3g} {effort_unit}: {parts}.',
        )
    advice = (
        'the asymmetric form that was fitted has both'
        if asymmetric
        else 'fit the asymmetric form, or look for an error of gravity'
    )
    return LawCheck(
        ODD_EVEN,
        asymmetric,
        f'Friction differs by direction: the even part is {even[0]:.3g} {effort_unit} at '
        f'{speeds[0]:.3g} {unit} and {even[1]:.3g} at {speeds[1]:.3g} (by chance alone: '
        f'p = {chance:.1g}), {parts}; {advice}.',
    )


def even_part(
    problem: LawProblem,
    solution: LawSolution,
    nonlinear: tuple[str, ...],
    speeds: FloatArray,
    effort_unit: str,
) -> LawCheck:
    """
    Tell whether the even part of friction changes with speed.

    :param nonlinear: which parameters were found beside v_s.
    :param speeds: slowest and fastest of the data (2,) [rad/s or m/s].
    """
    form = problem.form
    p = dict(zip(problem.names(solution.v_s), solution.theta.tolist(), strict=True))
    if form.symmetric:
        even = [problem.speed]
        if solution.v_s is not None:
            even.append(fade(problem.speed, solution.v_s, solution.alpha))
        more = np.column_stack([problem.made(column) for column in even])
        step, spread, _, _ = problem.beside(solution, nonlinear, more)
        found, C = step[-len(even) :], spread[-len(even) :, -len(even) :]
        names, _ = problem.jacobian(solution, nonlinear)
        bias = p['bias'] + float(step[names.index('bias')])
    else:
        of = ['viscous_asymmetry', *(['stribeck_asymmetry'] if solution.v_s else [])]
        full = problem.covariance(solution, nonlinear)
        found = np.array([p[name] for name in of])
        C = np.array([[full[a, b] for b in of] for a in of])
        bias = p['bias']
    shapes = [speeds]
    if solution.v_s is not None:
        shapes.append(fade(speeds, solution.v_s, solution.alpha))
    even_at = np.array(shapes).T @ found
    inverse = np.linalg.pinv(C, rcond=1e-10)
    statistic = float(found @ inverse @ found) / len(found)
    freedom = max(problem.count - len(solution.theta) - 2, 1)
    chance = float(f_distribution.sf(statistic, len(found), freedom))
    peak: FloatArray | float = 0.0
    if solution.v_s is not None:
        peak = p['stribeck'] * fade(speeds, solution.v_s, solution.alpha)
    odd_at = p['coulomb'] + peak + p['viscous'] * speeds
    return odd_even_check(speeds, odd_at, bias + even_at, chance, effort_unit, not form.symmetric)
