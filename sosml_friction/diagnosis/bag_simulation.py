# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From a bag to a simulation of what it holds."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from sosml_friction.bags.recorded_robot import ModelSource, read_recorded_robot
from sosml_friction.bags.source import bag_hash
from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.simulation.recorded.controlled_joint import recorded_controllers
from sosml_friction.simulation.recorded.recorded_loop import recorded_loop
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation


class BagSimulation(NamedTuple):
    """Hold a simulation of a bag, the model that was simulated, and what both rest on."""

    simulation: RecordedSimulation
    nominal: RobotModelFile
    provenance: dict[str, str]


def simulate_bag(
    bag: Path,
    model: ModelSource = None,
    urdf: Path | None = None,
    namespace: str | None = None,
    horizon_s: float | None = None,
    step: Callable[..., None] = lambda what, share=None: None,
) -> BagSimulation:
    """
    Simulate the recording in a bag from a model, and compare.

    :param model: folder of the model, with its own URDF; None: the bag's own.
    :param urdf: URDF file instead of either.
    :param namespace: which robot, where a bag holds several.
    :param horizon_s: length of windows [s] that begin anew from the measured state; None: the
        closed loop from end to end, where the bag holds its controller.
    :param step: called with what is done next and, where it is known, the share that is done.
    :raises SosmlFrictionError: as
        :func:`~sosml_friction.bags.recorded_robot.read_recorded_robot` and
        :func:`~sosml_friction.diagnosis.model_simulation.simulate_model`.
    """
    recorded = read_recorded_robot(bag, model, urdf, namespace, own_urdf=model is not None)
    controlled = recorded_controllers(recorded.bag, recorded.log)
    loop = recorded_loop(recorded.bag, bag, recorded.log)
    found = simulate_model(recorded.log, recorded.nominal, controlled, horizon_s, step, loop)
    said = [recorded.bag.recovery] if recorded.bag.recovery else []
    found = replace(found, remarks=(*said, *recorded.robot.remarks, *found.remarks))
    provenance = {
        'bag': bag.name,
        'sha256': bag_hash(bag),
        'model': str(model) if isinstance(model, Path) else recorded.nominal.name,
    }
    return BagSimulation(found, recorded.nominal, provenance)
