# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""CDR bytes to messages and back: the one place of ``bags/`` that imports rclpy."""

import importlib
import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

from sosml_friction.bags.message_definitions import split_type_name
from sosml_friction.exceptions import BagError, ConfigurationError


@cache
def message_class(type_name: str) -> type[Any]:
    """
    Return the Python class of an installed type such as ``sensor_msgs/msg/JointState``.

    :raises BagError: if its package or the type is not installed.
    """
    package, name = split_type_name(type_name)
    try:
        kind: type[Any] = getattr(importlib.import_module(f'{package}.msg'), name)
        return kind
    except (ImportError, AttributeError) as error:
        raise BagError(
            f'the message type {type_name} is not installed: source the workspace that has it or '
            f'install the package {package}'
        ) from error


def stamp_ns(stamp: Any) -> int:
    """Return a stamp of a message [ns]."""
    return int(stamp.sec * 1_000_000_000 + stamp.nanosec)


@cache
def _rclpy_serialization() -> Any:
    try:
        return importlib.import_module('rclpy.serialization')
    except ImportError as error:
        raise ConfigurationError(
            'rclpy, which decodes the messages of a bag, is not installed: source ROS 2 Jazzy or '
            "pip install 'ros-jazzy-rclpy[fastrtps]' ros-jazzy-common-interfaces"
        ) from error


def serialize(message: Any) -> bytes:
    """
    Return the CDR bytes (with their 4-byte encapsulation header) of a message.

    Alignment gaps hold arbitrary bytes, and after an empty array of doubles up to 8 arbitrary
    bytes follow the message: rclpy reserves more than it fills. ROS readers pass over them; bytes
    received from a topic do not have them, nor do those of :func:`serialize_joint_state`.

    :raises ConfigurationError: if rclpy is not installed.
    """
    return bytes(_rclpy_serialization().serialize_message(message))


def serialize_joint_state(
    t_ns: int,
    names: Sequence[str],
    position: Sequence[float] = (),
    velocity: Sequence[float] = (),
    effort: Sequence[float] = (),
    frame_id: str = '',
) -> bytes:
    """
    Return the CDR bytes of a sensor_msgs/JointState, the same for the same values.

    ``t_ns`` is the stamp [ns], 0 <= t_ns < 2^31 s. Little-endian, gaps filled with zeros, and
    exactly as long as the message (see :func:`serialize`).
    """
    body = bytearray(struct.pack('<iI', *divmod(t_ns, 1_000_000_000)))
    _add_text(body, frame_id)
    body += struct.pack('<I', len(names))
    for name in names:
        _add_text(body, name)
    for values in (position, velocity, effort):
        body += struct.pack('<I', len(values))
        if values:
            body += bytes(-len(body) % 8) + struct.pack(f'<{len(values)}d', *values)
    return b'\x00\x01\x00\x00' + bytes(body)


def _add_text(body: bytearray, text: str) -> None:
    """Add a text with its length, its NUL and the gap to the next length."""
    encoded = text.encode() + b'\0'
    body += struct.pack('<I', len(encoded)) + encoded + bytes(-len(encoded) % 4)


def plain_string(cdr: bytes) -> str | None:
    """Return the text of the CDR bytes of a std_msgs/String, None where it takes rclpy to tell."""
    end = _text_end(cdr, 4)
    return None if end is None else cdr[8 : end - 1].decode(errors='replace')


def plain_temperature(cdr: bytes) -> tuple[int, str, float] | None:
    """Return stamp [ns], frame_id and temperature [degC], None where it takes rclpy to tell."""
    end = _text_end(cdr, 12)
    # Doubles count from behind the encapsulation; two of them, of which the second is a variance.
    if end is None or len(cdr) < (start := end + (4 - end) % 8) + 16:
        return None
    sec, nanosec = struct.unpack_from('<iI', cdr, 4)
    (temperature,) = struct.unpack_from('<d', cdr, start)
    return sec * 1_000_000_000 + nanosec, cdr[16 : end - 1].decode(errors='replace'), temperature


def _text_end(cdr: bytes, at: int) -> int | None:
    """Return where a text ends that has one NUL, its last byte; None if it is not so."""
    if cdr[:2] != b'\x00\x01' or len(cdr) < at + 4:
        return None
    end = at + 4 + int(struct.unpack_from('<I', cdr, at)[0])
    return end if cdr.find(b'\0', at + 4, end) == end - 1 else None


def deserialize(cdr: bytes, type_name: str) -> Any:
    """
    Return the message of type ``type_name`` that the CDR bytes hold.

    :raises BagError: if the bytes are no such message or the type is not installed.
    :raises ConfigurationError: if rclpy is not installed.
    """
    kind = message_class(type_name)
    decode = _rclpy_serialization().deserialize_message
    try:
        return decode(cdr, kind)
    # rclpy raises its own C++ exception types, which differ between its versions.
    except Exception as error:
        raise BagError(f'{len(cdr)} bytes recorded as {type_name} cannot be decoded') from error
