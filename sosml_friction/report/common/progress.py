# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The progress bar of the tool, on stderr and only where a person watches."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn


class Step(Protocol):
    """Say what is being done now, and if that is known which share of it is done, 0..1."""

    def __call__(self, what: str, share: float | None = None) -> None:
        """Change the line."""


@contextmanager
def progress(what: str) -> Iterator[Step]:
    """
    Show on a terminal what is being done and for how long, and remove it at the end.

    Yields a function that changes the line. Where stderr is no terminal nothing is printed.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda what, share=None: None
        return
    with Progress(
        TextColumn('{task.description}', markup=False),
        BarColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
    ) as bar:
        task = bar.add_task(what, total=None)

        def step(what: str, share: float | None = None) -> None:
            total = None if share is None else 1.0
            bar.update(task, description=what, total=total, completed=share or 0.0)

        yield step
