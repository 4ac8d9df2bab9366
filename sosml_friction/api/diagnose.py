# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Say what a model gets wrong about recordings, and why."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.api.logs import labelled
from sosml_friction.api.model import Model, one_model
from sosml_friction.api.names import as_names
from sosml_friction.api.result import Result, interval_of
from sosml_friction.api.simulate import Simulation, simulate
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import as_recorded
from sosml_friction.bags.source import log_source, refuse_copies
from sosml_friction.diagnosis.bag_diagnosis import BagDiagnosis, diagnose_logs
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.export.diagnosed import trust_of_a_simulation, with_simulator
from sosml_friction.one_thread import in_one_thread
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.common.output import check_output_folder
from sosml_friction.report.diagnosis.document import (
    KIND,
    diagnosis_document,
    diagnosis_lines,
    write_diagnosis,
)


class Diagnosis(Result):
    """
    Hold a verdict and what it rests on.

    ``found`` has all details: the regression, every candidate, the gain on other data.
    """

    def __init__(self, found: BagDiagnosis) -> None:
        self.found = found

    @property
    def verdict(self) -> str:
        """Return named, ambiguous, nothing_above_floor, unknown_structure or bad_data."""
        return self.found.diagnosis.verdict

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Return the causes in the order in which they were accepted."""
        return self.found.diagnosis.causes

    @property
    def model(self) -> Model:
        """
        Return the model refitted within its tolerance, with the causes that a model can have.

        It is the nominal one where there is nothing to add.
        """
        diagnosis, nominal = self.found.diagnosis, self.found.nominal
        if not any(term.in_model for term in diagnosis.terms):
            return Model(nominal)
        return Model(extended_model(nominal, diagnosis, self.found.provenance))

    def conf_int(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Return 95 % intervals of the causes' parameters, by joint and ``effect.parameter``."""
        intervals: dict[str, dict[str, tuple[float, float]]] = {}
        for cause in self.causes:
            own = intervals.setdefault(cause.joint, {})
            for name, parameter in cause.parameters.items():
                own[f'{cause.effect}.{name}'] = interval_of(parameter)
        return intervals

    def predict(self, log: JointLog) -> Simulation:
        """
        Simulate a recording with :attr:`model`.

        :raises DataError: if no joint has effort, or no stretch is long enough.
        """
        return simulate(log, self.model)

    def summary(self) -> str:
        """Return the verdict in a sentence, then what it rests on and what to record next."""
        return '\n'.join(diagnosis_lines(self.found.diagnosis))

    def to_dict(self) -> dict[str, Any]:
        """Return the object of ``sosml diagnose --json``, without its entry ``output``."""
        return diagnosis_document(self.found.diagnosis, self.found.provenance)

    def write(self, folder: str | Path) -> Path:
        """
        Write what ``sosml diagnose`` writes: diagnosis.json, report.html, the extended model.

        An earlier diagnosis in the same place is replaced, anything else is not touched.

        :raises ConfigurationError: if the folder holds something else or cannot be written.
        """
        path = check_output_folder(folder, KIND)
        write_diagnosis(path, self.found.diagnosis, self.found.nominal, self.found.provenance)
        return path

    def _brief(self) -> str:
        causes = ', '.join(f'{cause.effect} of {cause.joint}' for cause in self.causes)
        return f'{self.verdict}: {causes}' if causes else self.verdict


@in_one_thread
def diagnose(
    logs: JointLog | Sequence[JointLog] | Mapping[str, JointLog],
    model: Model | None = None,
    holdout: JointLog | None = None,
    *,
    without: str | Sequence[str] = (),
    keep_all: bool = False,
    trust: Mapping[str, float] | None = None,
    mjcf: str | Path | None = None,
) -> Diagnosis:
    """
    Say what a model gets wrong about recordings, name the cause, and measure the gain.

    :param logs: one recording, or several of one robot, by labels of their own if you like.
    :param model: what is put to the test: rigid body, friction and effects.
    :param holdout: another recording, on which the gain is measured; None for stretches of
        ``logs`` that are left out in turn.
    :param without: effects not to look for.
    :param keep_all: keep causes in the model that ``holdout`` contradicts.
    :param trust: by how much of itself, or inf, a nominal parameter may be off and be refitted
        without being a cause: of masses, armature, friction, terms (stated ones that are no
        friction), torque_constant; else 0.035.
    :param mjcf: MuJoCo's model that is put to the test, instead of ``model``. Its friction is a
        guess (``trust`` of friction is inf), and the gain is measured in MuJoCo.
    :raises ConfigurationError: if an effect or a group of ``trust`` is unknown, a recording is
        given twice, ``holdout`` is of no use, or not one of ``model`` and ``mjcf`` is given.
    :raises DataError: if a joint of the model is not in a recording.
    """
    recordings = [(log_source(log, label), log) for label, log in labelled(logs).items()]
    refuse_copies(source for source, _ in recordings)
    other = None if holdout is None else (log_source(holdout, 'holdout'), holdout)
    nominal = as_recorded(one_model(model, mjcf), recordings[0][1])
    told = dict(trust or {})
    settings = DiagnosisSettings(trust=told if mjcf is None else trust_of_a_simulation(told))
    found = diagnose_logs(
        recordings, nominal, other, as_names(without) or (), settings, keep_all=keep_all
    )
    return Diagnosis(found if mjcf is None else with_simulator(found, Path(mjcf)))
