# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the dates and times of day that loggers write as text."""

import re
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone

import numpy as np

from sosml_friction.arrays import FloatArray

_MONTHS = ['jan', 'feb', 'mar', 'apr', 'may', 'jun', 'jul', 'aug', 'sep', 'oct', 'nov', 'dec']
_DAY = 86400.0
#: What stands before the time of day; the year is first or last, and has four digits, or two
#: behind points: 26.11.26 is written where the day comes first.
_DATE = (
    r'(?:(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})'
    r'|(?P<first>\d{1,2})(?P<mark>[-/. ])(?P<second>\d{1,2}|[a-z]{3})(?P=mark)'
    r'(?P<last>\d{4}|(?<=\.)\d\d))'
)
_CLOCK = (
    r'(?P<hour>\d{1,2}):(?P<minute>\d\d)(?::(?P<sec>\d\d)(?:[.,:](?P<part>\d+))?)?'
    r'\s*(?P<half>[ap]m)?\s*(?P<zone>z|utc|[+-]\d\d:?\d\d)?'
)
_TEXT = re.compile(rf'(?:{_DATE}[t\s,]+)?{_CLOCK}', re.IGNORECASE)


def read_dates(cells: Sequence[str]) -> FloatArray:
    """
    Return the seconds of each cell since 1970, or of times of day since the first midnight.

    A date is that of ISO 8601, or has its year last: behind points or names of months
    the day comes first, as it does behind strokes where some day of them all is above 12; the
    month does where that can be no day. A time of day that falls by more than 12 hours is
    one of the next day. An empty cell is NaN.

    :raises ValueError: where a cell is neither; its arguments are the index of the cell and what
        is wrong with it, '' where it is no date at all.
    """
    whole = [_in_full(cell) for cell in cells]
    found = [_TEXT.fullmatch(cell) if cell else None for cell in whole]
    for k, match in enumerate(found):
        if match is None and cells[k]:
            raise ValueError(k, '')
    bare = [k for k, m in enumerate(found) if m is not None and not (m['year'] or m['last'])]
    is_dated = len(bare) < sum(match is not None for match in found)
    if bare and is_dated:
        raise ValueError(bare[0], 'has no date, and others have')
    is_day_first = _is_day_first(found)
    seconds = np.full(len(cells), np.nan)
    for k, match in enumerate(found):
        if match is not None:
            try:
                seconds[k] = _seconds(match, is_day_first)
            except ValueError:
                raise ValueError(k, '') from None
    if not is_dated:
        with np.errstate(invalid='ignore'):
            seconds += _DAY * np.append(0.0, np.cumsum(np.diff(seconds) < -0.5 * _DAY))
    return seconds


def _in_full(cell: str) -> str:
    """Return 02:30.5 with its hours, 20261126T100000 with its marks, pandas' 0 days without."""
    cell = re.sub(r'^\d+ days?,?\s+(?=\d)', '', cell)
    if re.fullmatch(r'\d{1,2}:\d\d[.,]\d+', cell):
        return f'0:{cell}'
    return re.sub(r'^(\d{4})(\d\d)(\d\d)T(\d\d)(\d\d)(\d\d)', r'\1-\2-\3T\4:\5:\6', cell)


def _is_day_first(found: Sequence[re.Match[str] | None]) -> bool:
    """Tell the order of day and month; all dates of a file have one."""
    order: bool | None = None
    open_at: int | None = None
    for k, match in enumerate(found):
        if match is None or not match['last']:
            continue
        if match['mark'] == '.' or not match['second'].isdecimal() or int(match['first']) > 12:
            order = True
        elif int(match['second']) > 12:
            order = False
        elif match['first'] != match['second'] and open_at is None:
            open_at = k
    days = {(m['first'], m['second'], m['last']) for m in found if m is not None and m['last']}
    # Of one day differences are the same in either order.
    if order is None and open_at is not None and len(days) > 1:
        raise ValueError(open_at, 'may have the day first or the month: write dates as 2026-11-26')
    return bool(order)


def _seconds(match: re.Match[str], is_day_first: bool) -> float:
    """Return what a cell says [s]; one without a zone is as good as UTC, for differences."""
    hour = int(match['hour'])
    if match['half']:
        if not 1 <= hour <= 12:
            raise ValueError
        hour = hour % 12 + 12 * (match['half'].lower() == 'pm')
    day = (1970, 1, 1)
    if match['year']:
        day = (int(match['year']), int(match['month']), int(match['day']))
    elif match['last']:
        one, other = match['first'], match['second'].lower()
        other = other if other.isdecimal() else str(_MONTHS.index(other) + 1)
        first, second = (int(other), int(one)) if is_day_first else (int(one), int(other))
        year = int(match['last'])
        day = (year if year > 99 else 2000 + year, first, second)
    when = datetime(*day, hour, int(match['minute']), int(match['sec'] or 0), tzinfo=timezone.utc)
    zone = re.sub('[^0-9+-]', '', match['zone'] or '')
    if zone:
        minutes = 60 * int(zone[1:3]) + int(zone[3:5])
        when -= timedelta(minutes=minutes if zone[0] == '+' else -minutes)
    return when.timestamp() + float(f'0.{match["part"] or 0}')
