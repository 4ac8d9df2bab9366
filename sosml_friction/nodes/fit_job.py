# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fit of a recording, and its diagnosis, in a thread of their own."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.number_text import with_interval
from sosml_friction.one_thread import in_one_thread
from sosml_friction.report.fit.results import write_results

if TYPE_CHECKING:
    from sosml_friction.diagnosis.diagnosis import Diagnosis


class FitJob:
    """
    Do what ``sosml fit`` does to the bag in a run's folder, while others go on.

    Writes ``model`` (with ``report.html`` and ``fit.json``) and ``parameters.yaml`` beside the
    ``bag``, both or, where it fails or is given up, none. Then, with ``diagnose``, it does what
    ``sosml diagnose`` does (``without`` some effects; entries ``GROUP=SHARE`` of ``trust`` say how
    far nominal parameters may be off), with the model that the bag was recorded with, and writes
    ``diagnosis`` beside them; the fit stays where that fails. ``step`` says what it is at.
    """

    def __init__(
        self,
        folder: Path,
        settings: FitSettings,
        diagnose: bool = False,
        without: Sequence[str] = (),
        trust: Sequence[str] = (),
    ) -> None:
        self.folder = folder
        self.step = 'starting'
        #: The analysis, or why there is none; None while the fit runs.
        self.outcome: BagAnalysis | Exception | None = None
        #: The diagnosis, or why there is none; None while it runs or where it was not asked for.
        self.diagnosis: Diagnosis | Exception | None = None
        self._settings = settings
        self._diagnose = diagnose
        self._without = tuple(without)
        self._trust = tuple(trust)
        self._given_up = threading.Event()
        self._thread = threading.Thread(target=self._work, name='fit')
        self._thread.start()

    @property
    def running(self) -> bool:
        """Tell whether it is still at work."""
        return self._thread.is_alive()

    def give_up(self) -> None:
        """End it after its present step, with nothing written; too late, it ends well."""
        self._given_up.set()

    def join(self) -> None:
        """Wait for its end."""
        self._thread.join()

    def _begin(self, step: str) -> None:
        if self._given_up.is_set():
            raise _GivenUpError
        self.step = step

    @in_one_thread
    def _work(self) -> None:
        self._fit()
        if self._diagnose and isinstance(self.outcome, BagAnalysis):
            self._find_causes()

    def _fit(self) -> None:
        try:
            analysis = analyse_bag(
                self.folder / 'bag', settings=self._settings, progress=self._begin
            )
            write_results(
                self.folder / 'model',
                analysis,
                progress=lambda joint: self._begin(f'drawing {joint}'),
            )
            model = str((self.folder / 'model').resolve())
            parameters = {'/**': {'ros__parameters': {'model': model}}}
            text = yaml.safe_dump(parameters)
            (self.folder / 'parameters.yaml').write_text(text, encoding='utf-8')
            self.outcome = analysis
        except _GivenUpError:
            self.outcome = ConfigurationError('it was aborted; ~/fit begins it anew')
        except OSError as error:
            self.outcome = ConfigurationError(f'{self.folder} cannot be written: {error.strerror}')
        except Exception as error:  # told to whoever waits, in another thread
            self.outcome = error

    def _find_causes(self) -> None:
        # numba and the catalogue take a second to load: only for those who asked.
        from sosml_friction.diagnosis.bag_diagnosis import diagnose_bags
        from sosml_friction.diagnosis.trust import parse_trust
        from sosml_friction.regression.settings import DiagnosisSettings
        from sosml_friction.report.common.output import check_output_folder
        from sosml_friction.report.diagnosis.document import KIND, write_diagnosis

        try:
            self._begin('beginning the diagnosis')
            folder = check_output_folder(self.folder / 'diagnosis', KIND)
            found = diagnose_bags(
                [self.folder / 'bag'],
                without=self._without,
                settings=DiagnosisSettings(trust=parse_trust(self._trust)),
                step=self._begin,
            )
            write_diagnosis(folder, found.diagnosis, found.nominal, found.provenance, self._begin)
            self.diagnosis = found.diagnosis
        except _GivenUpError:
            self.diagnosis = ConfigurationError('it was aborted; ~/fit begins fit and it anew')
        except Exception as error:  # told to whoever waits, in another thread
            self.diagnosis = error


class _GivenUpError(Exception):
    """End the worker between two steps."""


def summary(analysis: BagAnalysis) -> str:
    """Return what was found of each joint, in one line."""
    parts = []
    for name, joint in analysis.model.joints.items():
        if joint.friction is None:
            reasons = {**analysis.unmodelled, **analysis.fit.unavailable}
            parts.append(f'{name}: {reasons.get(name, "no friction")}')
            continue
        coulomb = joint.friction.parameters['coulomb']
        viscous = joint.friction.parameters['viscous']
        parts.append(
            f'{name}: coulomb {with_interval(coulomb, coulomb.unit)}, '
            f'viscous {with_interval(viscous, viscous.unit)}'
        )
    return '; '.join(parts)
