# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fit of a recording in a thread of its own."""

from __future__ import annotations

import threading
from pathlib import Path

import yaml

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import BagAnalysis, analyse_bag
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.report.results import write_results


class FitJob:
    """
    Do what ``sosml fit`` does to the bag in a run's folder, while others go on.

    Writes ``model`` (with ``report.html`` and ``fit.json``) and ``parameters.yaml`` beside the
    ``bag``, both or, where it fails or is given up, none. ``step`` says what it is at.

    :param folder: of the run; it holds ``bag``.
    """

    def __init__(self, folder: Path, settings: FitSettings) -> None:
        self.folder = folder
        self.step = 'starting'
        #: The analysis, or why there is none; None while it runs.
        self.outcome: BagAnalysis | Exception | None = None
        self._settings = settings
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

    def _work(self) -> None:
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


class _GivenUpError(Exception):
    """End the worker between two steps."""
