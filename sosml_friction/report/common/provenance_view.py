# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where numbers come from: recording, versions, settings, command."""

from collections.abc import Mapping
from datetime import datetime, timezone
from html import escape
from typing import Any

from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.labels import observer_label

#: Entries of the provenance that are shown otherwise.
_ELSEWHERE = frozenset(
    {'bag', 'sha256', 'start_ns', 'end_ns', 'samples', 'recovered', 'fitted', 'versions',
     'observers', 'fits', 'unavailable', 'consolidation', 'bags'}
)  # fmt: skip


def recording_rows(analysis: BagAnalysis) -> dict[str, str]:
    """Return what identifies the recording, heading to text."""
    known = analysis.model.provenance
    rows = {
        'recording': str(known.get('bag', '')),
        'SHA-256': str(known.get('sha256', '')),
        'first and last stamp [ns]': f'{known.get("start_ns")} to {known.get("end_ns")}',
        'recorded': f'{_moment(known.get("start_ns"))} to {_moment(known.get("end_ns"))}',
        'samples': str(known.get('samples', '')),
        'cut off or damaged': 'yes' if known.get('recovered') else 'no',
    }
    rows.update({f'condition {key}': str(value) for key, value in analysis.log.tags.items()})
    return rows


def method_rows(analysis: BagAnalysis) -> dict[str, str]:
    """Return what was done with it and by which software, heading to text."""
    known = analysis.model.provenance
    rows = {
        'fitted': str(known.get('fitted', '')),
        'versions': _pairs(known.get('versions', {})),
        'model': analysis.model.name,
        'velocity of the observers': analysis.configuration.velocity_source.replace('_', ' '),
    }
    joints = analysis.configuration.joints
    order = f' ({", ".join(joints)})' if len(joints) > 1 else ''
    for observer, gains in known.get('observers', {}).items():
        rows[f'gains of {observer_label(observer)}{order}'] = '; '.join(
            f'{gain} ' + ', '.join(f'{value:.4g}' for value in values)
            for gain, values in gains.items()
        )
    rows.update({str(key): _text(value) for key, value in known.items() if key not in _ELSEWHERE})
    return rows


def provenance_table(
    rows: Mapping[str, str], truth: RobotModelFile | None, extra: Mapping[str, str]
) -> str:
    """Return the rows, the name of the truth where there is one, and more rows, as HTML."""
    shown = dict(rows)
    if truth is not None:
        shown['truth'] = truth.name
    shown.update(extra)
    body = ''.join(
        f'<tr><th>{escape(key)}</th><td><code>{escape(value)}</code></td></tr>'
        for key, value in shown.items()
    )
    return f'<table><tbody>{body}</tbody></table>'


def _moment(stamp_ns: Any) -> str:
    """Return a stamp as a date, where it can be one and not a time since some start."""
    try:
        moment = datetime.fromtimestamp(1e-9 * int(stamp_ns), timezone.utc)
    except (TypeError, ValueError, OverflowError, OSError):
        return 'unknown'
    return (
        f'{1e-9 * int(stamp_ns):.3f} s'
        if moment.year < 2000
        else moment.isoformat(timespec='seconds')
    )


def _text(value: Any) -> str:
    return _pairs(value, '; ') if isinstance(value, Mapping) else str(value)


def _pairs(values: Mapping[str, Any], separator: str = ', ') -> str:
    return separator.join(
        f'{key} ({_pairs(value)})' if isinstance(value, Mapping) else f'{key} {value}'
        for key, value in values.items()
        if value is not None
    )
