# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a bag holds, for ``sosml info``."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import BagError

FORMAT = 'sosml_friction/info/1'
DESCRIPTIONS = ('robot_description', 'model_description', 'observer_configuration')

#: Stamps further apart than this many periods count as a gap.
GAP_PERIODS = 1.5


def bag_information(bag: Bag) -> dict[str, Any]:
    """
    Return the object of ``sosml info --json``; its schema is ``docs/schema/info.schema.json``.

    ``joint_states``: the joints, the quantities that were measured, those positions and efforts
    that are one number in all samples, and, from the stamps in the
    order of the recording, the median period, gaps (steps of more than 1.5 periods), repeated
    stamps and steps back in time. Without joint_states it is None, and ``joint_states_problem``
    says why.
    """
    problem = ''
    motion: dict[str, Any] | None = None
    try:
        motion = _motion(bag.joint_log())
    except BagError as error:
        problem = str(error)
    return {
        'format': FORMAT,
        'path': str(bag.path),
        'messages': bag.messages_read,
        'start_ns': bag.start_ns,
        'end_ns': bag.end_ns,
        'duration_s': bag.duration_s,
        'recovered': bag.recovered,
        'recovery': bag.recovery,
        'tags': dict(bag.tags),
        'topics': {
            name: {'type': type_name, 'messages': count}
            for name, (type_name, count) in bag.topics.items()
        },
        'descriptions': {name: _holds(bag, name) for name in DESCRIPTIONS},
        'joint_states': motion,
        'joint_states_problem': problem,
    }


def _holds(bag: Bag, name: str) -> bool:
    try:
        return bag.text(name) is not None
    except BagError:
        return False


def _motion(log: JointLog) -> dict[str, Any]:
    steps = np.diff(log.t_ns)
    forward = steps[steps > 0]
    period = float(np.median(forward)) * 1e-9 if len(forward) else np.nan
    return {
        'joints': list(log.names),
        'samples': len(log),
        'rate_hz': 1.0 / period,
        'gaps': int(np.sum(forward > GAP_PERIODS * period * 1e9)) if len(forward) else 0,
        'longest_step_s': float(forward.max()) * 1e-9 if len(forward) else np.nan,
        'repeated_stamps': int(np.sum(steps == 0)),
        'backward_stamps': int(np.sum(steps < 0)),
        'measured': {
            name: [
                quantity
                for quantity, values in (
                    ('position', log.q),
                    ('velocity', log.v),
                    ('effort', log.tau),
                    ('temperature', log.temperature),
                )
                if values is not None and np.isfinite(values[:, i]).any()
            ]
            for i, name in enumerate(log.names)
        },
        'constant': {name: _constant(log, i) for i, name in enumerate(log.names)},
    }


def _constant(log: JointLog, i: int) -> dict[str, float]:
    """Return the position and the effort of joint ``i`` where they are one in all samples."""
    found = {}
    for quantity, values in (('position', log.q), ('effort', log.tau)):
        known = values[np.isfinite(values[:, i]), i]
        if len(known) > 1 and np.ptp(known) == 0.0:
            found[quantity] = float(known[0])
    return found


def constant_sentences(motion: Mapping[str, Any]) -> Iterator[str]:
    """Return what to say of positions and efforts that never change, one sentence each."""
    why = {
        'position': 'the joint does not move, or another column is its position',
        'effort': 'it was not measured, or another column is meant',
    }
    for joint, found in motion['constant'].items():
        for quantity, value in found.items():
            yield f'{joint}: its {quantity} is {value:.4g} in all samples: {why[quantity]}'
