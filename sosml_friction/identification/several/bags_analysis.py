# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From several bags of one robot to one model of its friction."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import ModelSource
from sosml_friction.bags.recordings import read_recordings
from sosml_friction.bags.source import bag_labels
from sosml_friction.exceptions import DataError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.fitted_model import friction_of, preferred_observer
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bag_roles import find_roles, parse_roles
from sosml_friction.identification.several.consolidation import (
    Consolidated,
    Consolidation,
    consolidate,
)
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.plain_document import to_plain

#: What the provenance of a model keeps of each bag.
_KEPT = ('bag', 'sha256', 'start_ns', 'end_ns', 'samples', 'recovered', 'observers')
#: What it keeps of the nominal model.
_OF_MODEL = ('rigid_body', 'effects_left_out')


@dataclass(frozen=True)
class BagsAnalysis:
    """Hold several fitted recordings of one robot by label, together, and the model of that."""

    bags: Mapping[str, BagAnalysis]
    consolidation: Consolidation
    model: RobotModelFile


def analyse_bags(
    paths: Sequence[str | Path],
    model: ModelSource = None,
    urdf: str | Path | None = None,
    settings: FitSettings | None = None,
    bandwidth: float | None = None,
    namespace: str | None = None,
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | None = None,
    roles: Sequence[str] = (),
    own_bias: bool | None = None,
    command: str = '',
    progress: Callable[[str], None] = lambda step: None,
) -> BagsAnalysis:
    """
    Fit friction to every bag alone, and to all of them together.

    ``roles`` and ``own_bias`` are those of :func:`consolidate_analyses`, ``progress`` is called
    with what is done next, and the other arguments are those of
    :func:`~sosml_friction.identification.bag_analysis.analyse_bag`, for every bag.

    :raises BagError: if a bag cannot be read or has no joint_states.
    :raises ConfigurationError: if a bag is given twice, bags are not of the same robot, or as for
        one bag.
    :raises DataError: if no joint can be fitted, or as for one bag.
    """
    labels = bag_labels(paths)
    parse_roles(roles, list(labels))
    robots = read_recordings(paths, model, urdf, namespace, step=progress)
    nominal = next(iter(robots.values())).nominal
    logs = {f'bag {source.name}': robot.log for source, robot in robots.items()}
    settings = settings or FitSettings()
    compared = compare_together(logs, nominal, settings, progress, bool(effort_hold))
    analyses: dict[str, BagAnalysis] = {}
    for label, path in labels.items():
        progress(f'reading and fitting {label}')
        try:
            analyses[label] = analyse_bag(
                path, model, urdf, settings, bandwidth, namespace, observers, effort_hold,
                require=False, command=command, compared=compared,
            )  # fmt: skip
        except DataError as error:
            raise DataError(f'bag {label}: {error}') from error
    progress('consolidating')
    return consolidate_analyses(analyses, roles, own_bias, command)


def compare_together(
    logs: Mapping[str, JointLog],
    nominal: RobotModelFile,
    settings: FitSettings,
    progress: Callable[[str], None] = lambda step: None,
    stated: bool = False,
) -> BodyComparison:
    """
    Return what all bags together say of the rigid body, and of when effort acts.

    :param stated: whether the hold of effort is stated.
    """
    progress('comparing the rigid body with the motion')
    robot = nominal.with_armature({'*': 0.0}).make_robot()
    checked = []
    for label, log in logs.items():
        try:
            checked.append(check_data(log, robot, '', nominal.unknown_armature)[0])
        except DataError as error:
            raise DataError(f'{label}: {error}') from error
    found = BodyComparison.of(checked, nominal, settings.body_tolerance, progress, stated)
    # The friction of each bag is put together from its own fits.
    found = replace(found, friction=lambda: ({}, ()))
    if found.refit is None:
        return found
    return replace(found, refit=replace(found.refit, laws={}, loads=()))


