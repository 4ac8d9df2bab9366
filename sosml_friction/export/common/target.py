# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of export targets: what a program can hold of a model, and how."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, NamedTuple

from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS
from sosml_friction.registry import Registry


class Entry(NamedTuple):
    """Hold one parameter of a model: of which term, in which joint (``*`` for all)."""

    joint: str
    term: str
    name: str
    parameter: Parameter


def entries(model: RobotModelFile) -> Iterator[Entry]:
    """Yield every parameter of a model's terms, the laws' first."""
    for joint, own in model.joints.items():
        for term, parameters in [] if own.friction is None else own.friction.by_term():
            for name, parameter in parameters.items():
                yield Entry(joint, term, name, parameter)
    for effect in model.effects:
        for name, parameter in effect.parameters.items():
            yield Entry(effect.joint, effect.effect, name, parameter)


class ExportTarget(ABC):
    """
    Write a model in the form of one program.

    ``identifier``: as in ``sosml export --to``; ``file``: name of the file that is written.
    A term says by ``Term.held_by`` which targets can hold it; one that holds all says so here.
    """

    identifier: ClassVar[str]
    file: ClassVar[str]
    holds_all: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        TARGETS.add(cls)

    def lost(self, model: RobotModelFile) -> list[str]:
        """Return what the target cannot hold of a model, a sentence part for each term."""
        if self.holds_all:
            return []
        found = dict.fromkeys((e.joint, e.term) for e in entries(model) if not self._holds(e))
        return [f'{term} of {"all joints" if joint == "*" else joint}' for joint, term in found]

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
