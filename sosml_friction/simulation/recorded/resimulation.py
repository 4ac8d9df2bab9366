# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Windows of a recording simulated forward, from the measured state and by the measured effort."""

from collections.abc import Callable

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.simulation.forward_drive import RecordedDrive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import simulate
from sosml_friction.simulation.recorded.stretch import Stretch, measured_start, undriven
from sosml_friction.simulation.simulated import Simulated


def recorded_torque(model: ForwardModel, stretch: Stretch) -> FloatArray:
    """Return the torque (N, n) behind the effort of a recording, its delay undone."""
    tau, step = stretch.tau, stretch.band.step
    samples = np.arange(len(tau), dtype=np.float64)
    shifted = samples + model.delay / step
    return model.torque(np.column_stack([np.interp(shifted, samples, x) for x in tau.T]))


def simulate_windows(
    model: ForwardModel,
    stretch: Stretch,
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
        measured_start(stretch, at),
        RecordedDrive(recorded_torque(model, stretch), at),
        stretch.band.step,
        samples,
        np.quantile(np.abs(stretch.tau), 0.99, axis=0),
        step,
        undriven(stretch),
    )
