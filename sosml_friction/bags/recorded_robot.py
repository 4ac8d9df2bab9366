# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The robot whose motion a bag holds, its model, and which recording it is."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile, parse_model, read_model
from sosml_friction.model.robot import Robot


class Source(NamedTuple):
    """
    Say which recording a result rests on.

    ``sha256`` of the bag's files, or of the samples of a log that no bag holds; ``recovery`` is
    what a bag that was cut off says of itself, '' of a whole one.
    """

    name: str
    sha256: str
    recovery: str = ''


@dataclass(frozen=True)
class RecordedRobot:
    """Hold the motion in a bag and the robot that made it, joints in the order of the model."""

    bag: Bag
    log: JointLog
    nominal: RobotModelFile
    robot: Robot


def read_recorded_robot(
    path: str | Path,
    model: str | Path | None = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    own_urdf: bool = False,
) -> RecordedRobot:
    """
    Read the motion in a bag and the robot that made it.

    The bag's own robot_description and model_description are used unless the caller gives others.

    :param model: model folder with the armature of the joints, None for the bag's.
    :param urdf: URDF file, None for the bag's, or where it has none the model's.
    :param namespace: which robot, where a bag holds several.
    :param own_urdf: whether the URDF of the folder ``model`` comes before the bag's: where the
        model is what is put to the test.
    :raises BagError: if the bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, or joints disagree.
    :raises DataError: if no joint has effort.
    """
    bag = Bag.open(path, namespace)
    log = bag.joint_log()
    nominal = read_nominal(bag, path, model, urdf, own_urdf)
    robot = nominal.make_robot()
    log = log.select(robot.names)
    log.require_effort()
    return RecordedRobot(bag, log, nominal, robot)


def read_nominal(
    bag: Bag,
    path: str | Path,
    model: str | Path | None,
    urdf: str | Path | None,
    own_urdf: bool = False,
) -> RobotModelFile:
    """
    Return the robot in a bag, with its URDF; parameters as for :func:`read_recorded_robot`.

    The URDF of a model whose rigid body was identified comes before the bag's.

    :raises ConfigurationError: if no model or URDF is known.
    """
    nominal = _model_of(bag, path, model)
    own = nominal.urdf if own_urdf or nominal.is_rigid_body_identified else None
    if own is None or urdf is not None:
        document = _urdf_of(bag, urdf) or nominal.urdf
    else:
        document = own
    if document is None:
        raise ConfigurationError(f'bag {path} has no robot_description: give a URDF with --urdf')
    return replace(nominal, urdf=document)


def _model_of(bag: Bag, path: str | Path, model: str | Path | None) -> RobotModelFile:
    if model is not None:
        return read_model(model)
    text = bag.text('model_description')
    if text is None:
        raise ConfigurationError(
            f'bag {path} has no model_description, so the armature of its joints is not known: '
            'give a model folder with --model'
        )
    return parse_model(text, f'model_description of {path}')


def _urdf_of(bag: Bag, urdf: str | Path | None) -> str | None:
    if urdf is None:
        return bag.text('robot_description')
    try:
        return Path(urdf).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f'URDF {urdf} cannot be read: give the path of a file') from error


def bag_name(bag: str | Path) -> str:
    """Return the name of a bag, which is a folder or an .mcap file."""
    path = Path(bag).resolve()
    return path.stem if path.suffix == '.mcap' else path.name


def bag_labels(paths: Sequence[str | Path]) -> dict[str, Path]:
    """
    Return the bags by a label of each: its name, or where two have the same, its path.

    :raises ConfigurationError: if a bag is given twice.
    """
    resolved = [Path(path).resolve() for path in paths]
    for k, path in enumerate(resolved):
        if path in resolved[:k]:
            raise ConfigurationError(f'bag {paths[k]} is given twice: give each bag once')
    names = [bag_name(path) for path in resolved]
    return {
        name if names.count(name) == 1 else str(path): Path(path)
        for name, path in zip(names, paths, strict=True)
    }


def bag_hash(path: Path) -> str:
    """Return the SHA-256 of a bag's MCAP files, in the order of their names."""
    files = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        with file.open('rb') as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


def bag_source(path: str | Path, bag: Bag) -> Source:
    """Return which recording a bag is."""
    return Source(Path(path).name, bag_hash(Path(path)), bag.recovery)


def log_source(log: JointLog, name: str) -> Source:
    """Return which recording a log is that no bag holds, by its joints, stamps and samples."""
    digest = hashlib.sha256('\n'.join(log.names).encode())
    for samples in (log.t_ns, log.q, log.v, log.tau, log.temperature):
        digest.update(b'' if samples is None else samples.tobytes())
    return Source(name, digest.hexdigest())


def refuse_copies(sources: Mapping[str, str]) -> None:
    """
    Refuse one recording under two labels.

    :param sources: SHA-256 by label.
    :raises ConfigurationError: if two are the same.
    """
    labels: dict[str, str] = {}
    for label, digest in sources.items():
        copy_of = labels.setdefault(digest, label)
        if copy_of != label:
            raise ConfigurationError(
                f'bags {copy_of} and {label} are copies of one recording, which would count '
                'twice: give each recording once'
            )
