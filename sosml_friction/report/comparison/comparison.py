# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What two models say of the same joints, and where they differ beyond their intervals."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.number_text import (
    UNKNOWN,
    format_number,
    joint_text,
    number_text,
    words,
)
from sosml_friction.identification.parameter_interval import half_width
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.table import FittingTable, terminal_table

FORMAT = 'sosml_friction/compare/1'
#: What is said of a parameter of two models.
DIFFER, AGREE, ONLY_ONE, NO_INTERVAL = 'differ', 'agree', 'only one has it', 'no interval'


class Pair(NamedTuple):
    """Hold one parameter of two models, None where a model does not have it."""

    joint: str
    name: str
    first: Parameter | None
    second: Parameter | None

    @property
    def difference(self) -> float:
        """Return the second minus the first, NaN where one is not known."""
        if self.first is None or self.second is None:
            return math.nan
        return self.second.value - self.first.value

    @property
    def half(self) -> float:
        """
        Return half of the 95 % interval of the difference of independent estimates.

        A model whose number has no interval is taken for exact; NaN where neither has one.
        """
        halves = [half_width(p) for p in (self.first, self.second) if p is not None]
        known = [half for half in halves if math.isfinite(half)]
        return math.hypot(*known) if known else math.nan

    @property
    def verdict(self) -> str:
        """Return :data:`DIFFER`, :data:`AGREE`, :data:`ONLY_ONE` or :data:`NO_INTERVAL`."""
        if self.first is None or self.second is None:
            return ONLY_ONE
        ranges = [p.interval for p in (self.first, self.second) if NOT_IDENTIFIABLE in p.flags]
        if ranges:
            return self._against_range()
        if not math.isfinite(self.half):
            return NO_INTERVAL
        return DIFFER if abs(self.difference) > self.half else AGREE

    def _against_range(self) -> str:
        """Tell whether two ranges, or a range and an interval, have something in common."""
        ends = []
        for p in (self.first, self.second):
            assert p is not None
            half = half_width(p) if p.interval is None else 0.0
            low, high = p.interval or (p.value - half, p.value + half)
            if math.isnan(low) or math.isnan(high):
                return NO_INTERVAL
            ends.append((low, high))
        (a, b), (c, d) = ends
        return AGREE if a <= d and c <= b else DIFFER


def compare_models(first: RobotModelFile, second: RobotModelFile) -> list[Pair]:
    """
    Return every parameter of the joints that two models share.

    :raises ConfigurationError: if they share no joint.
    """
    joints = [name for name in first.joint_names if name in second.joints]
    if not joints:
        raise ConfigurationError(
            f'{first.name} has the joints {", ".join(first.joint_names)} and {second.name} has '
            f'{", ".join(second.joint_names)}: compare models of the same robot'
        )
    found = []
    for joint in [*joints, '*']:
        own = [dict(_parameters(model, joint)) for model in (first, second)]
        names = dict.fromkeys([*own[0], *own[1]])
        found += [Pair(joint, name, *(one.get(name) for one in own)) for name in names]
    return found


def _parameters(model: RobotModelFile, joint: str) -> Iterator[tuple[str, Parameter]]:
    """Yield the parameters of a joint by name, those of a term with the name of the term."""
    if joint in model.joints:
        own = model.joints[joint]
        if own.friction is not None:
            yield from own.friction.parameters.items()
        yield 'armature', own.armature
    for term in model.effects:
        if term.joint == joint:
            for name, p in term.parameters.items():
                yield (name if name == term.effect else f'{term.effect}: {name}'), p


def comparison_document(pairs: list[Pair], first: str, second: str) -> dict[str, Any]:
    """Return the object of ``sosml compare --json``: docs/schema/compare.schema.json."""
    return to_plain(
        {
            'format': FORMAT,
            'first': first,
            'second': second,
            'parameters': [
                {
                    **pair._asdict(),
                    'difference': pair.difference,
                    'half_width': pair.half,
                    'verdict': pair.verdict,
                }
                for pair in pairs
            ],
        }
    )


def comparison_table(pairs: list[Pair], first: str, second: str) -> FittingTable:
    """Return the parameters side by side, the values with half of their 95 % intervals."""
    columns = {'joint': 'w', 'parameter': 'w', 'unit': 'w', first: 'n w', second: 'n w',
               'difference': 'n', 'verdict': 'w'}  # fmt: skip
    rows, last = [], ''
    for pair in pairs:
        shown = [UNKNOWN if p is None else number_text(pair.name, p) for p in pair[2:]]
        unit = next(p.unit for p in (pair.first, pair.second) if p is not None)
        joint = joint_text(pair.joint)
        difference = format_number(pair.difference, pair.half)
        name = words(pair.name)
        rows.append(['' if joint == last else joint, name, unit, *shown, difference, pair.verdict])
        last = joint
    return terminal_table(columns, rows, sections=True)


def comparison_sentence(pairs: list[Pair]) -> str:
    """Return in which parameters the models differ."""
    apart = [f'{pair.name} of {pair.joint}' for pair in pairs if pair.verdict == DIFFER]
    alike = sum(pair.verdict == AGREE for pair in pairs)
    if not apart:
        return f'They agree within their 95 % intervals in all {alike} parameters that have some.'
    return f'They differ beyond their 95 % intervals in {", ".join(apart)}; {alike} agree.'
