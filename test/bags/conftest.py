# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Messages, bags and files the tests of bags/ are made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import CompressionType, Writer

from sosml_friction.bags.message_definitions import message_definition
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import (
    message_class,
    serialize,
    serialize_joint_state,
)

Entry = tuple[str, str, bytes, int]


@pytest.fixture(scope='session')
def joint_state() -> Callable[..., bytes]:
    """Return a maker of JointState bytes: stamp [ns], names, position, velocity, effort."""

    def make(
        t_ns: int,
        names: Sequence[str] = ('shoulder',),
        position: Sequence[float] = (),
        velocity: Sequence[float] = (),
        effort: Sequence[float] = (),
    ) -> bytes:
        return serialize_joint_state(t_ns, names, position, velocity, effort)

    return make


@pytest.fixture(scope='session')
def temperature() -> Callable[[int, str, float], bytes]:
    """Return a maker of Temperature bytes: stamp [ns], joint, degC."""

    def make(t_ns: int, joint: str, value: float) -> bytes:
        message = message_class('sensor_msgs/msg/Temperature')()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(t_ns, 10**9)
        message.header.frame_id = joint
        message.temperature = value
        return serialize(message)

    return make


@pytest.fixture(scope='session')
def string() -> Callable[[str], bytes]:
    """Return a maker of std_msgs/String bytes."""

    def make(text: str) -> bytes:
        message = message_class('std_msgs/msg/String')()
        message.data = text
        return serialize(message)

    return make


@pytest.fixture(scope='session')
def record() -> Callable[[Path, Sequence[Entry]], Path]:
    """Return a recorder of (topic, type, bytes, log time) entries to a bag folder."""

    def make(folder: Path, entries: Sequence[Entry]) -> Path:
        with BagRecorder(folder) as recorder:
            for topic, type_name, cdr, log_time_ns in entries:
                recorder.add_topic(topic, type_name)
                recorder.write(topic, cdr, log_time_ns)
        return folder

    return make


@pytest.fixture(scope='session')
def foreign_mcap() -> Callable[..., Path]:
    """Return a writer of one .mcap file as rosbag2's storage plugin lays it out."""

    def make(
        path: Path,
        entries: Sequence[Entry],
        compression: CompressionType = CompressionType.ZSTD,
        chunk_size: int = 768 * 1024,
        **options: Any,
    ) -> Path:
        with path.open('wb') as stream:
            writer = Writer(stream, chunk_size=chunk_size, compression=compression, **options)
            writer.start(profile='ros2', library='libmcap 1.1.0')
            channels: dict[str, int] = {}
            for topic, type_name, cdr, log_time_ns in entries:
                if topic not in channels:
                    definition = message_definition(type_name).encode()
                    schema = writer.register_schema(type_name, 'ros2msg', definition)
                    channels[topic] = writer.register_channel(
                        topic, 'cdr', schema, {'offered_qos_profiles': '', 'topic_type_hash': ''}
                    )
                writer.add_message(channels[topic], log_time_ns, cdr, log_time_ns)
            writer.finish()
        return path

    return make
