# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A figure of a report: defining its class puts it into the report."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, TypeVar

from matplotlib.figure import Figure as Drawing

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.report import figures as folder
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.html_page import picture

View = TypeVar('View')
REPORTS = ('fit', 'bags', 'diagnosis', 'study', 'simulation')


class Figure(ABC, Generic[View]):
    """
    Is the base of every figure; a subclass is in the report that it names as soon as it exists.

    A new figure is one file in ``report/figures/<report>``, or a class anywhere else.
    """

    _defined: ClassVar[list[type[Figure[Any]]]] = []

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Remember the class."""
        super().__init_subclass__(**kwargs)
        Figure._defined.append(cls)

    @property
    @abstractmethod
    def identifier(self) -> str:
        """Name the figure within its report, and its file where it is written to one."""

    @property
    @abstractmethod
    def title(self) -> str:
        """Say in a few words what the figure shows."""

    @property
    @abstractmethod
    def report(self) -> str:
        """Name one of :data:`REPORTS`."""

    @property
    @abstractmethod
    def of(self) -> type[View]:
        """Return the class of what is drawn: one joint, one study, ..."""

    @property
    @abstractmethod
    def order(self) -> int:
        """Return the place among the figures of the same thing, the smallest first."""

    @abstractmethod
    def caption(self, view: View) -> str:
        """Return the text below the figure."""

    def applies(self, view: View) -> bool:
        """Tell whether there is anything to draw."""
        return True

    @abstractmethod
    def draw(self, view: View) -> Drawing:
        """Return the figure; only where it :meth:`applies`."""

    def html(self, view: View) -> str:
        """Return the figure with its caption as HTML, the picture inside."""
        return picture(to_png(self.draw(view)), self.caption(view), self.title)


def figures(report: str) -> list[Figure[Any]]:
    """
    Return the figures of a report in their order.

    :raises ConfigurationError: if there is no such report, or two figures have one identifier.
    """
    if report not in REPORTS:
        raise ConfigurationError(f'no report {report}: there are {", ".join(REPORTS)}')
    package = importlib.import_module(f'{folder.__name__}.{report}')
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f'{package.__name__}.{module.name}')
    found: dict[str, Figure[Any]] = {}
    for one in (cls() for cls in Figure._defined if not inspect.isabstract(cls)):
        if one.report != report:
            continue
        if one.identifier in found:
            raise ConfigurationError(f'two figures of the report {report} are {one.identifier}')
        found[one.identifier] = one
    return sorted(found.values(), key=lambda figure: (figure.order, figure.identifier))


def figures_of(report: str, view: object) -> list[Figure[Any]]:
    """Return the figures of a report that have something to show of a view."""
    return [
        figure
        for figure in figures(report)
        if isinstance(view, figure.of) and figure.applies(view)
    ]


def pictures(report: str, view: object) -> str:
    """Return all figures of a view as HTML; each is drawn, encoded and forgotten by itself."""
    return ''.join(figure.html(view) for figure in figures_of(report, view))
