# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of causes that the joint sensors hardly tell apart, and what else does."""

from __future__ import annotations

from typing import NamedTuple


class PairCondition(NamedTuple):
    """
    Hold what tells two causes apart.

    ``condition``: its name in :mod:`.conditions`, '' where it is none of
    them; ``instruction``: what to do, and what is seen then.
    """

    condition: str
    instruction: str


_MASS = 'hang a known mass on the arm and record again: a wrong torque constant scales it'
_BARE = 'record without the person or the cable (not worn) and compare'
_WARM = 'repeat the same speeds cold and warm'
_LOAD = 'repeat the recording with a known payload: friction that follows the load grows'

_TABLE = (
    ('effort_bias', 'asymmetric_friction', 'free_hanging_hold',
     'hold the joint where gravity asks nothing of it, free of load and at rest, motors off: a '
     'bias of effort stays, friction that differs between the directions does not'),
    ('backlash', 'joint_elasticity', '',
     'lock the motor and move the link by hand, or measure the link: with position at the motor '
     'alone a gap and a spring look alike'),
    ('effort_scale', 'gravity', 'known_payload', f'{_MASS}, a wrong first moment does not'),
    ('effort_scale', 'payload', 'known_payload', f'{_MASS} too'),
    ('effort_scale', 'inertia', 'known_payload', f'{_MASS}, a wrong inertia does not'),
    ('gravity', 'spring', 'not_worn', f'{_BARE}: gravity stays, a spring goes'),
    ('effort_bias', 'spring', 'not_worn', f'{_BARE}: a bias of effort stays, a spring goes'),
    ('viscous', 'thermal_drift', 'warm_up_repeat',
     f'{_WARM}: a wrong viscous friction is the same in both'),
    ('coulomb', 'thermal_drift', 'warm_up_repeat',
     f'{_WARM}: a wrong Coulomb friction is the same in both'),
    ('load_dependent_friction', 'position_dependent_friction', 'known_payload',
     f'{_LOAD}, friction that follows posture does not'),
    ('load_dependent_friction', 'coulomb', 'known_payload', _LOAD),
)  # fmt: skip
PAIR_CONDITIONS = {
    frozenset({one, other}): PairCondition(condition, instruction)
    for one, other, condition, instruction in _TABLE
}
