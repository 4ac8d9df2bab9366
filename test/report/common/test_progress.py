# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The progress bar is for people: on a terminal, on stderr."""

import os
import pty
import subprocess
import sys

CODE = """
from sosml_friction.report.common.progress import progress
with progress('fitting [1/2]') as step:
    step('drawing the report', 0.5)
print('done')
"""


def run(stderr):
    environment = {**os.environ, 'TERM': 'xterm', 'COLUMNS': '100'}
    for name in ('FORCE_COLOR', 'NO_COLOR', 'TTY_INTERACTIVE', 'TTY_COMPATIBLE'):
        environment.pop(name, None)
    command = [sys.executable, '-c', CODE]
    return subprocess.run(
        command, stdout=subprocess.PIPE, stderr=stderr, env=environment, check=True
    )


def test_silent_where_nobody_watches():
    ran = run(subprocess.PIPE)
    assert ran.stderr == b''
    assert ran.stdout == b'done\n'


def test_shown_on_a_terminal_and_never_on_stdout():
    ours, theirs = pty.openpty()
    try:
        ran = run(theirs)
        os.set_blocking(ours, False)
        shown = os.read(ours, 100_000)
    finally:
        os.close(ours)
        os.close(theirs)
    assert b'drawing the report' in shown
    assert ran.stdout == b'done\n'
