# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A whole recording and its simulation: what the model gets wrong, by joint."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray

CLOSED_LOOP, WINDOWS = 'closed_loop', 'windows'


@dataclass(frozen=True)
class SimulationError:
    """
    Hold how far a simulated quantity of a joint is from the measured one.

    ``rms`` and ``largest`` in its unit; ``relative`` [%]: 100 |simulated - measured| / |measured|;
    of a position, as a share of the way from where the window or the recording began.
    """

    rms: float
    largest: float
    relative: float
    unit: str


@dataclass(frozen=True)
class RecordedSimulation:
    """
    Hold a recording and its simulation, at the samples that were simulated.

    ``mode``: ``closed_loop``, the recorded controllers follow what was wanted; or
    ``windows``, driven by the measured effort and begun anew from the measured state every
    ``horizon_s``; ``why_not``: why it is not the former. ``measured`` and ``simulated``: position,
    velocity and effort (N, n); in windows the effort is the one that the model needs for the
    measured motion, both low-passed. ``begins`` (N,): where a window begins. ``followed``: joints
    without effort, or in closed loop without a controller that is known, which follow the
    recording. ``displacement`` (n,): over which friction turns
    around; ``steps``: of the integration in a sample. ``remarks``: sentences.
    """

    mode: str
    why_not: str
    horizon_s: float | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    time: FloatArray
    measured: Mapping[str, FloatArray]
    simulated: Mapping[str, FloatArray]
    begins: BoolArray
    errors: Mapping[str, Mapping[str, SimulationError]]
    followed: tuple[str, ...]
    displacement: FloatArray
    steps: int
    remarks: tuple[str, ...]


def simulation_error(
    measured: FloatArray, simulated: FloatArray, origin: FloatArray | float, unit: str
) -> SimulationError:
    """Return the error of a quantity (N,) where known; the relative one counts from ``origin``."""
    difference = simulated - measured
    known = np.isfinite(difference)
    error = difference[known]
    size = float(np.linalg.norm((measured - origin)[known]))
    return SimulationError(
        float(np.sqrt(np.mean(error**2))) if known.any() else np.nan,
        float(np.abs(error).max(initial=0.0)),
        100.0 * float(np.linalg.norm(error)) / size if size > 0.0 else np.nan,
        unit,
    )
