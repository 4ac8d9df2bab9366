# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A driver whose machine is busy says so, of the last second and not of all time."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from sosml_friction.nodes.pace import Pace


def counts(cycles: int, late: int = 0, incomplete: int = 0) -> SimpleNamespace:
    return SimpleNamespace(cycles=cycles, late_cycles=late, incomplete_cycles=incomplete)


def test_a_second_with_many_lost_cycles_is_told_with_its_counts_and_the_next_is_not():
    pace = Pace()
    pace.look(counts(500, 10, 5), 10)
    assert pace.remark == ''
    pace.look(counts(950, 40, 6), 60)
    assert pace.remark.startswith(
        '81 of 500 cycles gave no sample (50 never ran, 30 had answers of an unknown time, 1 '
    )
    # A look at once changes nothing, a new drive begins anew.
    pace.look(counts(955, 45, 6), 60)
    assert pace.remark
    pace.look(counts(1450, 45, 6), 62)
    assert pace.remark == ''
    pace.look(counts(400, 0, 0), 0)
    assert pace.remark == ''
