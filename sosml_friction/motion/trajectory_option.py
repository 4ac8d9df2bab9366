# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One number, or list of numbers, that a trajectory is made from."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.exceptions import TrajectoryError

Value = int | float | tuple[float, ...]


@dataclass(frozen=True)
class TrajectoryOption:
    """
    Describe an option: ``name`` for people, ``keyword`` of the function that takes it.

    The type is that of ``default``: int, float or a tuple of numbers. ``range`` is inclusive and
    holds for each number.
    """

    name: str
    keyword: str
    default: Value
    description: str
    unit: str = ''
    range: tuple[float, float] | None = None

    @property
    def type(self) -> str:
        """Return the name that ROS has for the type."""
        if isinstance(self.default, tuple):
            return 'double_array'
        return 'integer' if isinstance(self.default, int) else 'double'

    def parse(self, text: str) -> Value:
        """
        Read the value from text, a list with commas.

        :raises TrajectoryError: as :meth:`check`.
        """
        try:
            if isinstance(self.default, tuple):
                return self.check([float(part) for part in text.split(',')])
            return self.check(int(text) if isinstance(self.default, int) else float(text))
        except ValueError as error:
            kind = {'double_array': 'numbers with commas', 'integer': 'a whole number'}
            raise TrajectoryError(
                f'{self.name} is {text!r}: give {kind.get(self.type, "a number")}'
            ) from error

    def check(self, value: float | Sequence[float]) -> Value:
        """
        Return the value in the type of the default.

        :raises TrajectoryError: if it has another type, is not finite or out of range.
        """
        numbers = np.atleast_1d(np.asarray(value, dtype=float))
        low, high = self.range or (-np.inf, np.inf)
        if self.default and not numbers.size:
            raise TrajectoryError(f'{self.name} is empty: give at least one number')
        if not (np.isfinite(numbers) & (numbers >= low) & (numbers <= high)).all():
            limits = f' from {low:g} to {high:g}' if self.range else ''
            raise TrajectoryError(f'{self.name} is {value}: give finite numbers{limits}')
        if isinstance(self.default, tuple):
            return tuple(numbers.tolist())
        if np.ndim(value) or (isinstance(self.default, int) and value != int(numbers[0])):
            kind = 'a whole number' if isinstance(self.default, int) else 'one number'
            raise TrajectoryError(f'{self.name} is {value}: give {kind}')
        return int(numbers[0]) if isinstance(self.default, int) else float(numbers[0])


#: Name, keyword, description, unit and range of an option.
Row = tuple[str, str, str, str, tuple[float, float]]

#: Units and ranges that several trajectories have.
SPEED, WAY = 'rad/s or m/s', 'rad or m'
SPEEDS, WAYS = (1e-4, 100.0), (1e-5, 100.0)
PLATEAU: Row = ('plateau', 'plateau_s', 'length of a plateau', 's', (0.1, 60.0))
RAMP: Row = ('ramp', 'ramp_s', 'length of a ramp to or from a plateau', 's', (0.02, 10.0))
TURN: Row = ('turn', 'turn_s', 'from one speed to the opposite one', 's', (0.04, 20.0))
TOP: Row = ('top_speed', 'top_speed', 'limit of the moves between pieces', SPEED, (1e-3, 100.0))


def options_of(function: Callable[..., Any], *rows: Row) -> tuple[TrajectoryOption, ...]:
    """Return options with the defaults that ``function`` has for their keywords."""
    parameters = inspect.signature(function).parameters
    return tuple(
        TrajectoryOption(name, keyword, parameters[keyword].default, description, unit, limits)
        for name, keyword, description, unit, limits in rows
    )
