# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A node as a process of the demo."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from sosml_friction.exceptions import ActuatorError

_PR_SET_PDEATHSIG = 1


class NodeProcess:
    """Run a node with parameters (``NAME:=VALUE``, after those of ``file``) in a ``with``."""

    def __init__(self, name: str, file: Path, parameters: Iterable[str], log: Path) -> None:
        self.name = name
        self._log = log
        module = f'sosml_friction.nodes.{name}'
        self._command = [sys.executable, '-m', module, '--ros-args', '--params-file', str(file)]
        for parameter in parameters:
            self._command += ['-p', parameter]

    def __enter__(self) -> NodeProcess:
        with self._log.open('wb') as stream:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                # A Ctrl-C is the demo's to handle: it ends the nodes in order, the driver first.
                start_new_session=True,
                preexec_fn=_prepare_child,
            )
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def require_running(self) -> None:
        """Make sure that the process runs; else an ActuatorError quotes its last words."""
        if self._process.poll() is not None:
            said = [line for line in self._said().splitlines() if line.strip()] or ['no word']
            raise ActuatorError(
                f'{self.name} ended with exit code {self._process.returncode}: {said[-1]}'
            )

    def await_words(self, words: str, what: str) -> None:
        """Return when the node has said ``words``; an ActuatorError says what it does not do."""
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            self.require_running()
            if words in self._said():
                return
            time.sleep(0.05)
        raise ActuatorError(
            f'{self.name} does not {what} after 60 s: see its log in the output folder'
        )

    def _said(self) -> str:
        return self._log.read_text(errors='replace')


def _prepare_child() -> None:
    # A control loop beside other work keeps its rate better so; only root may, and it is no must.
    with suppress(OSError):
        os.nice(-10)
    # A demo that is killed must not leave the nodes behind: Linux then ends them.
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
