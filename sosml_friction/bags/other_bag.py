# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags that are not MCAP: rosbag2 in SQLite, and ROS 1, which the library rosbags reads."""

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from itertools import chain
from pathlib import Path

from sosml_friction.bags.bag_metadata import as_mapping, read_metadata, refuse_compressed_messages
from sosml_friction.bags.message_definitions import JOINT_STATE, STRING, TEMPERATURE, TRAJECTORY
from sosml_friction.bags.recorder import BagRecorder
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

    It takes the tags, and the messages of all types that are read of bags: of rosbag2 byte for
    byte, of ROS 1 as their counterparts.

    :raises BagError: if the bag cannot be read or has no such message, or is of ROS 1 and rosbags
        is not installed.
    :raises DataError: if a file of it was not fetched.
    """
    files = other_files(source)
    for file in files:
        refuse_stand_in(file)
    is_ros1 = source.suffix == '.bag'
    folder = source if source.is_dir() else source.parent
    information = {} if is_ros1 else read_metadata(folder) or {}
    refuse_compressed_messages(source, [information])
    read = _ros1_messages if is_ros1 else _messages
    recorder = BagRecorder(destination, as_mapping(information.get('custom_data')))
    try:
        with recorder:
            for topic, type_name, stamp, cdr in chain.from_iterable(map(read, files)):
                recorder.add_topic(topic, type_name)
                recorder.write(topic, cdr, stamp)
            if not recorder.message_count:
                has = '' if is_ros1 else ', '.join(map(_topics, files))
                raise BagError(
                    f'{source} holds no message of type {JOINT_STATE}: it has '
                    f'{has or "no such topic"}; record joint_states'
                )
    except BaseException:
        # A part of it would look whole.
        shutil.rmtree(destination)
        raise
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


def _topics(file: Path) -> str:
    """Return name and type of the topics of a file, for a sentence."""
    with closing(sqlite3.connect(f'{file.resolve().as_uri()}?mode=ro', uri=True)) as base:
        found = base.execute('SELECT name, type FROM topics')
        return ', '.join(f'{name} ({kind})' for name, kind in found)


def _ros1_messages(file: Path) -> Iterator[tuple[str, str, int, bytes]]:
    """Yield what :func:`_messages` does of a bag of ROS 1."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise BagError(
            f'{file} is a bag of ROS 1, and rosbags, which reads it, is not installed: pip '
            'install rosbags'
        ) from None
    types = get_typestore(Stores.ROS2_JAZZY)
    try:
        with AnyReader([file]) as reader:
            wanted = [c for c in reader.connections if c.msgtype in _TYPES]
            for c, stamp, raw in reader.messages(wanted) if wanted else ():
                yield c.topic, c.msgtype, stamp, bytes(types.ros1_to_cdr(raw, c.msgtype))
    # A damaged bag fails anywhere inside the library.
    except Exception as error:
        raise BagError(f'{file} is no readable bag: {" ".join(str(error).split())}') from error
