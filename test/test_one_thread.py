# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A fit and a diagnosis run in one thread of BLAS, and leave the process as it was."""

from __future__ import annotations

import subprocess
import sys

import pytest

BEGIN = """
import numpy as np
from threadpoolctl import threadpool_info

def threads():
    return {pool['num_threads'] for pool in threadpool_info() if pool['user_api'] == 'blas'}

seen = []

def watch(*args, **options):
    import scipy.linalg
    seen.append(threads())
    raise KeyError

import sosml_friction as sf
from sosml_friction.share import share_directory
model = sf.Model.read(share_directory() / 'config' / 'emps')
t = np.arange(2000) * 1e-3
log = sf.JointLog(
    tuple(model.joints), np.arange(2000) * 10**6, np.sin(t)[:, None], np.cos(t)[:, None],
    np.cos(t)[:, None],
)
before = threads()
"""
WORK = {
    'fit': """
import sosml_friction.api.fit as home
home.analyse_log = watch
work = lambda: sf.fit(log, model)
""",
    'diagnose': """
import sosml_friction.api.diagnose as home
home.diagnose_logs = watch
work = lambda: sf.diagnose(log, model)
""",
    'FitJob': """
from pathlib import Path
import sosml_friction.nodes.fit_job as home
from sosml_friction.identification.friction_fit import FitSettings
home.analyse_bag = watch
work = lambda: home.FitJob(Path('nowhere'), FitSettings()).join()
""",
}
END = """
try:
    work()
except KeyError:
    pass
print(before, *seen, threads())
"""


@pytest.mark.parametrize('what', WORK)
def test_work_of_minutes_is_in_one_thread_of_every_blas(what):
    """In a program that loaded NumPy first, with two threads, and SciPy, with its own, later."""
    code = BEGIN + WORK[what] + END
    done = subprocess.run(
        [sys.executable, '-c', code],
        env={'OPENBLAS_NUM_THREADS': '2', 'OPENBLAS_MAIN_FREE': '1'},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == '{2} {1} {2}\n', done.stderr
