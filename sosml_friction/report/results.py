# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of a fit as files: model folder, report and ``fit.json``."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.html import write_report
from sosml_friction.report.joint_view import JointView, joint_views
from sosml_friction.report.output import (
    OutputKind,
    check_output_folder,
    to_json,
    to_plain,
    written_together,
)

FORMAT = 'sosml_friction/fit/1'
FILES = ('robot.urdf', 'model.yaml', 'report.html', 'fit.json')
_KIND = OutputKind('fit', 'fit.json', FORMAT, FILES)


def fit_document(analysis: BagAnalysis, truth: RobotModelFile | None = None) -> dict[str, Any]:
    """
    Return the object of ``sosml fit --json``; its schema is ``docs/schema/fit.schema.json``.

    What is not known is None.

    :param truth: a model whose friction is known to be that of the robot.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    provenance = {k: v for k, v in analysis.model.provenance.items() if k != 'fits'}
    provenance.pop('unavailable', None)
    document: dict[str, Any] = {
        'format': FORMAT,
        'bag': provenance.get('bag'),
        'joints': {view.name: _fits(view.fits) for view in views if view.fits},
        'alternatives': {view.name: _fits(view.alternatives) for view in views if view.fits},
        'unavailable': dict(analysis.fit.unavailable),
        'model': {view.name: view.preferred for view in views if view.preferred},
        'provenance': provenance,
    }
    if truth is not None:
        document['truth'] = {view.name: _truth(view) for view in views if view.truth}
    if analysis.inverse is not None:
        document['inverse_model'] = analysis.inverse.to_dict()
    plain: dict[str, Any] = to_plain(document)
    return plain


def _fits(fits: Mapping[str, JointFit]) -> dict[str, Any]:
    return {observer: fit.to_dict() for observer, fit in fits.items()}


def _truth(view: JointView) -> dict[str, Any]:
    assert view.truth is not None
    return {
        name: {'value': parameter.value, 'unit': parameter.unit}
        for name, parameter in view.truth.parameters.items()
    }


def check_destination(folder: str | Path, beside: Collection[str] = ()) -> Path:
    """
    Return ``folder`` if results may be written there: it is absent, empty, or holds a fit.

    :param beside: names in the folder that may be there all the same.
    :raises ConfigurationError: if it is a file or holds something else.
    """
    return check_output_folder(folder, _KIND, beside)


def write_results(
    folder: str | Path,
    analysis: BagAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
    beside: Collection[str] = (),
) -> Path:
    """
    Write ``robot.urdf``, ``model.yaml``, ``report.html`` and ``fit.json``, and return the folder.

    They are made beside the folder and moved there together: an interruption leaves what was
    there before. The fit of an earlier run is replaced, other files beside it are kept.

    :param truth: a model whose friction is known to be that of the robot.
    :param extra: more rows of provenance for the report, heading to text.
    :param progress: called with the name of each joint before its pictures are drawn.
    :param beside: see :func:`check_destination`.
    :raises ConfigurationError: if the folder holds something else or cannot be written.
    """
    folder = check_destination(folder, beside)
    with written_together(folder, _KIND) as workshop:
        analysis.model.write(workshop)
        write_report(workshop / 'report.html', analysis, truth, extra, progress)
        text = to_json(fit_document(analysis, truth))
        (workshop / 'fit.json').write_text(text + '\n', encoding='utf-8')
    return folder
