# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags that are not MCAP: rosbag2 in SQLite, and ROS 1, by the library rosbags."""

from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.bag import JOINT_STATE, STRING
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.exceptions import BagError

_SUFFIXES = ('.db3', '.bag')
_QUANTITIES = ('position', 'velocity', 'effort')


def is_other_bag(path: Path) -> bool:
    """Tell whether a path is a bag in SQLite or of ROS 1, or a folder that holds one."""
    if path.is_dir():
        return any(file.suffix == '.db3' for file in path.iterdir())
    return path.suffix in _SUFFIXES


def copy_bag(source: Path, destination: Path) -> Path:
    """
    Write the joint_states and robot_description of another bag as the bag ``destination``.

    If no topic is joint_states, the only one of that type is taken.

    :raises BagError: if rosbags is not installed, the bag cannot be read or has no such topic.
    """
    log, description = _read(source)
    return write_joint_log(log, destination, description)


def _read(source: Path) -> tuple[JointLog, str | None]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise BagError(
            f'{source} is no MCAP bag, and rosbags, which reads it, is not installed: pip install '
            'rosbags, or use `ros2 bag convert` to make it MCAP'
        ) from None
    # A file of rosbag2 belongs to the folder with its metadata.
    path = source.parent if source.suffix == '.db3' else source
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            states = [c for c in reader.connections if c.msgtype == JOINT_STATE]
            topics = sorted({c.topic for c in states})
            named = [topic for topic in topics if topic.endswith('joint_states')] or topics
            if len(named) != 1:
                raise BagError(
                    f'{source} has {len(named)} topics of type {JOINT_STATE} '
                    f"({', '.join(named) or 'none'}): record one robot's joint_states"
                )
            chosen = [c for c in states if c.topic == named[0]]
            messages: list[Any] = [
                reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(chosen)
            ]
            described = [
                c
                for c in reader.connections
                if c.msgtype == STRING and c.topic.endswith('robot_description')
            ]
            texts: list[Any] = [
                reader.deserialize(raw, c.msgtype)
                for c, _, raw in (reader.messages(described) if described else ())
            ]
    except BagError:
        raise
    # A damaged bag fails anywhere inside the library.
    except Exception as error:
        raise BagError(f'{source} is no readable bag: {" ".join(str(error).split())}') from error
    if not messages:
        raise BagError(f'{source} has no messages on {named[0]}: record it again')
    names = tuple(dict.fromkeys(name for message in messages for name in message.name))
    arrays = {quantity: np.full((len(messages), len(names)), np.nan) for quantity in _QUANTITIES}
    t_ns: IndexArray = np.empty(len(messages), dtype=np.int64)
    for k, message in enumerate(messages):
        t_ns[k] = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        columns = [names.index(name) for name in message.name]
        for quantity, array in arrays.items():
            values: FloatArray = np.asarray(getattr(message, quantity), dtype=np.float64)
            if len(values) == len(columns):
                array[k, columns] = values
    log = JointLog(names, t_ns, arrays['position'], arrays['velocity'], arrays['effort'])
    return log, str(texts[-1].data) if texts else None
