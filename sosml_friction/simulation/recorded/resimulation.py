# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Windows of a recording simulated forward, from the measured state and by the measured effort."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_drive import RecordedDrive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import Simulated, simulate
from sosml_friction.simulation.forward_start import Start

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


def measured_start(signals: Signals, at: IndexArray) -> Start:
    """Return the measured state at the samples ``at`` (W,)."""
    q, v, a = signals.q, signals.v, signals.a
    warm = np.full(q.shape, np.nan)
    if signals.temperature is not None:
        warm = signals.temperature - signals.temperature[0]
    return Start(q[at], v[at], a[at], signals.sign[at], signals.q, at, signals.time, warm)


def recorded_torque(model: ForwardModel, signals: Signals) -> FloatArray:
    """Return the torque (N, n) behind the effort of a recording, its delay undone."""
    tau, step = signals.tau, signals.band.step
    samples = np.arange(len(tau), dtype=np.float64)
    shifted = samples + model.delay / step
    return model.torque(np.column_stack([np.interp(shifted, samples, x) for x in tau.T]))


def simulate_windows(
    model: ForwardModel,
    signals: Signals,
    at: IndexArray,
    samples: int,
    step: Callable[[int], None] = lambda k: None,
) -> Simulated:
    """
    Simulate ``samples`` samples from each of the samples ``at`` (W,).

    A joint whose effort was not measured follows its recording.

    :raises ConfigurationError: if the model cannot be simulated.
    """
    return simulate(
        model,
        measured_start(signals, at),
        RecordedDrive(recorded_torque(model, signals), at),
        signals.band.step,
        samples,
        np.quantile(np.abs(signals.tau), 0.99, axis=0),
        step,
        undriven(signals),
    )


def undriven(signals: Signals) -> list[int]:
    """Return the joints whose effort is not in the recording, which nothing can drive."""
    return [int(i) for i in np.flatnonzero(~signals.tau.any(axis=0))]
