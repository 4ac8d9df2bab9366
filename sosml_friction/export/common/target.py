# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of export targets: what a program can hold of a model, and how."""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.holding import HeldJoint, hold
from sosml_friction.export.common.motion import KnownMotion
from sosml_friction.model.known_terms import read_term
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Z_95, Parameter
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS
from sosml_friction.registry import Registry

NO_MOTION = KnownMotion('no motion')


class Entry(NamedTuple):
    """Hold one parameter of a model: of which term, in which joint (``*`` for all)."""

    joint: str
    term: str
    name: str
    parameter: Parameter


def entries(model: RobotModelFile) -> Iterator[Entry]:
    """Yield every parameter of a model's terms, the laws' first."""
    for term in (*model.law_terms(), *model.effects):
        for name, parameter in term.parameters.items():
            yield Entry(term.joint, term.effect, name, parameter)


def interval_text(p: Parameter) -> str:
    """Return value, 95 % interval and unit; the interval alone where there is no value."""
    interval = p.interval
    if interval is None and math.isfinite(p.std_error):
        interval = (p.value - Z_95 * p.std_error, p.value + Z_95 * p.std_error)
    shown = f'{p.value:.6g}' if math.isfinite(p.value) else 'not known'
    if interval is not None:
        shown += f' [{interval[0]:.6g}, {interval[1]:.6g}]'
    return shown if p.unit == '1' else f'{shown} {p.unit}'


class ExportTarget(ABC):
    """
    Write a model in the form of one program.

    ``identifier``: as in ``sosml export --to``; ``file``: name of the file that is written.
    A term says by ``Term.held_by`` which targets can hold it; one that holds all says so here,
    and one that has a field for the armature.

    :param motion: on which constants stand in for what is lost, and its error is measured.
    :param base: a file of the program whose joints get the model, where a target takes one.
    """

    identifier: ClassVar[str]
    file: ClassVar[str]
    holds_all: ClassVar[bool] = False
    holds_armature: ClassVar[bool] = False
    takes_base: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        TARGETS.add(cls)

    def __init__(self, motion: KnownMotion = NO_MOTION, base: Path | None = None) -> None:
        if base is not None and not self.takes_base:
            raise ConfigurationError(f'{self.identifier} takes no --mjcf: leave it out')
        self.motion, self.base = motion, base

    def lost(self, model: RobotModelFile) -> list[str]:
        """Return what the target cannot hold of a model, a sentence part for each term."""
        if self.holds_all:
            return []
        found = dict.fromkeys((e.joint, e.term) for e in entries(model) if not self._holds(e))
        rotors = [
            f'armature of {n}'
            for n, joint in model.joints.items()
            if joint.armature.value != 0.0 and not self.holds_armature
        ]
        terms = [f'{term} of {"all joints" if joint == "*" else joint}' for joint, term in found]
        return terms + rotors

    def losses(self, model: RobotModelFile) -> list[str]:
        """Return what the loss costs in each joint, a sentence without full stop for each."""
        if self.holds_all:
            return []
        said = [own.sentence(name, self.motion.on) for name, own in self.held(model).items()]
        said += [
            self.motion.other_sentence(model, known)
            for entry in model.effects
            for known in read_term(entry, model)
            if not isinstance(known.term, EffortTerm)
        ]
        if not self.holds_armature:
            said += [self.motion.rotor_sentence(model, name) for name in model.joints]
        return [one for one in said if one]

    def held(self, model: RobotModelFile) -> Mapping[str, HeldJoint]:
        """Return what the target is given for each joint."""
        gone = {(e.joint, e.term) for e in entries(model) if not self._holds(e)}
        return hold(model, self.motion, lambda joint, term: (joint, term) not in gone)

    def notes(self, model: RobotModelFile) -> list[str]:
        """Return the lines of a comment: where it is from, each parameter's interval, losses."""
        lost = ', '.join(self.lost(model)) or 'nothing'
        return [
            f'Written by sosml export to {self.identifier}, model {model.name}; 95 % intervals:',
            *(
                f'{e.joint} {e.term} {e.name}: {interval_text(e.parameter)}'
                for e in entries(model)
            ),
            *(
                f'{name} armature: {interval_text(joint.armature)}'
                for name, joint in model.joints.items()
            ),
            f'Lost: {lost}.',
            *(f'{said}.' for said in self.losses(model)),
        ]

    def _holds(self, entry: Entry) -> bool:
        # An offset of nothing is nothing to lose; what is no term is no part of the robot.
        nothing = entry.name == 'bias' and entry.parameter.value == 0.0
        if nothing or entry.term in DATA_CAUSES:
            return True
        return self.identifier in TERMS[entry.term].held_by

    @abstractmethod
    def text(self, model: RobotModelFile) -> str:
        """
        Return the content of the file.

        :raises ConfigurationError: if the model lacks what the target needs.
        """


TARGETS: Registry[ExportTarget] = Registry('export target', 'sosml_friction.export')
