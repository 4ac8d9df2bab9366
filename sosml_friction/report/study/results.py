# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of the study as files: ``study.json``, ``study.html`` and the figures."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.figure import figures, figures_of
from sosml_friction.report.common.output import (
    OutputKind,
    check_output_folder,
    write_result,
    written_together,
)
from sosml_friction.report.study.document import FORMAT
from sosml_friction.report.study.html import render_study
from sosml_friction.study.run import Study


def _kind() -> OutputKind:
    """Return what a study writes: its document, its report, a file for each figure."""
    drawn = (f'{figure.identifier}.png' for figure in figures('study'))
    files = ('study.json', 'study.html', *drawn)
    return OutputKind('study', 'study.json', FORMAT, files, 'study.html')


def check_study_destination(folder: str | Path) -> Path:
    """
    Return ``folder`` if a study may be written there: it is absent, empty, or holds a study.

    :raises ConfigurationError: if it is a file or holds something else.
    """
    return check_output_folder(folder, _kind())


def write_study(
    folder: str | Path,
    study: Study,
    document: Mapping[str, Any],
    progress: Callable[[str], None] = lambda name: None,
) -> Path:
    """
    Write the document, the report and the figures of the cases that were run; return the folder.

    They appear together; an earlier study is replaced, other files beside it are kept.

    :param document: of :func:`~sosml_friction.report.study.document.study_document`.
    :param progress: called with the name of each figure before it is drawn.
    :raises ConfigurationError: if the folder holds something else or cannot be written.
    """
    folder = check_study_destination(folder)
    with written_together(folder, _kind()) as workshop:
        drawn = {}
        for figure in figures_of('study', study):
            name = figure.identifier
            progress(name)
            drawn[name] = to_png(figure.draw(study))
            (workshop / f'{name}.png').write_bytes(drawn[name])
        write_result(workshop, _kind(), document, render_study(study, drawn))
    return folder
