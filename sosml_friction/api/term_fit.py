# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit a list of terms to one or several recordings."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.api.logs import labelled
from sosml_friction.api.model import Model
from sosml_friction.api.result import Result, blocks_text
from sosml_friction.api.simulate import Simulation, simulate
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import as_recorded
from sosml_friction.bags.source import log_source, refuse_copies
from sosml_friction.identification.bag_terms import fit_log_terms
from sosml_friction.identification.term_fit import FittedTerm, TermFit
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.terms.document import term_blocks, term_fit_document, write_term_fit


class Terms(Result):
    """Hold terms that were fitted; ``found`` has all details."""

    def __init__(self, found: TermFit, provenance: Mapping[str, Any]) -> None:
        self.found, self._provenance = found, dict(provenance)

    @property
    def terms(self) -> tuple[FittedTerm, ...]:
        """Return the terms with their parameters."""
        return self.found.terms

    @property
    def model(self) -> Model:
        """Return the model with the terms."""
        return Model(self.found.model)

    def conf_int(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Return 95 % intervals by ``term@joint`` and parameter."""
        return self.found.conf_int()

    def predict(self, log: JointLog) -> Simulation:
        """
        Simulate a recording with :attr:`model`.

        :raises DataError: if no joint has effort, or no stretch is long enough.
        """
        return simulate(log, self.model)

    def summary(self) -> str:
        """Return what was found, with its uncertainty."""
        return blocks_text(term_blocks(self.found))

    def to_dict(self) -> dict[str, Any]:
        """Return the object of ``sosml fit --terms --json``, without its entry ``output``."""
        return term_fit_document(self.found, self._provenance)

    def write(self, folder: str | Path) -> Path:
        """
        Write what ``sosml fit --terms`` writes: the model folder, report.html and fit.json.

        :raises ConfigurationError: if the folder holds something else or cannot be written.
        """
        return write_term_fit(folder, self.found, self._provenance)

    def _brief(self) -> str:
        return ', '.join(term.label for term in self.terms)


def fit_terms_of(
    logs: JointLog | Sequence[JointLog] | Mapping[str, JointLog],
    model: RobotModelFile,
    terms: Sequence[str],
) -> Terms:
    """Fit terms; parameters and errors as of :func:`sosml_friction.fit` with ``terms``."""
    recordings = {log_source(log, label): log for label, log in labelled(logs).items()}
    refuse_copies(recordings)
    nominal = as_recorded(model, next(iter(recordings.values())))
    return Terms(*fit_log_terms(recordings, nominal, terms))
