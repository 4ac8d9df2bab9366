# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Dates and times of day as loggers write them."""

import numpy as np
import pytest

from sosml_friction.bags.tables.date_text import read_dates

#: 2026-11-26 10:00:00.125 UTC.
WHEN = 1795687200.125


@pytest.mark.parametrize(
    'text',
    [
        '2026-11-26T10:00:00.125Z',
        '2026-11-26 10:00:00,125',
        '2026-11-26T11:00:00.125+01:00',
        '2026-11-26T04:30:00.125-0530',
        '2026/11/26 10:00:00.125',
        '26.11.2026 10:00:00,125',
        '11/26/2026 10:00:00.125',
        '11/26/2026, 10:00:00.125 AM',
        '26/11/2026 10:00:00:125',
        '26-Nov-2026 10:00:00.125',
        '26.11.26 10:00:00.125',
        '20261126T100000.125Z',
        '26 nov 2026 10:00:00.125 UTC',
    ],
)
def test_one_moment_in_every_form(text):
    assert read_dates([text]) == pytest.approx([WHEN], abs=1e-6)


def test_one_date_of_the_file_tells_the_order_of_all():
    for texts in (
        ['03/04/2026 23:59:59', '13/04/2026 00:00:00'],
        ['03/04/2026 1:00', '03/14/2026 1:00'],
    ):
        assert np.diff(read_dates(texts)) > 0.0
    assert np.diff(read_dates(['04.03.2026 23:59:59.5', '05.03.2026 00:00:00.5'])) == 1.0
    with pytest.raises(ValueError, match='may have the day first or the month') as caught:
        read_dates(['', '03/04/2026 10:00:00', '04/04/2026 10:00:00'])
    assert caught.value.args[0] == 1
    # Of one day, differences are the same in either order.
    assert np.diff(read_dates(['03/04/2026 10:00:00', '03/04/2026 10:00:01'])) == 1.0


def test_minutes_and_seconds_need_no_hours():
    np.testing.assert_allclose(read_dates(['59:59.5', '00:02.25']), [3599.5, 2.25])


def test_time_of_day_goes_on_over_midnight():
    texts = ['11:59:59.9 pm', '12:00:00.0 am', '', '00:00:00.1']
    expected = [86399.9, 86400.0, np.nan, 86400.1]
    np.testing.assert_allclose(read_dates(texts), expected)


@pytest.mark.parametrize(
    ('text', 'why'),
    [
        ('two', ''),
        ('31.02.2026 10:00:00', ''),
        ('13/13/2026 10:00:00', ''),
        ('2026-11-26 10:61:00', ''),
        ('2026-11-26 13:00:00 pm', ''),
        ('10:00:01', 'has no date, and others have'),
    ],
)
def test_what_is_no_date_is_told_by_its_index(text, why):
    with pytest.raises(ValueError, match=r'1, ') as caught:
        read_dates(['2026-11-26 10:00:00', text])
    assert caught.value.args == (1, why)


def test_a_duration_of_pandas_is_a_time_of_day():
    texts = ['0 days 00:00:00', '0 days 00:00:00.005000', '0 days 23:59:59', '1 days 00:00:01']
    assert np.diff(read_dates(texts)).tolist() == pytest.approx([0.005, 86398.995, 2.0])
