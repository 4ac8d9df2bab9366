# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml can`` found, as tables and documents."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from sosml_friction.actuators.bus.inquiry import FoundActuator
from sosml_friction.actuators.driver.start_up import Check
from sosml_friction.report.common.table import terminal_table

SCAN_FORMAT = 'sosml_friction/can_scan/1'
CHECK_FORMAT = 'sosml_friction/can_check/1'


def scan_table(found: Sequence[FoundActuator]) -> Table:
    """Return who answered, one row each."""
    rows = [
        (
            f'{own.can_id:#05x}'
            if own.motor_id is None
            else f'{own.motor_id} ({own.can_id:#05x})',
            own.kind,
            own.model or 'not told',
            'not told' if own.version is None else str(own.version),
            '-' if own.voltage is None else f'{own.voltage:.1f}',
            '-' if own.temperature is None else f'{own.temperature:.0f}',
            own.errors or 'not told',
            '; '.join(own.remarks),
        )
        for own in found
    ]
    heads = ('id', 'kind', 'model', 'version', 'V', 'degC', 'errors', 'remarks')
    return terminal_table(dict.fromkeys(heads, ''), rows)


def scan_document(
    found: Sequence[FoundActuator], interface: str, channel: str, bitrate: int
) -> dict[str, Any]:
    """Return the JSON document of ``sosml can scan``."""
    return {
        'format': SCAN_FORMAT,
        'bus': {'interface': interface, 'channel': channel, 'bitrate': bitrate},
        'actuators': [asdict(own) for own in found],
    }


def _entry(check: Check) -> dict[str, str]:
    return {
        'joint': check.joint,
        'step': check.step,
        'found': check.result,
        'verdict': 'problem' if check.problem else 'warning' if check.warning else 'ok',
        'why': check.problem or check.warning,
    }


def check_table(checks: Sequence[Check]) -> Table:
    """Return what each step found, with its verdict."""
    rows = [tuple(_entry(own).values()) for own in checks]
    return terminal_table(dict.fromkeys(('joint', 'step', 'found', 'verdict', 'why'), ''), rows)


def check_document(
    checks: Sequence[Check], interface: str, channel: str, bitrate: int
) -> dict[str, Any]:
    """Return the JSON document of ``sosml can check``."""
    entries = [_entry(own) for own in checks]
    verdicts = [entry['verdict'] for entry in entries]
    problems, warnings = verdicts.count('problem'), verdicts.count('warning')
    if problems:
        text = f'{problems} of {len(checks)} checks speak against enabling the joints'
    elif warnings:
        text = f'the joints may be enabled; read the {warnings} of {len(checks)} checks that warn'
    else:
        text = f'the joints may be enabled: all {len(checks)} checks are good'
    return {
        'format': CHECK_FORMAT,
        'bus': {'interface': interface, 'channel': channel, 'bitrate': bitrate},
        'ready': not problems,
        'verdict': text,
        'checks': entries,
    }
