# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which trials a campaign is made of."""

from __future__ import annotations

from itertools import cycle

import numpy as np

from validation.trial import FAULTS, OUTSIDE, SINGLES, TRANSMISSION, Spec, reaches

KINDS = ('single', 'null', 'outside', 'twin', 'double', 'thermal', 'fault', 'excitation')
#: Kind and options of the recordings without an effect.
NULLS = (
    {}, {'noise': 'double'}, {'noise': 'other'}, {'nuisance': (0.03, 0.03)}, {'shuffled': True},
)  # fmt: skip
NULL_MOTIONS = ('rich', 'reversals', 'slow', 'multisine')
#: The slow ladder is repeated to the length of the others [s].
SLOW_S = 130.0
#: A gear warms up over minutes [s].
THERMAL_S = 620.0
TWINS = (
    {'effect': 'effort_bias', 'motion': 'multisine', 'moving': True},
    {'effect': 'asymmetric_level', 'motion': 'multisine', 'moving': True},
    {'effect': 'backlash'},
    {'effect': 'joint_elasticity'},
    {'effect': 'spring'},
    {'effect': 'common_scale'},
)


def make_plan(seed: int, trials: int) -> list[Spec]:
    """
    Return the trials of a campaign, ``trials`` of them single effects of SNR 0.6 and more.

    In units of ``trials`` there are besides: 0.5 of SNR 0.35 to 0.6, 0.25 of less, 0.8 nulls, 0.4
    outside of the library, 0.4 twins, 0.5 doubles, 1/6 thermal, 0.2 faults of data, and 0.7 in
    other motions. Chosen, no measurement.
    """
    rng = np.random.default_rng([seed, 99])
    seeds = iter(int(x) for x in rng.integers(2**31, size=40 * trials + 400))
    plan: list[Spec] = []

    def add(kind: str, label: str, **options) -> None:
        number = sum(spec.kind == kind for spec in plan)
        options.setdefault('seed', next(seeds))
        plan.append(Spec(f'{kind}-{label}{number:03d}', kind, **options))

    first = rng.integers(2, size=len(SINGLES))
    joints = {effect: cycle((k, 1 - k)) for effect, k in zip(SINGLES, first, strict=True)}
    for level, count in (
        ('high', trials), ('middle', -(-trials // 2)), ('low', -(-trials // 4)),
    ):  # fmt: skip
        if count >= len(SINGLES) and level == 'high':
            # Each effect as often as any other.
            count = -(-count // len(SINGLES)) * len(SINGLES)
        done, names = 0, _rounds(SINGLES, rng)
        while done < count:
            effect = next(names)
            joint = next(joints[effect])
            if level != 'high' and effect == 'external_contact':
                # A few pushes are short: over the whole recording they are small, yet obvious.
                continue
            if reaches(effect, joint, level):
                hold = level == 'high' and effect != 'external_contact'
                add(
                    'single',
                    f'{level}-',
                    effect=effect,
                    joint=int(joint),
                    level=level,
                    holdout=hold,
                )
                done += 1
    for k in range(-(-4 * trials // 5)):
        options = dict(NULLS[k % len(NULLS)])
        motion = NULL_MOTIONS[k % len(NULL_MOTIONS)]
        if options.get('shuffled'):
            # Blocks of the residual of a hidden effect, in other places.
            options['effect'] = str(rng.choice(['coulomb', 'viscous', 'stribeck', 'inertia']))
        add('null', '', motion=motion, duration=_length(motion), **options)
    kinds = _rounds(tuple(OUTSIDE), rng)
    for k in range(-(-2 * trials // 5)):
        add('outside', '', effect=next(kinds), joint=k % 2, level='high')
    for k in range(-(-2 * trials // 5)):
        add('twin', '', joint=k // len(TWINS) % 2, level='high', **TWINS[k % len(TWINS)])
    for _ in range(-(-trials // 2)):
        first, second = rng.choice(SINGLES, 2, replace=False)
        while first in TRANSMISSION and second in TRANSMISSION:
            first, second = rng.choice(SINGLES, 2, replace=False)
        add('double', '', effect=str(first), second=str(second))
    for k in range(-(-trials // 6)):
        add('thermal', '', effect='thermal_drift', joint=k % 2, duration=THERMAL_S)
    for k in range(-(-trials // 5)):
        add('fault', '', effect=tuple(FAULTS)[k % 2])
    names = _rounds(SINGLES, rng)
    for k in range(-(-7 * trials // 10)):
        motion = ('multisine', 'slow')[k % 2]
        if k % 2 == 0:
            # The same robot in both motions.
            effect, same = next(names), next(seeds)
            joint = int(next(joints[effect]))
        add(
            'excitation', f'{motion}-', effect=effect, joint=joint, level='high', motion=motion,
            duration=_length(motion), seed=same,
        )  # fmt: skip
    return plan


def _length(motion: str) -> float | None:
    return SLOW_S if motion == 'slow' else None


def _rounds(names: tuple[str, ...], rng: np.random.Generator):
    """Yield names for ever, each as often as any other, in orders drawn anew."""
    while True:
        yield from (str(name) for name in rng.permutation(names))
