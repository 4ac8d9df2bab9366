# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags that are not MCAP: rosbag2 in SQLite, and ROS 1, which the library rosbags reads."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.bag_metadata import as_mapping, read_metadata, refuse_compressed_messages
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.joint_state_layout import FIELDS
from sosml_friction.bags.message_definitions import JOINT_STATE, STRING, TEMPERATURE, TRAJECTORY
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import stamp_ns
from sosml_friction.bags.stand_in import refuse_stand_in
from sosml_friction.exceptions import BagError

SUFFIXES = ('.db3', '.bag')
#: What is taken over: no other type is read of any bag.
_TYPES = (JOINT_STATE, STRING, TEMPERATURE, TRAJECTORY)


def is_other_bag(path: Path) -> bool:
    """Tell whether a path is a bag in SQLite or of ROS 1, or a folder that holds one in SQLite."""
    if path.is_dir():
        kinds = {file.suffix for file in path.iterdir()}
        return '.db3' in kinds and '.mcap' not in kinds
    return path.suffix in SUFFIXES and path.is_file()


def other_files(path: Path) -> list[Path]:
    """Return the files of a bag of :func:`is_other_bag`, in the order of their names."""
    return sorted(path.glob('*.db3')) if path.is_dir() else [path]


def copy_bag(source: Path, destination: Path) -> Path:
    """
    Write another bag as the bag ``destination``.

    From rosbag2 it takes the tags, and the messages of all types that are read of bags, byte for
    byte. From ROS 1 it takes joint_states, or else the only topic of that type, and the
    robot_description.

    :raises BagError: if the bag cannot be read or has no such topic, or is of ROS 1 and rosbags is
        not installed.
    :raises DataError: if a file of it was not fetched.
    """
    for file in other_files(source):
        refuse_stand_in(file)
    if source.suffix == '.bag':
        log, description = _read_ros1(source)
        return write_joint_log(log, destination, description)
    information = read_metadata(source if source.is_dir() else source.parent) or {}
    refuse_compressed_messages(source, [information])
    with BagRecorder(destination, as_mapping(information.get('custom_data'))) as recorder:
        for file in other_files(source):
            for topic, type_name, stamp, cdr in _messages(file):
                recorder.add_topic(topic, type_name)
                recorder.write(topic, cdr, stamp)
        if not recorder.message_count:
            has = ', '.join(f'{n} ({kind})' for f in other_files(source) for n, kind in _topics(f))
            raise BagError(
                f'{source} holds no message of type {JOINT_STATE}: it has {has or "no topic"}; '
                'record joint_states'
            )
    return destination


def _messages(file: Path) -> Iterator[tuple[str, str, int, bytes]]:
    """Yield topic, type, time of reception [ns] and CDR bytes of the messages of a file."""
    asked = (
        'SELECT name, type, timestamp, data FROM messages JOIN topics '
        'ON topics.id = messages.topic_id WHERE serialization_format = ? '
        f'AND type IN ({", ".join("?" * len(_TYPES))}) ORDER BY timestamp'
    )
    try:
        with closing(sqlite3.connect(f'{file.resolve().as_uri()}?mode=ro', uri=True)) as base:
            yield from base.execute(asked, ('cdr', *_TYPES))
    except sqlite3.Error as error:
        raise BagError(
            f'{file} is no readable bag: {error}: sqlite3 with .recover may save what is whole'
        ) from error


def _topics(file: Path) -> list[tuple[str, str]]:
    """Return name and type of the topics of a file."""
    with closing(sqlite3.connect(f'{file.resolve().as_uri()}?mode=ro', uri=True)) as base:
        return list(base.execute('SELECT name, type FROM topics'))


def _read_ros1(source: Path) -> tuple[JointLog, str | None]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise BagError(
            f'{source} is a bag of ROS 1, and rosbags, which reads it, is not installed: pip '
            'install rosbags'
        ) from None
    try:
        with AnyReader([source], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
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
    arrays = {quantity: np.full((len(messages), len(names)), np.nan) for quantity in FIELDS}
    t_ns: IndexArray = np.empty(len(messages), dtype=np.int64)
    for k, message in enumerate(messages):
        t_ns[k] = stamp_ns(message.header.stamp)
        columns = [names.index(name) for name in message.name]
        for quantity, array in arrays.items():
            values: FloatArray = np.asarray(getattr(message, quantity), dtype=np.float64)
            if len(values) == len(columns):
                array[k, columns] = values
    q, v, tau = arrays.values()
    return JointLog(names, t_ns, q, v, tau), str(texts[-1].data) if texts else None
