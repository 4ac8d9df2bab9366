# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of a fit as files: model folder, report and ``fit.json``."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.html import write_report
from sosml_friction.report.joint_view import JointView, joint_views

FORMAT = 'sosml_friction/fit/1'
FILES = ('robot.urdf', 'model.yaml', 'report.html', 'fit.json')


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


def to_plain(value: Any) -> Any:
    """Return the same in plain Python types, a number that is not finite as None."""
    if isinstance(value, Mapping):
        return {str(key): to_plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [to_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return to_plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def to_json(document: Mapping[str, Any]) -> str:
    """Return the JSON text of a document, without NaN."""
    return json.dumps(to_plain(document), indent=2, ensure_ascii=False, allow_nan=False)


def check_destination(folder: str | Path, beside: Collection[str] = ()) -> Path:
    """
    Return ``folder`` if results may be written there: it is absent, empty, or holds a fit.

    :param beside: names in the folder that may be there all the same.
    :raises ConfigurationError: if it is a file or holds something else.
    """
    folder = Path(folder)
    try:
        if not folder.exists():
            return folder
        if folder.is_dir() and (
            {path.name for path in folder.iterdir()} <= set(beside) or _is_fit(folder / 'fit.json')
        ):
            return folder
    except OSError as error:
        raise ConfigurationError(
            f'{folder} cannot be read: {error.strerror}: choose another place with --out'
        ) from error
    raise ConfigurationError(
        f'{folder} exists and is not the result of an earlier fit, so it is not overwritten: '
        'choose another place with --out'
    )


def _is_fit(file: Path) -> bool:
    try:
        document = json.loads(file.read_text(encoding='utf-8'))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and document.get('format') == FORMAT


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
    existing = folder.absolute().parent
    while not existing.exists():
        existing = existing.parent
    try:
        workshop = Path(tempfile.mkdtemp(prefix='.sosml_fit_', dir=existing))
    except OSError as error:
        raise _refused(folder, error) from error
    try:
        analysis.model.write(workshop)
        write_report(workshop / 'report.html', analysis, truth, extra, progress)
        text = to_json(fit_document(analysis, truth))
        (workshop / 'fit.json').write_text(text + '\n', encoding='utf-8')
        with _uninterrupted():
            folder.mkdir(parents=True, exist_ok=True)
            for name in FILES:
                os.replace(workshop / name, folder / name)
    except OSError as error:
        raise _refused(folder, error) from error
    finally:
        shutil.rmtree(workshop, ignore_errors=True)
    return folder


def _refused(folder: Path, error: OSError) -> ConfigurationError:
    return ConfigurationError(
        f'{folder} cannot be written: {error.strerror}: choose another place with --out'
    )


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait until the files are in their place."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
