# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a simulation has to know of a recording, which regression makes; simulated windows."""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.terms.kinds import recording
from sosml_friction.simulation.forward_drive import RecordedDrive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import Start, simulate
from sosml_friction.simulation.simulated import Simulated
from sosml_friction.simulation.window_models import WindowModels, as_window_models


class LowPass(recording.LowPass, Protocol):
    """A filter of samples that is wrong in the ``half`` at either end."""

    @property
    def half(self) -> int: ...  # noqa: D102


class Stretch(recording.Recording, Protocol):
    """
    A part of a recording without holes, N even samples of n joints.

    ``tau`` (N, n): measured effort, 0 of a joint that has none.
    """

    @property
    def tau(self) -> FloatArray: ...  # noqa: D102
    @property
    def band(self) -> LowPass: ...  # noqa: D102


#: prepare(log, shortest [s]) makes the model to simulate and the stretches of the log that last
#: ``shortest`` or longer; a DataError says that there is none.
Prepare = Callable[[JointLog, float], tuple[ForwardModel, Sequence[Stretch]]]


def measured_start(stretch: Stretch, at: IndexArray) -> Start:
    """Return the measured state at the samples ``at`` (W,)."""
    q, v, a = stretch.q, stretch.v, stretch.a
    warm = np.full(q.shape, np.nan)
    if stretch.temperature is not None:
        warm = stretch.temperature - stretch.temperature[0]
    return Start(q[at], v[at], a[at], stretch.sign[at], q, at, stretch.time, warm)


def undriven(stretch: Stretch) -> list[int]:
    """Return the joints whose effort is not in the recording, which nothing can drive."""
    return [int(i) for i in np.flatnonzero(~stretch.tau.any(axis=0))]


def smooth_velocity(stretch: Stretch) -> FloatArray:
    """Return the velocity (N, n), NaN at the ends, where a smoothed one is wrong."""
    v = stretch.v.copy()
    v[: stretch.band.half] = v[len(v) - stretch.band.half :] = np.nan
    return v


def recorded_torque(model: ForwardModel, stretch: Stretch) -> FloatArray:
    """Return the torque (N, n) behind the effort of a recording, its delay undone."""
    tau, step = stretch.tau, stretch.band.step
    samples = np.arange(len(tau), dtype=np.float64)
    columns = zip(model.delay / step, tau.T, strict=True)
    return model.torque(
        np.column_stack([np.interp(samples + late, samples, x) for late, x in columns])
    )


def largest_effort(stretch: Stretch) -> FloatArray:
    """Return the effort of each joint that friction by load scales with, (n,)."""
    return np.asarray(np.quantile(np.abs(stretch.tau), 0.99, axis=0))


def can_be_simulated(model: ForwardModel, stretch: Stretch, at: IndexArray) -> bool:
    """Tell whether a model has inertia, and is soft enough, in windows at the samples ``at``."""
    posture = np.median(stretch.q[at], axis=0)
    try:
        model.steps(posture, largest_effort(stretch), stretch.band.step)
    except ConfigurationError:
        return False
    return True


def simulate_windows(
    model: ForwardModel | WindowModels,
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
    models = as_window_models(model, len(at))
    rows = np.minimum(at[:, None] + np.arange(samples + 1), len(stretch.q) - 1)
    torque = models.each(lambda own, windows: recorded_torque(own, stretch)[rows[windows]])
    return simulate(
        models,
        measured_start(stretch, at),
        RecordedDrive(torque),
        stretch.band.step,
        samples,
        largest_effort(stretch),
        step,
        undriven(stretch),
    )
