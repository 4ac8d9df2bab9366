# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of a fit as files: model folder, report and ``fit.json``."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.identification.fitted_model import preferred_observer, unusable_reason
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.identification.several.consolidation import JOINT, Consolidated
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common import output
from sosml_friction.report.fit.consolidation_view import bags_joints
from sosml_friction.report.fit.html import render_bags_report, render_report
from sosml_friction.report.fit.joint_view import JointView, joint_views
from sosml_friction.report.fit.segment_rows import segments_csv

FORMAT = 'sosml_friction/fit/1'
#: What is said of the law of a joint that has no fit to all recordings at once.
_NO_FIT: dict[str, Any] = {
    'derived': {}, 'checks': [], 'relative_error': None, 'residual_std': None, 'pairs': 0,
    'clusters': 0,
}  # fmt: skip
KIND = output.OutputKind(
    'fit',
    'fit.json',
    FORMAT,
    ('robot.urdf', 'model.yaml', 'report.html', 'fit.json', 'segments.csv'),
)


def fit_document(
    analysis: BagAnalysis | BagsAnalysis, truth: RobotModelFile | None = None
) -> dict[str, Any]:
    """
    Return the object of ``sosml fit --json``; its schema is ``docs/schema/fit.schema.json``.

    What is not known is None. Of several bags ``joints.<joint>.<observer>`` is what all say
    together; ``bags`` has the fits of each, and ``consolidation`` all of how they were put
    together.

    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    if isinstance(analysis, BagsAnalysis):
        return _bags_document(analysis, truth)
    views = joint_views(analysis, truth)
    known = analysis.model.provenance
    provenance = {k: v for k, v in known.items() if k not in ('fits', 'unavailable')}
    document: dict[str, Any] = {
        'format': FORMAT,
        'bag': provenance.get('bag'),
        'bags': [_recording(str(provenance.get('bag')), analysis)],
        **_own_fits(analysis, views),
        'model': {
            name: observer
            for name, joint in analysis.model.joints.items()
            if joint.friction is not None
            and (observer := preferred_observer(analysis.fit.joints.get(name, {})))
        },
        'provenance': provenance,
    }
    if truth is not None:
        document['truth'] = _truth({view.name: view.truth for view in views if view.truth})
    return to_plain(document)


def _bags_document(analysis: BagsAnalysis, truth: RobotModelFile | None) -> dict[str, Any]:
    consolidation = analysis.consolidation
    provenance = {k: v for k, v in analysis.model.provenance.items() if k != 'consolidation'}
    bags = []
    for label, one in analysis.bags.items():
        views = joint_views(one, truth)
        entry = {**_recording(label, one), 'role': consolidation.roles[label].role}
        bags.append({**entry, **_own_fits(one, views)})
    document: dict[str, Any] = {
        'format': FORMAT,
        'bag': ', '.join(analysis.bags),
        'bags': bags,
        'joints': {
            joint: {observer: _consolidated(entry) for observer, entry in entries.items()}
            for joint, entries in consolidation.joints.items()
        },
        'alternatives': {},
        'unavailable': {**consolidation.unavailable, **_unmodelled(analysis)},
        'model': {
            joint: observer
            for joint, observer in consolidation.model.items()
            if analysis.model.joints[joint].friction is not None
        },
        'provenance': provenance,
        'consolidation': consolidation,
    }
    if truth is not None:
        joints = analysis.model.joints
        known = {n: j.friction for n, j in truth.joints.items() if j.friction and n in joints}
        document['truth'] = _truth(known)
    return to_plain(document)


def _unmodelled(analysis: BagsAnalysis) -> dict[str, str]:
    """Return why a joint that was fitted to all recordings has no friction in the model."""
    apart = analysis.consolidation
    return {
        joint: unusable_reason(apart.joints[joint][observer].parameters)
        for joint, observer in apart.model.items()
        if analysis.model.joints[joint].friction is None
    }


def _recording(label: str, analysis: BagAnalysis) -> dict[str, Any]:
    provenance = analysis.model.provenance
    known = ('sha256', 'start_ns', 'end_ns', 'samples', 'recovered', 'versions')
    return {'label': label, **{key: provenance[key] for key in known}}


def _own_fits(analysis: BagAnalysis, views: Sequence[JointView]) -> dict[str, Any]:
    """Return what one recording says alone."""
    entry: dict[str, Any] = {
        'joints': {view.name: view.fits for view in views if view.fits},
        'alternatives': {view.name: view.alternatives for view in views if view.fits},
        'unavailable': {**analysis.fit.unavailable, **analysis.unmodelled},
    }
    body = analysis.body
    found = {
        'inverse_model': analysis.inverse,
        'output_error': analysis.output_error,
        'rigid_body': body if body is not None and body.deviations else None,
        'armature': body.armature if body is not None and body.armature else None,
        'ripple': analysis.ripple or None,
        'data_checks': analysis.data_checks,
    }
    return entry | {name: one for name, one in found.items() if one is not None}


def _consolidated(entry: Consolidated) -> dict[str, Any]:
    """Return the preferred law of a joint in the form of a fit."""
    fit = entry.joint_fit if entry.preferred == JOINT else None
    rejected = [bool(s.rejected) for f in entry.fits.values() for s in f.segments]
    own = _NO_FIT if fit is None else fit.to_dict()
    return {
        'method': 'consolidated',
        **own,
        'law': entry.law,
        'parameters': entry.parameters,
        'residual_unit': entry.unit,
        'segments_used': rejected.count(False),
        'segments_rejected': rejected.count(True),
    }


def _truth(joints: Mapping[str, FrictionParameters]) -> dict[str, Any]:
    return {
        joint: {n: {'value': p.value, 'unit': p.unit} for n, p in friction.parameters.items()}
        for joint, friction in joints.items()
    }


def figure_views(
    analysis: BagAnalysis | BagsAnalysis, truth: RobotModelFile | None = None
) -> Iterator[tuple[str, dict[str, object]]]:
    """Yield a report and what its figures draw, by the names that their files begin with."""
    if not isinstance(analysis, BagsAnalysis):
        yield 'fit', {view.name: view for view in joint_views(analysis, truth)}
        return
    yield 'bags', {**bags_joints(analysis, truth)}
    for bag, one in analysis.bags.items():
        yield 'fit', {f'{bag}_{view.name}': view for view in joint_views(one, truth)}


def write_results(
    folder: str | Path,
    analysis: BagAnalysis | BagsAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
    beside: Collection[str] = (),
) -> Path:
    """
    Write the model folder, ``report.html``, ``fit.json`` and ``segments.csv``; return the folder.

    They are made beside the folder and moved there together: an interruption leaves what was
    there before. The fit of an earlier run is replaced, other files beside it are kept.

    :param extra: more rows of provenance for the report, heading to text.
    :param progress: called with the name of each joint before its pictures are drawn.
    :param beside: see :func:`~sosml_friction.report.common.output.check_output_folder`.
    :raises ConfigurationError: if the folder holds something else or cannot be written.
    """
    folder = output.check_output_folder(folder, KIND, beside)
    if isinstance(analysis, BagsAnalysis):
        page, bags = render_bags_report(analysis, truth, extra, progress), dict(analysis.bags)
    else:
        page = render_report(analysis, truth, extra, progress)
        bags = {str(analysis.model.provenance.get('bag')): analysis}
    document = fit_document(analysis, truth)
    with output.written_together(folder, KIND) as workshop:
        analysis.model.write(workshop)
        output.write_result(workshop, KIND, document, page)
        table = segments_csv({label: joint_views(one) for label, one in bags.items()})
        (workshop / 'segments.csv').write_text(table, encoding='utf-8')
    return folder
