# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Registers that were written without their sign get it back; what has none stays."""

import numpy as np
import pytest

from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.lost_sign import with_sign
from sosml_friction.bags.tables.mapping import parse_mapping

T = np.arange(1000) / 100.0
COUNTS = np.rint(200.0 * np.sin(3.0 * T) + 60.0 * np.sign(np.cos(3.0 * T)))


@pytest.mark.parametrize(
    'written',
    [
        COUNTS % 2**16,
        COUNTS % 2**32,
        np.where(COUNTS < 0, 2**10 - COUNTS, COUNTS),
        np.where(COUNTS < 0, 2**15 - COUNTS, COUNTS),
    ],
    ids=['16 bits', '32 bits', 'bit 10', 'bit 15'],
)
def test_a_sign_that_was_lost_is_found(written):
    np.testing.assert_array_equal(with_sign(written.astype(np.int64)), COUNTS)
    gap = written.copy()
    gap[500:504] = np.nan
    np.testing.assert_array_equal(with_sign(gap)[:500], COUNTS[:500])


@pytest.mark.parametrize(
    'values',
    [
        COUNTS,
        np.abs(COUNTS),
        COUNTS + 1100.0,
        COUNTS + 2.0**15,
        COUNTS % 2**16 + 0.5,
        COUNTS[:1],
        np.where(T % 1.0 < 0.02, 65535, np.abs(COUNTS)),
    ],
)
def test_what_lost_no_sign_stays(values):
    assert with_sign(values) is None


def test_an_effort_without_its_sign_is_told_and_read_with_it(tmp_path):
    rows = zip(T.tolist(), np.sin(T).tolist(), (COUNTS % 2**16).tolist(), strict=True)
    (tmp_path / 'x.csv').write_text('t,q,i\n' + '\n'.join('{},{},{:.0f}'.format(*r) for r in rows))
    effort = {'variable': 'i', 'unit': 'counts', 'scale': 0.5}
    joints = {'joint': {'position': {'variable': 'q', 'unit': 'rad'}, 'effort': effort}}
    mapping = {'time': {'variable': 't', 'unit': 's'}, 'joints': joints}
    told = []
    log = read_recording(tmp_path / 'x.csv', parse_mapping(mapping, tmp_path / 'x'), told.append)
    np.testing.assert_allclose(log.tau[:, 0], 0.5 * COUNTS)
    assert any('read with the sign that it lost, from -' in sentence for sentence in told)
