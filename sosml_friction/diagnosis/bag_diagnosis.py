# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From bags to a diagnosis: what the tool and the node both do."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import ModelSource
from sosml_friction.bags.recordings import read_labelled, read_recordings, require_same_robot
from sosml_friction.bags.source import Source, bag_source
from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.diagnosis.library import make_library
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.body_refit import BodyRefit
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.settings import DiagnosisSettings


@dataclass(frozen=True)
class BagDiagnosis:
    """
    Hold a diagnosis, the model that was put to the test, and what it rests on.

    ``holdout`` is the other recording, on which the gain was measured; None: there was none.
    """

    diagnosis: Diagnosis
    nominal: RobotModelFile
    provenance: Mapping[str, Any]
    holdout: JointLog | None = None


def diagnose_bags(
    bags: Sequence[str | Path],
    model: ModelSource = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    holdout: str | Path | None = None,
    without: Sequence[str] = (),
    settings: DiagnosisSettings | None = None,
    step: Callable[[str], None] = lambda text: None,
    keep_all: bool = False,
) -> BagDiagnosis:
    """
    Say what a model gets wrong about the recordings in bags.

    :param model: folder of the model that is put to the test, with its own URDF; None for the
        first bag's own model and robot_description.
    :param urdf: URDF file instead of either.
    :param namespace: which robot, where a bag holds several.
    :param holdout: bag on which the gain is measured; None for folds of ``bags``.
    :param without: effects not to look for.
    :param step: called with what is being done.
    :param keep_all: keep causes in the extended model that ``holdout`` contradicts.
    :raises BagError: if a bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, an effect is unknown, bags are of
        different robots or one recording, or ``holdout`` is of no use.
    :raises DataError: if no joint has effort.
    """
    make_library(tuple(without))
    own_urdf = model is not None
    recorded = read_recordings(bags, model, urdf, namespace, own_urdf, step, whole=True)
    first, nominal = next((source.name, robot.nominal) for source, robot in recorded.items())
    logs = [(source, robot.log) for source, robot in recorded.items()]
    other = None
    if holdout is not None:
        name = Path(holdout).name
        label = f'{name} (holdout)'
        left_out = read_labelled(label, holdout, model, urdf, namespace, own_urdf, step)
        other = bag_source(holdout, left_out.bag), left_out.log
        require_same_robot(first, nominal, name, left_out.nominal, whole=True)
    return diagnose_logs(logs, nominal, other, without, settings, step, keep_all)


def diagnose_logs(
    logs: Sequence[tuple[Source, JointLog]],
    nominal: RobotModelFile,
    holdout: tuple[Source, JointLog] | None = None,
    without: Sequence[str] = (),
    settings: DiagnosisSettings | None = None,
    step: Callable[[str], None] = lambda text: None,
    keep_all: bool = False,
) -> BagDiagnosis:
    """
    Say what a model gets wrong about recordings, and which recordings these were.

    The arguments are those of :func:`~sosml_friction.diagnosis.diagnosis.diagnose`, and so are the
    errors; a recording that was cut off is among the data checks.

    :raises ConfigurationError: if ``holdout`` is one of ``logs``, too.
    """
    hashes = {source.sha256: source.name for source, _ in logs}
    if holdout is not None and holdout[0].sha256 in hashes:
        raise ConfigurationError(
            f'the bag left out (holdout), {holdout[0].name}, is the recording '
            f'{hashes[holdout[0].sha256]}: the gain has to be measured on another one'
        )
    fitted: list[Check] = []
    if unknown := nominal.unknown_armature:
        settings = replace(settings or DiagnosisSettings(), unknown_armature=unknown)
        rotors = _fitted_rotors([log for _, log in logs], nominal, step)
        nominal = nominal.with_armature({'*': 0.0}) if rotors is None else rotors.model
        told = () if rotors is None else rotors.sentences()
        fitted = [Check('armature', 'warning', '*', said) for said in told]
    diagnosis = diagnose(
        [log for _, log in logs],
        nominal,
        None if holdout is None else holdout[1],
        settings,
        tuple(without),
        step,
        keep_all,
    )
    recordings = [*logs, *([] if holdout is None else [holdout])]
    sources = [source for source, _ in recordings]
    cut = [Check('cut_off', 'warning', '*', s.recovery) for s in sources if s.recovery]
    held = [Check('held_joints', 'note', '*', said) for said in nominal.make_robot().remarks]
    bags = [
        {
            'bag': source.name,
            'sha256': source.sha256,
            'start_ns': int(log.t_ns[0]),
            'end_ns': int(log.t_ns[-1]),
        }
        for source, log in recordings
    ]
    provenance = {
        'bags': bags[: len(logs)],
        'holdout': None if holdout is None else bags[-1],
        'model': nominal.name,
        # JSON has no infinity.
        'trust': {
            group: 'inf' if np.isinf(share) else share
            for group, share in (settings or DiagnosisSettings()).trust.items()
        },
        'diagnosed': datetime.now(timezone.utc).isoformat(timespec='seconds'),
    }
    diagnosis = replace(diagnosis, checks=(*diagnosis.checks, *cut, *held, *fitted))
    other = None if holdout is None else holdout[1]
    return BagDiagnosis(diagnosis, nominal, provenance, other)


def _fitted_rotors(
    logs: Sequence[JointLog], nominal: RobotModelFile, step: Callable[[str], None]
) -> BodyRefit | None:
    """
    Return the model with rotors that it does not know as they fit; None where no data are of use.

    :raises DataError: if a joint is not in a recording, or the recordings are too short.
    """
    recordings = Recordings.checked(logs, nominal.with_armature({'*': 0.0}).make_robot())
    try:
        recordings.refuse_bad()
    except DataError:
        # The diagnosis will say so.
        return None
    # Of a joint that rests nothing is known: its terms would cost as much as all others.
    return BodyComparison.of(recordings.logs, nominal, 0.0, step).refit
