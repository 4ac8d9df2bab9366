# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording simulated again from a model folder, the effects in its list included."""

from collections.abc import Mapping

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.known_terms import known_terms, model_friction
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.known_effort import with_known
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation
from sosml_friction.simulation.recorded.simulate_recording import Step, simulate_recording


def simulate_model(
    log: JointLog,
    model: RobotModelFile,
    controlled: Mapping[str, ControlledJoint] | None = None,
    horizon_s: float | None = None,
    step: Step = lambda what, share=None: None,
    loop: RecordedLoop | str = '',
) -> RecordedSimulation:
    """
    Simulate a recording from a model folder; parameters and errors of :func:`simulate_recording`.

    Smooth motion and the width of the sign are those of a diagnosis of the recording.
    """
    robot = model.make_robot()

    def prepared(whole: JointLog, shortest_s: float) -> tuple[ForwardModel, list[Signals]]:
        found = prepare([whole], model, robot, DiagnosisSettings(), shortest_s=shortest_s)
        signals = with_known(found, model)
        terms = [known.simulated(robot) for known in known_terms(model)]
        displacement = signals[0].scales.displacement
        return ForwardModel(robot, model_friction(model), displacement, terms), signals

    return simulate_recording(log, model, prepared, controlled, horizon_s, step, loop)
