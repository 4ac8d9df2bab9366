# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A figure of a report: defining its class puts it into the report."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, get_args

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.registry import import_folder
from sosml_friction.report import figures as folder
from sosml_friction.report.common.html_page import picture
from sosml_friction.report.common.svg import to_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

View = TypeVar('View')
#: Where in its report a figure is: beside the answer, after it, or folded with the methods.
SUMMARY, DETAIL, METHOD = 'summary', 'detail', 'method'
REPORTS = ('fit', 'bags', 'diagnosis', 'study', 'simulation', 'terms')
_SAID = ('identifier', 'title', 'report', 'order', 'caption')


class Figure(ABC, Generic[View]):
    """
    Is the base of every figure; a subclass is in the report that it names as soon as it exists.

    ``Figure[X]`` draws an X: a joint, a diagnosis, a study. A new figure is one file in
    ``report/figures/<report>``, or a class anywhere else.
    """

    _defined: ClassVar[list[type[Figure[Any]]]] = []
    _of: ClassVar[type]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Remember the class, and what it draws."""
        super().__init_subclass__(**kwargs)
        Figure._defined.append(cls)
        for base in cls.__dict__.get('__orig_bases__', ()):
            cls._of = get_args(base)[0]

    #: Of the figure within its report, and of its file where it is written to one.
    identifier: ClassVar[str]
    #: In a few words what it shows.
    title: ClassVar[str]
    #: One of :data:`REPORTS`.
    report: ClassVar[str]
    #: Its place among the figures of the same thing, the smallest first.
    order: ClassVar[int]
    #: The text below the figure; it may have fields such as ``{view.name}``.
    caption: ClassVar[str]
    #: :data:`SUMMARY`, :data:`DETAIL` or :data:`METHOD`.
    part: ClassVar[str] = DETAIL
    #: Whether its colours follow the page; a map of colours keeps its own, on white.
    themed: ClassVar[bool] = True

    def caption_of(self, view: View) -> str:
        """Return the caption for what is drawn."""
        return self.caption.format(view=view)

    def applies(self, view: View) -> bool:
        """Tell whether there is anything to draw."""
        return True

    @abstractmethod
    def draw(self, view: View) -> Drawing:
        """Return the figure; only where it :meth:`applies`."""

    def html(self, view: View, drawn: Drawing | None = None) -> str:
        """Return the figure with its caption as HTML; ``drawn`` where it was drawn already."""
        caption = self.caption_of(view)
        svg = to_svg(drawn or self.draw(view), caption, self.themed)
        return picture(svg, caption, self.title)


def figures(report: str) -> list[Figure[Any]]:
    """
    Return the figures of a report in their order.

    :raises ConfigurationError: if there is no such report, a figure does not say all that it
        has to, or two have one identifier.
    """
    _require_report(report)
    import_folder(f'{folder.__name__}.{report}')
    found: dict[str, Figure[Any]] = {}
    for figure in _finished():
        _require_report(figure.report)
        if figure.report != report:
            continue
        if figure.identifier in found:
            raise ConfigurationError(f'report {report} has two figures {figure.identifier}')
        found[figure.identifier] = figure
    return sorted(found.values(), key=lambda figure: (figure.order, figure.identifier))


def _finished() -> Iterator[Figure[Any]]:
    """Yield one of each class that says all that it has to; bases of others are no figures."""
    for cls in Figure._defined:
        missing = sorted({*cls.__abstractmethods__, *(n for n in _SAID if not hasattr(cls, n))})
        if not isinstance(getattr(cls, '_of', None), type):
            missing.append('class to draw, as in Figure[JointView]')
        if not missing:
            yield cls()
        elif 'identifier' not in missing:
            raise ConfigurationError(f'figure {cls.__name__} has no {", ".join(missing)}')


def _require_report(name: str) -> None:
    if name not in REPORTS:
        raise ConfigurationError(f'no report {name}: there are {", ".join(REPORTS)}')


def figures_of(report: str, view: object) -> list[Figure[Any]]:
    """Return the figures of a report that have something to show of a view."""
    return [
        figure
        for figure in figures(report)
        if isinstance(view, figure._of) and figure.applies(view)
    ]


def pictures(report: str, view: object, part: str = DETAIL) -> str:
    """Return the figures of a part as HTML; each is drawn, encoded and forgotten by itself."""
    return ''.join(figure.html(view) for figure in figures_of(report, view) if figure.part == part)
