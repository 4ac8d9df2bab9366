# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Counters whose register is full within a recording."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.mapping import parse_mapping
from sosml_friction.bags.tables.overflow import without_overflow
from sosml_friction.bags.tables.stated_columns import Columns, map_columns

#: Microseconds at 500 Hz with one lost sample, from 1 s before 2^32.
CLOCK = 2**32 - 1_000_000 + 2000 * np.delete(np.arange(2000), 700)


@pytest.mark.parametrize('kind', [np.int64, np.uint32])
def test_a_counter_goes_on_where_its_register_is_full(kind):
    np.testing.assert_array_equal(without_overflow((CLOCK % 2**32).astype(kind)), CLOCK)
    # A wheel of its own: twice around.
    twice = np.arange(0, 3 * 2**32, 2**28)
    np.testing.assert_array_equal(without_overflow(twice % 2**32), twice)


@pytest.mark.parametrize(
    'values',
    [
        CLOCK,
        CLOCK.astype(float) % 2**32,
        # A recording behind another one, and a count that begins anew earlier.
        np.append(CLOCK[:100] % 2**32, 5_000_000 + CLOCK[:100] % 2**31),
        np.tile(np.arange(1000), 3),
        -np.arange(10),
        np.arange(0),
    ],
)
def test_what_is_no_full_register_is_left_as_it_is(values):
    assert without_overflow(values) is values


def test_a_table_with_such_a_clock_is_read_and_it_is_told(tmp_path):
    rows = [f'{c % 2**32},{np.sin(1e-6 * (c - CLOCK[0])):.6f},0.5' for c in CLOCK.tolist()]
    path = tmp_path / 'x.csv'
    path.write_text('\n'.join(['micros,q,tau', *rows]) + '\n')
    stated = Columns({'position': ['q:rad'], 'effort': ['tau:Nm']}, time='micros:us')
    told: list[str] = []
    plan = parse_mapping(map_columns(DataFile(path), stated).content, path)
    log = read_recording(path, plan, told.append)
    np.testing.assert_array_equal(log.t_ns - log.t_ns[0], 1000 * (CLOCK - CLOCK[0]))
    assert any('micros begins anew at index 500, where its register is full' in x for x in told)
