# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Ask ``sosml diagnose``, in a process that sees the bags and the nominal model and no more."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import read_model
from validation.trial import Trial, nominal_model


@dataclass(frozen=True)
class Answer:
    """Hold what ``sosml diagnose --json`` printed, and its processor time [s], start included."""

    document: dict[str, Any]
    cpu_s: float


def ask(trial: Trial, folder: Path) -> Answer:
    """
    Return the answer to a trial.

    :param folder: is made; nothing in it, nor its environment, says what is hidden.
    :raises RuntimeError: if the diagnosis fails, with what it said, or its model cannot be used.
    """
    folder.mkdir(parents=True)
    model = nominal_model()
    model.write(folder / 'nominal')
    write_joint_log(trial.log, folder / 'bag', model.urdf)
    command = [
        sys.executable, '-m', 'sosml_friction.cli.main', 'diagnose', 'bag', '--model', 'nominal',
        '--out', 'answer', '--json',
    ]  # fmt: skip
    if trial.holdout is not None:
        write_joint_log(trial.holdout, folder / 'holdout', model.urdf)
        command += ['--holdout', 'holdout']
    if trial.spec.without:
        command += ['--without', ','.join(trial.spec.without)]
    root = Path(__file__).resolve().parents[1]
    environment = {
        **{k: v for k, v in os.environ.items() if 'BLIND' not in k and 'PYTEST' not in k},
        'PYTHONPATH': str(root),
        'OMP_NUM_THREADS': '1',
        'OPENBLAS_NUM_THREADS': '1',
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment, check=False, cwd=folder
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1) or not done.stdout.strip():
        raise RuntimeError(f'exit code {done.returncode}: {done.stderr.strip()[-600:]}')
    document = json.loads(done.stdout)
    _check_model(folder / 'answer', document)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Answer(document, cpu)


def _check_model(folder: Path, document: dict[str, Any]) -> None:
    """
    Read the extended model as a simulation does.

    :raises RuntimeError: if there is none though a cause is in it, or it cannot be used.
    """
    terms = [*document['causes'], *document['tolerated']]
    if (folder / 'model.yaml').exists() != any(x['in_model'] for x in terms):
        raise RuntimeError('an extended model without a cause in it, or such a cause without one')
    if (folder / 'model.yaml').exists():
        try:
            known_terms(read_model(folder))
        except ConfigurationError as error:
            raise RuntimeError(f'the extended model is of no use: {error}') from None
