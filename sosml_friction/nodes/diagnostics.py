# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Build ``/diagnostics`` messages (REP-107): for a person to read, not for a machine to act on."""

from collections.abc import Mapping, Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE


def full_name(node: Node) -> str:
    """Return the name of a node with its namespace: there may be one of it in each."""
    return node.get_fully_qualified_name().lstrip('/')


def make_status(
    name: str, level: bytes, message: str, values: Mapping[str, Any], hardware_id: str = ''
) -> DiagnosticStatus:
    """Return the status of ``node: component``; a float is written with six digits."""
    return DiagnosticStatus(
        level=level,
        name=name,
        message=message,
        hardware_id=hardware_id,
        values=[KeyValue(key=key, value=_text(value)) for key, value in values.items()],
    )


def make_array(stamp: Time, statuses: Sequence[DiagnosticStatus]) -> DiagnosticArray:
    """Return the array that is published, stamped with ``stamp``."""
    message = DiagnosticArray(status=list(statuses))
    message.header.stamp = stamp
    return message


def _text(value: Any) -> str:
    return f'{value:.6g}' if isinstance(value, float) else str(value)
