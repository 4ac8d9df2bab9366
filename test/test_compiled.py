# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Compiled functions on disk, when processes compile them at the same time."""

import os
import subprocess
import sys
from pathlib import Path

MODULE = """
from sosml_friction.compiled import compiled

@compiled
def total(x):
    sum = 0.0
    for i in range(x.shape[0]):
        sum += x[i]
    return sum
"""
# Both find an empty index, if one does not wait for the other, and write it and the code that it
# names in an order that mixes them up.
SLOW = """
import sys, time
from pathlib import Path
from numba.core.caching import IndexDataCacheFile as File

def meet(step, seconds):
    (Path(__file__).parent / f'{step}_{sys.argv[1]}').touch()
    end = time.monotonic() + seconds
    while len(list(Path(__file__).parent.glob(f'{step}_*'))) < 2 and time.monotonic() < end:
        time.sleep(0.01)

def loaded(self, method=File._load_index):
    index = method(self)
    if not index:
        meet('loaded', 2.0)
    return index

def delayed(method, seconds):
    return lambda *arguments: (time.sleep(seconds), method(*arguments))

def save(self, key, data, method=File.save):
    File._load_index = loaded
    method(self, key, data)

File.save = save
if sys.argv[1] == 'float64':
    File._save_index = delayed(File._save_index, 0.2)
else:
    File._save_data = delayed(File._save_data, 0.6)
import numpy, module
meet('ready', 60.0)
"""
CHANGED = """
import sosml_friction.compiled
sosml_friction.compiled._latest_change = lambda: 0
"""
CALL = """
import sys
import numpy as np
import module
print(module.total(np.arange(5, dtype=sys.argv[1])), sum(module.total.stats.cache_hits.values()))
"""
TYPES = ('float64', 'int32')


def start(folder: Path, code: str, kind: str) -> subprocess.Popen[str]:
    root = Path(__file__).resolve().parents[1]
    (folder / 'call.py').write_text(code)
    environment = {**os.environ, 'PYTHONPATH': f'{folder}:{root}', 'NUMBA_CACHE_DIR': str(folder)}
    return subprocess.Popen(
        [sys.executable, folder / 'call.py', kind],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )


def test_processes_that_compile_one_function_for_two_types_at_once_leave_both_on_disk(tmp_path):
    (tmp_path / 'module.py').write_text(MODULE)
    for code, hits in ((SLOW + CALL, 0), (CALL, 1)):
        for process in [start(tmp_path, code, kind) for kind in TYPES]:
            assert process.communicate(timeout=600)[0] == f'10.0 {hits}\n'


def test_a_function_is_compiled_once_for_all_processes(tmp_path):
    (tmp_path / 'module.py').write_text(MODULE)
    for hits in (0, 1):
        assert start(tmp_path, CALL, 'float64').communicate(timeout=600)[0] == f'10.0 {hits}\n'


def test_processes_that_call_a_function_at_once_compile_it_once(tmp_path):
    """The first to come compiles; the others load, and each says how often it did."""
    slow = MODULE.replace('    sum = 0.0', '    sum = 0.0 * np.linalg.det(np.eye(2))')
    (tmp_path / 'module.py').write_text('import numpy as np\n' + slow)
    processes = [start(tmp_path, CALL, 'float64') for _ in range(3)]
    said = sorted(process.communicate(timeout=600)[0] for process in processes)
    assert said == ['10.0 0\n', '10.0 1\n', '10.0 1\n']


def test_a_change_anywhere_in_the_package_compiles_anew(tmp_path):
    (tmp_path / 'module.py').write_text(MODULE)
    for code in (CALL, CHANGED + CALL):
        assert start(tmp_path, code, 'float64').communicate(timeout=600)[0] == '10.0 0\n'