def consolidate_analyses(
    analyses: Mapping[str, BagAnalysis],
    roles: Sequence[str] = (),
    own_bias: bool | None = None,
    command: str = '',
) -> BagsAnalysis:
    """
    Put fitted recordings of one robot together.

    :param roles: ``LABEL=T1`` and so on, see
        :func:`~sosml_friction.identification.several.bag_roles.parse_roles`.
    :param own_bias: see :func:`~sosml_friction.identification.several.consolidation.consolidate`.
    :raises ConfigurationError: if a role is none.
    :raises DataError: if no joint can be fitted.
    """
    stated = parse_roles(roles, list(analyses))
    any_model = next(iter(analyses.values())).model
    units = dict(zip(any_model.joint_names, any_model.make_robot().effort_units, strict=True))
    found = find_roles({label: a.log for label, a in analyses.items()}, stated, units)
    joints: dict[str, dict[str, Consolidated]] = {}
    unavailable: dict[str, str] = {}
    for joint, unit in units.items():
        fits = {label: a.fit for label, a in analyses.items()}
        known = dict.fromkeys(o for fit in fits.values() for o in fit.rows.get(joint, {}))
        # All bags have the same bodies; of analyses of their own the least sure ones speak.
        shared: dict[str, float] = {}
        for analysis in analyses.values():
            if analysis.body is not None:
                more = dict(analysis.body.variance.get(joint, {}))
                laws = analysis.fit.joints.get(joint, {})
                used = preferred_observer(laws)
                shift = analysis.body.shift_by_scale(joint, laws[used].fit) if used else {}
                for name, by in shift.items():
                    more[name] = more.get(name, 0.0) + by**2
                for name, variance in more.items():
                    shared[name] = max(variance, shared.get(name, 0.0))
        entries = {o: consolidate(joint, o, unit, fits, found, own_bias, shared) for o in known}
        if any(entry.preferred for entry in entries.values()):
            joints[joint] = {o: entry for o, entry in entries.items() if entry.preferred}
            continue
        reasons = [entry.reason.rstrip('.') for entry in entries.values()]
        reasons += [fit.unavailable[joint] for fit in fits.values() if joint in fit.unavailable]
        unavailable[joint] = next(iter(reasons), 'no bag has an estimate of its friction')
    if not joints:
        raise DataError(
            'no joint can be fitted, by all bags together either. '
            + '; '.join(f'{joint}: {reason}' for joint, reason in unavailable.items())
        )
    chosen = {
        joint: observer
        for joint, entries in joints.items()
        if (observer := preferred_observer(entries)) is not None
    }
    consolidation = Consolidation(tuple(analyses), found, joints, chosen, unavailable)
    return BagsAnalysis(analyses, consolidation, _model(analyses, consolidation, command))


def _model(
    analyses: Mapping[str, BagAnalysis], consolidation: Consolidation, command: str
) -> RobotModelFile:
    first = next(iter(analyses.values())).model
    joints = {}
    for name, joint in first.joints.items():
        if name not in consolidation.model:
            joints[name] = replace(joint, friction=None)
            continue
        entry = consolidation.joints[name][consolidation.model[name]]
        friction = friction_of(entry.law, entry.parameters, entry.smoothing_velocity)
        joints[name] = replace(joint, friction=friction)
    provenance: dict[str, Any] = {
        'bags': [
            {'label': label, **{key: a.model.provenance[key] for key in _KEPT}}
            for label, a in analyses.items()
        ],
        'fitted': datetime.now(timezone.utc).isoformat(timespec='seconds'),
        'versions': first.provenance['versions'],
        'settings': first.provenance['settings'],
        'command': command,
        'consolidation': _outcome(consolidation),
    }
    own = {key: first.provenance[key] for key in _OF_MODEL if key in first.provenance}
    return replace(first, joints=joints, provenance={**to_plain(provenance), **own})


def _outcome(consolidation: Consolidation) -> dict[str, Any]:
    """Return what the model's friction rests on, for its provenance."""
    return {
        'roles': {label: role.role for label, role in consolidation.roles.items()},
        'joints': {
            joint: {
                'observer': observer,
                'preferred': entry.preferred,
                'reason': entry.reason,
                **entry.agreement.odds(),
            }
            for joint, observer in consolidation.model.items()
            for entry in [consolidation.joints[joint][observer]]
        },
    }
