# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml can`` found, as tables and documents."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich import box
from rich.table import Table

from sosml_friction.actuators.bus.inquiry import FoundActuator
from sosml_friction.actuators.driver.start_up import Check

SCAN_FORMAT = 'sosml_friction/can_scan/1'
CHECK_FORMAT = 'sosml_friction/can_check/1'


def _table(*columns: str) -> Table:
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    for column in columns:
        table.add_column(column)
    return table


def scan_table(found: Sequence[FoundActuator]) -> Table:
    """Return who answered, one row each."""
    table = _table('id', 'kind', 'model', 'version', 'V', 'degC', 'errors', 'remarks')
    for own in found:
        number = f'{own.can_id:#05x}'
        table.add_row(
            number if own.motor_id is None else f'{own.motor_id} ({number})',
            own.kind,
            own.model or 'not told',
            'not told' if own.version is None else str(own.version),
            '-' if own.voltage is None else f'{own.voltage:.1f}',
            '-' if own.temperature is None else f'{own.temperature:.0f}',
            own.errors or 'not told',
            '; '.join(own.remarks),
        )
    return table


def scan_document(
    found: Sequence[FoundActuator], interface: str, channel: str, bitrate: int
) -> dict[str, Any]:
    """Return the JSON document of ``sosml can scan``."""
    return {
        'format': SCAN_FORMAT,
        'bus': {'interface': interface, 'channel': channel, 'bitrate': bitrate},
        'actuators': [asdict(own) for own in found],
    }


def _verdict(check: Check) -> str:
    return 'problem' if check.problem else 'warning' if check.warning else 'ok'


def check_table(checks: Sequence[Check]) -> Table:
    """Return what each step found, with its verdict."""
    table = _table('joint', 'step', 'found', 'verdict', 'why')
    for own in checks:
        table.add_row(own.joint, own.step, own.result, _verdict(own), own.problem or own.warning)
    return table


def check_document(
    checks: Sequence[Check], interface: str, channel: str, bitrate: int
) -> dict[str, Any]:
    """Return the JSON document of ``sosml can check``."""
    verdicts = [_verdict(own) for own in checks]
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
        'checks': [
            {
                'joint': own.joint,
                'step': own.step,
                'found': own.result,
                'verdict': _verdict(own),
                'why': own.problem or own.warning,
            }
            for own in checks
        ],
    }
