# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of the study as files: ``study.json``, ``study.html`` and the figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.output import (
    OutputKind,
    check_output_folder,
    write_document,
    written_together,
)
from sosml_friction.report.study.document import FORMAT
from sosml_friction.report.study.figures import FIGURES, available_figures, draw
from sosml_friction.report.study.html import render_study
from sosml_friction.study.run import Study

_KIND = OutputKind(
    'study', 'study.json', FORMAT, ('study.json', 'study.html', *(f'{f}.png' for f in FIGURES))
)


def check_study_destination(folder: str | Path) -> Path:
    """
    Return ``folder`` if a study may be written there: it is absent, empty, or holds a study.

    :raises ConfigurationError: if it is a file or holds something else.
    """
    return check_output_folder(folder, _KIND)


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
    with written_together(folder, _KIND) as workshop:
        pictures = {}
        for name in available_figures(study):
            progress(name)
            pictures[name] = to_png(draw(study, name))
            (workshop / f'{name}.png').write_bytes(pictures[name])
        (workshop / 'study.html').write_text(render_study(study, pictures), encoding='utf-8')
        write_document(workshop, _KIND, document)
    return folder
