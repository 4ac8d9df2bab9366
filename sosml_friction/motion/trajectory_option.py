# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One number, or list of numbers, that a trajectory is made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
        if not (np.isfinite(numbers) & (numbers >= low) & (numbers <= high)).all():
            limits = f' from {low:g} to {high:g}' if self.range else ''
            raise TrajectoryError(f'{self.name} is {value}: give finite numbers{limits}')
        if isinstance(self.default, tuple):
            return tuple(numbers.tolist())
        if np.ndim(value) or (isinstance(self.default, int) and value != int(numbers[0])):
            kind = 'a whole number' if isinstance(self.default, int) else 'one number'
            raise TrajectoryError(f'{self.name} is {value}: give {kind}')
        return int(numbers[0]) if isinstance(self.default, int) else float(numbers[0])
