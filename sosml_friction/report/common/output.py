# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Results as files: nothing foreign is overwritten, nothing is left half written."""

import csv
import json
import math
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.plain_document import to_plain


class OutputKind(NamedTuple):
    """
    Say what a command writes into a folder.

    ``name`` as in "an earlier fit"; ``document``, the JSON file by whose entry ``format`` such a
    folder is known; ``files``, the names of all that may be written; ``page``, the HTML report.
    """

    name: str
    document: str
    format: str
    files: tuple[str, ...]
    page: str = 'report.html'


def check_output_folder(
    folder: str | Path, kind: OutputKind, beside: Collection[str] = ()
) -> Path:
    """
    Return ``folder`` if it is absent, empty, or holds an earlier result of that kind.

    :param beside: names in the folder that may be there all the same.
    :raises ConfigurationError: if it is a file, holds something else or cannot be written.
    """
    folder = Path(folder)
    try:
        is_free = not folder.exists() or (
            folder.is_dir()
            and ({path.name for path in folder.iterdir()} <= set(beside) or _holds(folder, kind))
        )
    except OSError as error:
        raise ConfigurationError(
            f'{folder} cannot be read: {error.strerror}: choose another place with --out'
        ) from error
    if not is_free:
        raise ConfigurationError(
            f'{folder} exists and is not the result of an earlier {kind.name}, so it is not '
            'overwritten: choose another place with --out'
        )
    require_writable(folder)
    return folder


def require_writable(folder: str | Path) -> None:
    """
    Make sure that ``folder`` can be written before anything is computed for it.

    :raises ConfigurationError: if it cannot.
    """
    workshop = _workshop(Path(folder), 'trial')
    shutil.rmtree(workshop, ignore_errors=True)


def _workshop(folder: Path, name: str) -> Path:
    """Return a new empty folder in the nearest one above ``folder`` that exists."""
    existing = next((above for above in folder.absolute().parents if above.exists()), folder)
    try:
        return Path(tempfile.mkdtemp(prefix=f'.sosml_{name}_', dir=existing))
    except OSError as error:
        raise refused(folder, error) from error


def _holds(folder: Path, kind: OutputKind) -> bool:
    try:
        document = json.loads((folder / kind.document).read_text(encoding='utf-8'))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and document.get('format') == kind.format


@contextmanager
def written_together(folder: Path, kind: OutputKind) -> Iterator[Path]:
    """
    Yield an empty folder to write into; its files then appear in ``folder`` together.

    It is made beside ``folder``: an interruption leaves what was there before. Those of an earlier
    result are replaced, and removed where there is no new one; other files are kept.

    :raises ConfigurationError: if the files cannot be written.
    """
    workshop = _workshop(folder, kind.name)
    try:
        yield workshop
        with _uninterrupted():
            folder.mkdir(parents=True, exist_ok=True)
            for name in kind.files:
                if (workshop / name).exists():
                    os.replace(workshop / name, folder / name)
                else:
                    (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise refused(folder, error) from error
    finally:
        shutil.rmtree(workshop, ignore_errors=True)


def write_result(workshop: Path, kind: OutputKind, document: Mapping[str, Any], page: str) -> None:
    """Write JSON file and report of a result into the folder of :func:`written_together`."""
    (workshop / kind.page).write_text(page, encoding='utf-8')
    (workshop / kind.document).write_text(to_json(document) + '\n', encoding='utf-8')


def refused(folder: Path, error: OSError) -> ConfigurationError:
    """Return the error of a folder that cannot be written."""
    return ConfigurationError(
        f'{folder} cannot be written: {error.strerror}: choose another place with --out'
    )


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait until the files are in their place."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def to_json(document: Mapping[str, Any]) -> str:
    """Return the JSON text of a document, without NaN."""
    return json.dumps(to_plain(document), indent=2, ensure_ascii=False, allow_nan=False)


def check_file(path: Path, option: str, suffix: str, begins: bytes) -> Path:
    """
    Return ``path`` if a file of this kind may be written there, in place of another of its kind.

    :param begins: how a file of this kind begins.
    :raises ConfigurationError: if its name or its folder does not fit, or another file is there.
    """
    if path.suffix.lower() != suffix:
        raise ConfigurationError(f'{option} {path} does not end in {suffix}: name it so')
    if not path.parent.is_dir():
        raise ConfigurationError(f'{path.parent} is no folder: choose another place with {option}')
    try:
        foreign = path.exists() and not path.read_bytes().startswith(begins)
    except OSError as error:
        raise ConfigurationError(
            f'{path} cannot be read: choose another place with {option}'
        ) from error
    if foreign:
        raise ConfigurationError(
            f'{path} exists and is something else, so it is not overwritten: choose another place '
            f'with {option}'
        )
    return path


def write_file(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    beside = path.with_name(f'.{path.name}.part')
    beside.write_bytes(content)
    beside.replace(path)


def csv_text(head: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """
    Return rows below their heading as CSV, its lines ended as Unix does.

    A number has nine digits; what is not known or not finite is empty.
    """
    stream = StringIO()
    writer = csv.writer(stream, lineterminator='\n')
    writer.writerow(head)
    writer.writerows(map(_cell, row) for row in rows)
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f'{value:.9g}' if math.isfinite(value) else ''
