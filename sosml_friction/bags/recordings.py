# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several bags of one robot."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sosml_friction.bags.recorded_robot import ModelSource, RecordedRobot, read_recorded_robot
from sosml_friction.bags.source import Source, bag_labels, bag_source, refuse_copies
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.model_folder import RobotModelFile


def read_recordings(
    paths: Sequence[str | Path],
    model: ModelSource = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    own_urdf: bool = False,
    step: Callable[[str], None] = lambda text: None,
    whole: bool = False,
) -> dict[Source, RecordedRobot]:
    """
    Read bags of one robot, each given once, by what each is; its name is its label.

    The arguments are those of :func:`~sosml_friction.bags.recorded_robot.read_recorded_robot`, for
    every bag, and ``step`` is called with what is being done. ``whole`` refuses bags with
    different models of one robot, too.

    :raises BagError: if a bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, a bag is given twice or as a copy, or
        bags are of different robots.
    :raises DataError: if no joint of a bag has effort.
    """
    found: dict[Source, RecordedRobot] = {}
    for label, path in bag_labels(paths).items():
        one = read_labelled(label, path, model, urdf, namespace, own_urdf, step)
        found[bag_source(path, one.bag)._replace(name=label)] = one
        refuse_copies(list(found))
        first, other = next(iter(found.items()))
        require_same_robot(first.name, other.nominal, label, one.nominal, whole)
    return found


def read_labelled(
    label: str,
    path: str | Path,
    model: ModelSource,
    urdf: str | Path | None,
    namespace: str | None,
    own_urdf: bool,
    step: Callable[[str], None],
) -> RecordedRobot:
    """Read one bag; arguments and errors as of :func:`read_recordings`, with its label."""
    step(f'reading {label}')
    try:
        return read_recorded_robot(path, model, urdf, namespace, own_urdf)
    except DataError as error:
        raise DataError(f'bag {label}: {error}') from error


def require_same_robot(
    first: str, one: RobotModelFile, second: str, other: RobotModelFile, whole: bool = False
) -> None:
    """
    Refuse recordings with other joints, armature or URDF, or, if ``whole``, another model.

    :raises ConfigurationError: if joints, inertia of the rotors or URDF differ.
    """
    said = f'bags {first} and {second} are not of the same robot: '
    if one.joint_names != other.joint_names:
        raise ConfigurationError(
            f'{said}their joints are {", ".join(one.joint_names)} and '
            f'{", ".join(other.joint_names)}; take them one by one'
        )
    for name, joint in one.joints.items():
        own, armature = joint.armature, other.joints[name].armature
        same = np.array_equal([own.value], [armature.value], equal_nan=True)
        if not same or own.unit != armature.unit:
            raise ConfigurationError(
                f'{said}the armature of {name} is {own.value:g} and {armature.value:g} '
                f'{armature.unit}; give the right model for both with --model'
            )
    if ''.join((one.urdf or '').split()) != ''.join((other.urdf or '').split()):
        raise ConfigurationError(
            f'{said}their URDFs differ; give the right one for both with --urdf'
        )
    texts = [replace(x, name='', provenance={}).to_yaml() for x in (one, other)]
    if whole and texts[0] != texts[1]:
        raise ConfigurationError(
            f'bags {first} and {second} have different models: say with --model which one is put '
            'to the test'
        )
