# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The motion on which a target's constants are fitted and its losses are measured."""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.controllers import PD, read_controllers
from sosml_friction.bags.recorded_robot import read_recorded_robot
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.tracking import Law
from sosml_friction.export.common.tracking import Path as Moved
from sosml_friction.model.known_terms import KnownTerm
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare

#: Speeds of a motion that is not known, evenly from none to the limit.
_SPEEDS = 200


@dataclass(frozen=True)
class KnownMotion:
    """
    Hold where and how the joints moved.

    ``stretches``: of a recording, or none; ``speeds``: of joints [rad/s or m/s] where velocities
    are all that is known; ``on``: what it is, for a sentence; ``gains``: kp and kd of joints
    whose controller was recorded.
    """

    on: str
    stretches: tuple[Signals, ...] = ()
    speeds: Mapping[str, FloatArray] | None = None
    gains: Mapping[str, tuple[float, float]] | None = None

    def knows(self, joint: str) -> bool:
        """Tell whether a joint is known to have moved."""
        return bool(self.stretches) or joint in (self.speeds or {})

    def steady(self, name: str, terms: list[KnownTerm]) -> FloatArray | None:
        """Return the effort (N, terms) at :attr:`speeds`; None if a term takes more than these."""
        v = (self.speeds or {})[name]
        motion = Motion.steady(v[:, None], np.sign(v)[:, None])
        found = []
        for known in terms:
            if not known.term.of_law or not isinstance(known.term, EffortTerm):
                return None
            own = known.term.effort(motion, 0, known.inner, np.zeros((len(v), 0)))
            sizes = zip(known.amplitude, own, strict=True)
            found.append(np.asarray(sum(float(x) * part for x, part in sizes)))
        return np.column_stack(found)

    def paths(self, joint: int, name: str) -> list[Moved]:
        """Return how a joint moved, a stretch each."""
        return [
            Moved(
                np.ascontiguousarray(s.q[:, joint]),
                np.ascontiguousarray(s.v[:, joint]),
                np.ascontiguousarray(s.a[:, joint]),
                s.band.step,
                float(s.robot.inertia(np.median(s.q, axis=0))[joint, joint]),
                (self.gains or {}).get(name),
            )
            for s in self.stretches
        ]

    def laws(self, joint: int, terms: list[KnownTerm]) -> list[Law]:
        """Return the friction of some terms of a joint, along each stretch."""
        return [_law(s, joint, terms) for s in self.stretches]

    def other_sentence(self, model: RobotModelFile, known: KnownTerm) -> str:
        """Return what the loss of a term costs that is no friction: of bodies, report, gear."""
        name = known.term.identifier
        if not self.stretches:
            return f'what {name} would cost is not known, as it takes the motion: give a recording'
        parts = [
            known.term.columns(s, known.joint, known.inner) @ known.amplitude
            for s in self.stretches
        ]
        sizes = np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0))
        told = ', '.join(
            f'{joint} {size:.3g} {"Nm" if own.armature.unit == "kg m2" else "N"}'
            for (joint, own), size in zip(model.joints.items(), sizes, strict=True)
            if size > 0.0
        )
        return f'without {name} the effort is wrong by {told} rms on {self.on}'

    def rotor_sentence(self, model: RobotModelFile, name: str) -> str:
        """Return what the loss of a joint's armature costs, '' where that is not known or none."""
        rotor = model.joints[name].armature
        if not self.stretches or not rotor.value > 0.0:
            return ''
        i = model.joint_names.index(name)
        needed = rotor.value * np.concatenate([s.a[:, i] for s in self.stretches])
        unit = 'Nm' if rotor.unit == 'kg m2' else 'N'
        return (
            f'{name}: without its armature the effort is wrong by '
            f'{np.sqrt(np.mean(needed**2)):.3g} {unit} rms on {self.on}'
        )


def _law(s: Signals, joint: int, terms: list[KnownTerm]) -> Law:
    top = 2.0 * float(np.abs(s.v[:, joint]).max())
    v = Law.speeds(top)
    along, over = np.zeros((2, len(s.q))), np.zeros((2, len(v)))
    for known in terms:
        for k, sign in enumerate((1.0, -1.0)):
            if known.term.of_law and isinstance(known.term, EffortTerm):
                motion = Motion.steady(v[:, None], np.full((len(v), 1), sign))
                own = known.term.effort(motion, 0, known.inner, np.zeros((len(v), 0)))
                over[k] += sum(float(x) * y for x, y in zip(known.amplitude, own, strict=True))
            else:
                moved = replace(s, sign=np.full_like(s.sign, sign), cache={})
                columns = known.term.columns(moved, known.joint, known.inner)
                along[k] += columns[:, joint] @ known.amplitude
    level, both = 0.5 * (along[0] - along[1]), 0.5 * (along[0] + along[1])
    return Law(level, both, 0.5 * (over[0] - over[1]), 0.5 * (over[0] + over[1]), top)


def recorded_motion(model: RobotModelFile, bag: Path) -> KnownMotion:
    """
    Return the motion in a bag.

    :raises BagError: if it cannot be read.
    :raises ConfigurationError: if the model has no URDF and neither has the bag, an armature is
        not known, or a joint was not recorded.
    :raises DataError: if no stretch is long enough.
    """
    recorded = read_recorded_robot(bag, model, own_urdf=model.urdf is not None)
    nominal = replace(recorded.nominal, effects=())
    robot = recorded.robot
    if robot.names != model.joint_names:
        raise ConfigurationError(
            f'{bag} has not all joints of model {model.name}, which are '
            f'{", ".join(model.joint_names)}: give another recording'
        )
    found = prepare([recorded.log.select(robot.names)], nominal, robot, DiagnosisSettings())
    gains = {
        name: (float(entry['kp']), float(entry['kd']))
        for name, entry in read_controllers(recorded.bag).items()
        if entry['kind'] == PD
    }
    return KnownMotion(f'the motion in {bag.name}', tuple(found), gains=gains)


def assumed_motion(model: RobotModelFile, folder: Path) -> KnownMotion:
    """Return the velocities that a fit used, else all up to the URDF's limits, else nothing."""
    table = (folder if folder.is_dir() else folder.parent) / 'segments.csv'
    if table.is_file():
        speeds: dict[str, list[float]] = {}
        with table.open(newline='', encoding='utf-8') as stream:
            for row in csv.DictReader(stream):
                if row.get('used') == 'yes' and row.get('velocity'):
                    speeds.setdefault(row['joint'], []).append(float(row['velocity']))
        if speeds:
            own = {name: np.array(v) for name, v in speeds.items()}
            return KnownMotion('the velocities that the fit used', speeds=own)
    stated = {} if model.urdf is None else read_joints(model.urdf).joints
    limits = {
        name: joint.limits.velocity
        for name, joint in stated.items()
        if name in model.joints and math.isfinite(joint.limits.velocity)
    }
    spread = np.linspace(1.0 / _SPEEDS, 1.0, _SPEEDS)
    both = np.concatenate([-spread, spread])
    return KnownMotion(
        "all velocities up to the URDF's limits, as no motion is known",
        speeds={name: top * both for name, top in limits.items() if top > 0.0},
    )
