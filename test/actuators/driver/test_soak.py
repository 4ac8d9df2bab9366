# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A few seconds of ``make soak``: every cycle is counted. How late they are is not judged."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

SOAK = Path(__file__).resolve().parents[3] / 'benchmarks' / 'soak.py'


@pytest.fixture(scope='module')
def soak():
    # By this name the process it spawns finds the module again.
    specification = importlib.util.spec_from_file_location('soak', SOAK)
    module = importlib.util.module_from_spec(specification)
    sys.modules['soak'] = module
    sys.path.insert(0, str(SOAK.parent))
    specification.loader.exec_module(module)
    yield module
    sys.path.remove(str(SOAK.parent))
    del sys.modules['soak']


def test_a_few_seconds_at_500_hz_are_accounted_for_cycle_by_cycle(soak):
    result = soak.soak(4.0)
    assert result.problems() == []
    assert result.samples > 0
    assert result.slots >= 1900
    assert result.frames_sent > 3 * result.samples
    assert len(set(result.threads)) == 1
    assert soak.lines(result)


def test_what_does_not_add_up_is_said(soak):
    result = soak.SoakResult(
        10.0, 500.0, slots=5000, cycles=4000, skipped=900, samples=3990, incomplete=20,
        frames_sent=7, frames_heard=6, threads=[2, 2, 3], memory_mb=[100.0] * 5 + [110.0] * 5,
    )  # fmt: skip
    text = ' '.join(result.problems())
    for part in ('5000 cycles were due', '3990 samples', '7 frames', 'threads', 'grew by 10.0 MB'):
        assert part in text
