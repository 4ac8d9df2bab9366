# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a bag holds, for ``sosml info``."""

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

    ``joint_states``: the joints, the quantities that were measured, and, from the stamps in the
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
    }
