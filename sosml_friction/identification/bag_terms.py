# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From bags to the values of a list of terms: what ``sosml fit --terms`` does."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sosml_friction.bags.block_means import block_means, block_sentence
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import ModelSource
from sosml_friction.bags.recordings import read_recordings
from sosml_friction.bags.source import Source
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.term_fit import TermFit, fit_terms
from sosml_friction.model.model_folder import RobotModelFile


class BagTerms(NamedTuple):
    """Hold fitted terms and what they rest on."""

    fit: TermFit
    provenance: dict[str, Any]

    @property
    def remarks(self) -> list[str]:
        """Return what is wrong with the recordings, sentences without full stops."""
        bags = self.provenance['bags']
        return [
            f'{bag["bag"]}: {said}' if len(bags) > 1 else said
            for bag in bags
            for said in bag['remarks']
        ]


def fit_log_terms(
    recordings: Mapping[Source, JointLog],
    nominal: RobotModelFile,
    terms: Sequence[str],
    step: Callable[[str], None] = lambda text: None,
    body_tolerance: float | None = None,
) -> BagTerms:
    """Fit terms to recordings of one robot once their data are checked, as ``fit_terms`` does."""
    robot = nominal.with_armature({'*': 0.0}).make_robot()
    logs, bags, reasons = [], [], dict[str, str]()
    for source, recording in recordings.items():
        log, checks = check_data(recording, robot, source.recovery, nominal.unknown_armature)
        log, together = block_means(log)
        logs.append(log)
        silent = [n for n in robot.names if not np.isfinite(recording.select([n]).tau).any()]
        remarks = [
            *checks.sentences,
            *([block_sentence(log, together)] if together > 1 else []),
            *(f'{n} reports no effort and is not fitted' for n in silent),
        ]
        reasons |= dict.fromkeys(silent, '')
        bags.append(
            {
                'bag': source.name,
                'sha256': source.sha256,
                'start_ns': int(log.t_ns[0]),
                'remarks': remarks,
            }
        )
        reasons |= checks.not_fitted
    fit = fit_terms(logs, nominal, terms, None, step, body_tolerance)
    left = {term: reasons.get(term.partition('@')[2], why) for term, why in fit.left.items()}
    # What nobody measured is no failure of the fit.
    left = {term: why for term, why in left.items() if why}
    provenance = {'bags': bags, 'model': nominal.name, 'terms': list(terms)}
    return BagTerms(replace(fit, left=left), provenance)


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
    robots = read_recordings(bags, model, urdf, namespace, model is not None, step)
    nominal = next(iter(robots.values())).nominal
    logs = {source: robot.log for source, robot in robots.items()}
    fit, own = fit_log_terms(logs, nominal, terms, step, body_tolerance)
    now = datetime.now(timezone.utc).isoformat(timespec='seconds')
    provenance = {**own, 'fitted': now, 'command': command}
    beside = replace(fit.nominal, provenance={**nominal.provenance, **provenance})
    return BagTerms(replace(fit, nominal=beside), provenance)
