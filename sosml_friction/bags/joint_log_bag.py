# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Write a JointLog as a bag, the inverse of :meth:`Bag.joint_log`."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize, serialize_joint_state
from sosml_friction.exceptions import BagError


def write_joint_log(
    log: JointLog,
    folder: str | Path,
    robot_description: str | None = None,
    model_description: str | None = None,
    reference: FloatArray | None = None,
    injected: FloatArray | None = None,
) -> Path:
    """
    Record ``log`` in the bag ``folder``, with the robot's URDF and model text where given.

    A quantity that no joint has in any sample is left out of the messages (empty array). A
    temperature is written when it changes. Log time is the stamp, 0 to 2^31 s.
    ``Bag.open(folder).joint_log()`` gives the same log back, bit by bit.

    :param reference: wanted positions (N, n) [rad or m], recorded as ``controller_reference``.
    :param injected: efforts (N, n) [Nm or N] that were added to the command of the controllers,
        recorded as ``injected_effort``.
    :raises BagError: if the folder exists or cannot be written, or a stamp does not fit the
        message (0 to 2^31 s).
    """
    low, high = int(log.t_ns.min()), int(log.t_ns.max())
    if low < 0 or high >= 2**31 * 1_000_000_000:
        raise BagError(
            f'the stamps run from {low} to {high} ns, and a ROS stamp from 0 to 2^31 s: set the '
            'start time of the recording'
        )
    stamps = log.t_ns.tolist()
    # Position, velocity and effort of each topic.
    signals = {
        '/joint_states': [
            None if np.isnan(a).all() else a.tolist() for a in (log.q, log.v, log.tau)
        ]
    }
    if reference is not None:
        signals['/controller_reference'] = [reference.tolist(), None, None]
    if injected is not None:
        signals['/injected_effort'] = [None, None, injected.tolist()]
    temperatures = dict(_temperature_changes(log.temperature))
    temperature = message_class('sensor_msgs/msg/Temperature')()
    text = message_class('std_msgs/msg/String')()
    with BagRecorder(folder, log.tags) as recorder:
        descriptions = (
            ('/robot_description', robot_description),
            ('/model_description', model_description),
        )
        for topic, content in descriptions:
            if content is not None:
                text.data = content
                recorder.add_topic(topic, 'std_msgs/msg/String')
                recorder.write(topic, serialize(text), stamps[0])
        for topic in signals:
            recorder.add_topic(topic, 'sensor_msgs/msg/JointState')
        if temperatures:
            recorder.add_topic('/joint_temperatures', 'sensor_msgs/msg/Temperature')
        for k, t_ns in enumerate(stamps):
            for joint, value in temperatures.get(k, ()):
                temperature.header.stamp.sec, temperature.header.stamp.nanosec = divmod(
                    t_ns, 1_000_000_000
                )
                temperature.header.frame_id = log.names[joint]
                temperature.temperature = value
                recorder.write('/joint_temperatures', serialize(temperature), t_ns)
            for topic, quantities in signals.items():
                values = ([] if quantity is None else quantity[k] for quantity in quantities)
                recorder.write(topic, serialize_joint_state(t_ns, log.names, *values), t_ns)
    return Path(folder)


def _temperature_changes(
    temperature: FloatArray | None,
) -> Iterator[tuple[int, list[tuple[int, float]]]]:
    """Yield (sample, [(joint index, degC), ...]) wherever a temperature changes."""
    if temperature is None:
        return
    # As bits, so that NaN equals NaN; before the first message a temperature is NaN anyway.
    bits = np.ascontiguousarray(temperature).view(np.int64)
    changed = np.ones(temperature.shape, dtype=bool)
    changed[1:] = bits[1:] != bits[:-1]
    for k in np.flatnonzero(changed.any(axis=1)).tolist():
        yield k, [(j, float(temperature[k, j])) for j in np.flatnonzero(changed[k]).tolist()]
