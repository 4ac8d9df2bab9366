# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Simulate a recording again from a model, and compare."""

from collections.abc import Mapping
from typing import Any

from sosml_friction.api.logs import one_log
from sosml_friction.api.model import Model, content_of
from sosml_friction.api.result import Result, blocks_text
from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import as_recorded
from sosml_friction.bags.source import Source, log_source
from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.report.simulation.document import (
    simulation_blocks,
    simulation_document,
)
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation


class Simulation(Result):
    """
    Hold a recording and its simulation.

    ``found`` has all details. ``time`` (M,) [s] since the first sample; ``measured`` and
    ``simulated``: position, velocity and effort (M, n), at the samples that were simulated; the
    effort is the one that the model needs for the measured motion, both low-passed.
    """

    def __init__(self, found: RecordedSimulation, model: Model, source: Source) -> None:
        self.found, self._model, self._source = found, model, source

    @property
    def time(self) -> FloatArray:
        """Return the instants that were simulated, (M,) [s] since the first sample."""
        return self.found.time

    @property
    def measured(self) -> Mapping[str, FloatArray]:
        """Return position, velocity and effort as measured, (M, n)."""
        return self.found.measured

    @property
    def simulated(self) -> Mapping[str, FloatArray]:
        """Return position, velocity and effort as simulated, (M, n)."""
        return self.found.simulated

    def summary(self) -> str:
        """Return how well the simulation follows the recording, as sentences and a table."""
        return blocks_text(simulation_blocks(self.found))

    def to_dict(self) -> dict[str, Any]:
        """Return the object of ``sosml simulate --json``, without its entry ``output``."""
        return simulation_document(self.found, self._model.content, self._provenance())

    def _provenance(self) -> dict[str, Any]:
        name, digest, _ = self._source
        return {'bag': name, 'sha256': digest, 'model': self._model.name}

    def _brief(self) -> str:
        parts = [
            f'{joint}: position {errors["position"].relative:.3g} %, '
            f'effort {errors["effort"].relative:.3g} %'
            for joint, errors in self.found.errors.items()
        ]
        return f'errors of {"; ".join(parts)}'


def simulate(log: JointLog, model: Model, horizon_s: float | None = None) -> Simulation:
    """
    Simulate a recording from a model, driven by the measured effort, and compare.

    The simulation begins anew from the measured state every ``horizon_s``; the model's friction
    sticks, and its effects take part.

    :param log: the motion; its joints include the model's.
    :param horizon_s: length of a window [s]; 0.5 if None.
    :raises DataError: if no joint has effort, or no stretch is long enough.
    :raises ConfigurationError: if the model cannot be simulated, or the horizon is no time.
    """
    nominal = as_recorded(content_of(model), one_log(log))
    found = simulate_model(log, nominal, horizon_s=horizon_s)
    return Simulation(found, model, log_source(log, 'log'))
