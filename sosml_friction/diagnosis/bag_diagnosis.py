# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From bags to a diagnosis: what the tool and the node both do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from sosml_friction.bags.recorded_robot import RecordedRobot, read_recorded_robot
from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.diagnosis.library import make_library
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.bag_analysis import bag_hash
from sosml_friction.identification.several.bags_analysis import bag_labels
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.settings import DiagnosisSettings


@dataclass(frozen=True)
class BagDiagnosis:
    """Hold a diagnosis, the model that was put to the test, and what it rests on."""

    diagnosis: Diagnosis
    nominal: RobotModelFile
    provenance: Mapping[str, Any]


def diagnose_bags(
    bags: Sequence[str | Path],
    model: str | Path | None = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    holdout: str | Path | None = None,
    without: Sequence[str] = (),
    settings: DiagnosisSettings | None = None,
    step: Callable[[str], None] = lambda text: None,
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
    :raises BagError: if a bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, an effect is unknown, bags are of
        different robots or one recording, or ``holdout`` is of no use.
    :raises DataError: if no joint has effort.
    """
    make_library(tuple(without))
    labels = bag_labels(bags)

    def read(path: str | Path, name: str) -> RecordedRobot:
        step(f'reading {name}')
        try:
            return read_recorded_robot(path, model, urdf, namespace, own_urdf=model is not None)
        except DataError as error:
            raise DataError(f'bag {name}: {error}') from error

    recorded = {label: read(path, label) for label, path in labels.items()}
    first, nominal = next((label, robot.nominal) for label, robot in recorded.items())
    known_terms(nominal)
    hashes: dict[str, str] = {}
    for label, path in labels.items():
        copy_of = hashes.setdefault(bag_hash(path), label)
        if copy_of != label:
            raise ConfigurationError(
                f'bags {copy_of} and {label} are copies of one recording, which would count '
                'twice: give each recording once'
            )
        _require_same_robot(first, recorded[first], label, recorded[label])
    provenance: dict[str, Any] = {
        'bags': [{'bag': label, 'sha256': digest} for digest, label in hashes.items()],
        'holdout': None,
        'model': nominal.name,
        'diagnosed': datetime.now(timezone.utc).isoformat(timespec='seconds'),
    }
    other = None
    if holdout is not None:
        digest = bag_hash(Path(holdout))
        if digest in hashes:
            raise ConfigurationError(
                f'the bag left out (holdout), {holdout}, is the recording {hashes[digest]}: the '
                'gain has to be measured on another one'
            )
        name = Path(holdout).name
        other = read(holdout, f'{name} (holdout)')
        _require_same_robot(first, recorded[first], name, other)
        provenance['holdout'] = {'bag': name, 'sha256': digest}
    diagnosis = diagnose(
        [robot.log for robot in recorded.values()],
        nominal,
        None if other is None else other.log,
        settings,
        tuple(without),
        step,
    )
    cut = tuple(
        Check('cut_off', 'warning', '*', robot.bag.recovery)
        for robot in [*recorded.values(), *([] if other is None else [other])]
        if robot.bag.recovery
    )
    diagnosis = replace(diagnosis, checks=(*diagnosis.checks, *cut))
    return BagDiagnosis(diagnosis, nominal, provenance)


def _require_same_robot(first: str, one: RecordedRobot, second: str, other: RecordedRobot) -> None:
    """
    Refuse recordings of different robots or models.

    :raises ConfigurationError: if joints, URDF, or the models written into the bags differ.
    """
    names = one.nominal.joint_names, other.nominal.joint_names
    if names[0] != names[1]:
        raise ConfigurationError(
            f'bags {first} and {second} are not of the same robot: their joints are '
            f'{", ".join(names[0])} and {", ".join(names[1])}: diagnose them one by one'
        )
    urdfs = [''.join((x.nominal.urdf or '').split()) for x in (one, other)]
    texts = [replace(x.nominal, name='', provenance={}).to_yaml() for x in (one, other)]
    if urdfs[0] != urdfs[1] or texts[0] != texts[1]:
        what = 'URDFs' if urdfs[0] != urdfs[1] else 'models'
        raise ConfigurationError(
            f'bags {first} and {second} have different {what}: say with --model which one is put '
            'to the test'
        )
