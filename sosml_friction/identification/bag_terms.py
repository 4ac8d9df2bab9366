# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From bags to the values of a list of terms: what ``sosml fit --terms`` does."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

from sosml_friction.bags.recorded_robot import ModelSource, RecordedRobot, read_recorded_robot
from sosml_friction.bags.source import bag_hash, bag_labels, refuse_copies
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.term_fit import TermFit, fit_terms


class BagTerms(NamedTuple):
    """Hold fitted terms and what they rest on."""

    fit: TermFit
    provenance: dict[str, Any]


def fit_bag_terms(
    bags: Sequence[str | Path],
    terms: Sequence[str],
    model: ModelSource = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    command: str = '',
    step: Callable[[str], None] = lambda text: None,
    body_tolerance: float | None = None,
) -> BagTerms:
    """
    Estimate the values of terms from the recordings in bags of one robot.

    :param terms: as for :func:`~sosml_friction.identification.term_fit.parse_terms`.
    :param model: folder of the model that has the rest; None for the first bag's own.
    :param urdf: URDF file instead of either's.
    :param command: the command line, for the provenance.
    :param body_tolerance: as for :func:`~sosml_friction.identification.term_fit.fit_terms`.
    :raises BagError: if a bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model is known, bags are of other robots or copies, or a
        term is unknown or can act in no joint.
    :raises DataError: if no joint has effort, or the recordings are too short.
    """
    labels = bag_labels(bags)
    robots: dict[str, RecordedRobot] = {}
    for label, path in labels.items():
        step(f'reading {label}')
        robots[label] = read_recorded_robot(
            path, model, urdf, namespace, own_urdf=model is not None
        )
    hashes = {label: bag_hash(path) for label, path in labels.items()}
    refuse_copies(hashes)
    first, one = next(iter(robots.items()))
    for label, other in robots.items():
        if one.nominal.joint_names != other.nominal.joint_names:
            raise ConfigurationError(
                f'bags {first} and {label} are not of the same robot: their joints are '
                f'{", ".join(one.nominal.joint_names)} and {", ".join(other.nominal.joint_names)}'
            )
    fit = fit_terms(
        [robot.log for robot in robots.values()], one.nominal, terms, None, step, body_tolerance
    )
    provenance = {
        'bags': [{'bag': label, 'sha256': digest} for label, digest in hashes.items()],
        'model': one.nominal.name,
        'terms': list(terms),
        'fitted': datetime.now(timezone.utc).isoformat(timespec='seconds'),
        'command': command,
    }
    fitted = replace(fit.model, provenance={**one.nominal.provenance, **provenance})
    return BagTerms(replace(fit, model=fitted), provenance)
