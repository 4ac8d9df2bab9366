# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``make sysid``: the pendulum that both tools fit is the one that the table calls the truth."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

BENCHMARK = Path(__file__).resolve().parents[2] / 'benchmarks' / 'sysid.py'


@pytest.fixture
def benchmark_(monkeypatch):
    specification = importlib.util.spec_from_file_location('sysid_benchmark', BENCHMARK)
    module = importlib.util.module_from_spec(specification)
    monkeypatch.setitem(sys.modules, 'sysid_benchmark', module)  # its dataclasses look there
    specification.loader.exec_module(module)
    monkeypatch.setattr(module, 'LENGTH', 12.0)
    monkeypatch.setattr(module, 'SPEEDS', (0.02, 1.0))
    return module


@pytest.mark.parametrize('knee', [0.0, 0.25])
def test_the_pendulum_obeys_its_equation_of_motion_and_sticks(benchmark_, knee):
    q, v, tau = benchmark_.motion(knee)[0].T
    drive = tau + 9.81 * 0.122324 * np.cos(q)
    rests = v == 0.0
    assert rests.any()
    assert np.abs(drive[rests]).max() <= 0.4 + knee
    friction = np.sign(v) * (0.4 + knee * np.exp(-np.abs(v) / 0.05)) + 0.12 * v
    # The mean of two samples stands for what is between them, where neither is at a reversal.
    mean = (drive - friction)[:-1] / 2 + (drive - friction)[1:] / 2
    moving = (v[:-1] * v[1:] > 0) & (np.abs(v[1:]) > 1e-3)
    error = (0.1625 * np.diff(v) / 0.002 - mean)[moving]
    assert moving.mean() > 0.7
    assert np.sqrt(np.mean(error**2)) < 2e-3
    assert np.abs(v).max() > 0.95


def test_without_mujoco_the_benchmark_says_what_to_install(benchmark_, monkeypatch):
    monkeypatch.setitem(sys.modules, 'mujoco', None)
    monkeypatch.setattr(sys, 'argv', ['sysid.py'])
    with pytest.raises(SystemExit, match=r'pip install "mujoco\[sysid\]"'):
        benchmark_.main()
