# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of a recording and its simulation."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.report.figures.simulation.simulated_joint import SimulatedJointFigure
from sosml_friction.report.simulation.document import SimulatedJoint
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation

QUANTITIES = ('position', 'velocity', 'effort')


def found(count, length):
    """Return windows of ``length`` samples, a hole of 1 s in the middle of them."""
    time = 0.01 * np.arange(count) + (np.arange(count) >= count // 2)
    begins = np.arange(count) % length == 0
    within = (np.arange(count) % length)[:, None] * 1.0
    measured = dict.fromkeys(QUANTITIES, np.zeros((count, 1)))
    simulated = dict.fromkeys(QUANTITIES, within)
    return RecordedSimulation(
        'windows', 'asked for', 0.1, ('a',), ('Nm',), time, measured, simulated, begins, {}, (),
        np.ones(1), 2, (),
    )  # fmt: skip


@pytest.mark.parametrize('count', [60, 60000])
def test_no_line_joins_two_windows_nor_goes_over_a_hole(count):
    """In a long recording, drawn as its envelope, too."""
    # An envelope of 60000 samples has spans longer than 10.
    length = count // 6
    one = found(count, length)
    left, right = SimulatedJointFigure().draw(SimulatedJoint(one, 0)).axes[:2]
    measured, simulated = left.get_lines()
    (error,) = right.get_lines()
    for line, parts in ((simulated, 6), (error, 6), (measured, 2)):
        t, x = line.get_data()
        pieces = np.split(t, np.flatnonzero(np.isnan(x)))
        assert len(pieces) == parts
        for piece in pieces:
            assert np.ptp(piece[1:]) < 1.01 * 0.01 * length * (6 // parts)
        assert not np.isnan(x[[0, -1]]).any()
