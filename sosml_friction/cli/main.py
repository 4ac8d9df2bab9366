# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The tool ``sosml``: what is done off line.

Exit codes: 0 done; 1 ran, but the answer is "no"; 2 bad input or wrong usage, one sentence on
stderr; 130 after Ctrl-C. With ``--json`` stdout carries exactly one JSON object; progress and
remarks always go to stderr.
"""

import os
import sys
from collections.abc import Sequence
from typing import Any

import typer

from sosml_friction.cli.app import app, remark
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.registry import import_folder

_INTERRUPTED = 130
# Typer bundles its own copy of click since 0.20 and needs click itself before: both end here.
_UsageError: Any = typer.BadParameter.__base__

# A command is a file of this folder that registers itself with the application.
import_folder('sosml_friction.cli', but='main')


def main(arguments: Sequence[str] | None = None) -> int:
    """
    Run the tool and return its exit code.

    :param arguments: the command line without the name of the program; sys.argv's if None.
    """
    # Before NumPy is loaded, for commands that fit by other ways too and the processes that they
    # start; why is said in one_thread.py.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    given = sys.argv[1:] if arguments is None else list(arguments)
    try:
        # Not standalone: usage errors come back, to be told in one sentence like all others.
        result = app(args=given, prog_name='sosml', standalone_mode=False, obj=given)
    except SosmlFrictionError as error:
        return _refuse(str(error))
    except OSError as error:
        return _refuse(f'{error.filename or "a file"} cannot be used: {error.strerror}')
    except (KeyboardInterrupt, typer.Abort):
        result = _INTERRUPTED
    except SystemExit as request:  # Typer's own, after --show-completion
        result = request.code
    except _UsageError as error:
        command = error.ctx.command_path if error.ctx else 'sosml'
        text = ' '.join(error.format_message().split()).rstrip('.')
        return _refuse(f'{text[:1].lower()}{text[1:]} (see {command} --help)')
    # Newer versions of Typer answer Ctrl-C with the code, older ones with Abort.
    if result == _INTERRUPTED:
        remark('interrupted')
    return result if isinstance(result, int) else 0


def _refuse(text: str) -> int:
    remark(text)
    return 2


if __name__ == '__main__':
    sys.exit(main())
