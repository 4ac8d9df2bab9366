# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every result offers."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from io import StringIO
from typing import Any

from rich.console import Console, RenderableType

from sosml_friction.model.parameter import Z_95, Parameter

#: Width of tables [characters].
_WIDTH = 100


class Result(ABC):
    """Hold what a function of the Python interface found."""

    @abstractmethod
    def summary(self) -> str:
        """Return the result in sentences and tables, as text."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, strings, lists and mappings, ready for JSON; unknown is None."""

    @abstractmethod
    def _brief(self) -> str:
        """Return the result in less than a line."""

    def __repr__(self) -> str:
        return f'<{type(self).__name__}; {self._brief()}>'


def interval_of(parameter: Parameter) -> tuple[float, float]:
    """Return the 95 % interval, its own or that of the standard error; NaN where none is known."""
    if parameter.interval is not None:
        return float(parameter.interval[0]), float(parameter.interval[1])
    half = Z_95 * parameter.std_error
    return parameter.value - half, parameter.value + half


def blocks_text(blocks: Iterable[str | RenderableType]) -> str:
    """Return sentences, and tables as plain text, no space at the ends of their lines."""
    texts = []
    for block in blocks:
        if not isinstance(block, str):
            stream = StringIO()
            Console(file=stream, width=_WIDTH, highlight=False, color_system=None).print(block)
            block = '\n'.join(line.rstrip() for line in stream.getvalue().rstrip().splitlines())
        texts.append(block)
    return '\n'.join(texts)
