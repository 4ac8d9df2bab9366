# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read a file that may be packed, without unpacking more than a recording may be."""

import bz2
import gzip
import lzma
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from sosml_friction.bags.tables.file_kind import JSON_SUFFIXES, PACKED, TEXT_SUFFIXES, file_kind
from sosml_friction.exceptions import DataError

#: A file may unpack to this many bytes, or to this many times its own size: an hour of seven
#: joints at 200 Hz are 200 MB, and recordings pack to a tenth.
_UNPACKED, _TIMES = 2**28, 50
_ZIP = (b'PK\x03\x04', b'PK\x05\x06')
#: What is beside a table in an archive.
_NO_TABLES = ('readme', 'license', 'licence')
#: What opens a packed file, by the bytes that it begins with.
_OPENERS: dict[bytes, Callable[[IO[bytes]], gzip.GzipFile | bz2.BZ2File | lzma.LZMAFile]] = {
    b'\x1f\x8b': lambda stream: gzip.GzipFile(fileobj=stream),
    b'BZh': bz2.BZ2File,
    b'\xfd7zXZ\0': lzma.LZMAFile,
    b']\0\0': lzma.LZMAFile,
}


def most_unpacked(path: Path) -> int:
    """Return how many bytes a file may unpack to."""
    return max(_UNPACKED, _TIMES * path.stat().st_size)


def check_size(path: Path, unpacked: int) -> None:
    """Refuse, with a DataError, a file that unpacks to far more than it takes."""
    if unpacked > most_unpacked(path):
        raise DataError(
            f'{path} takes {path.stat().st_size} bytes and says that it unpacks to {unpacked}: '
            'save the variables that are needed, or save them unpacked'
        )


@contextmanager
def readable(path: Path, kind: str, advice: str = '', io: bool = True) -> Iterator[None]:
    """
    Raise a DataError where the library that reads a damaged file fails, anywhere and in any way.

    :param io: let an OSError pass: it is the disk's.
    """
    try:
        yield
    except DataError:
        raise
    except Exception as error:
        if io and isinstance(error, OSError):
            raise
        raise DataError(f'{path} is no readable {kind}: {error}{advice}') from error


def read_unpacked(path: Path) -> tuple[str, bytes]:
    """
    Return the kind of a table of text or JSON, by its suffix, and its bytes.

    Whether a file is packed say its first bytes, whatever its name is: one that was named
    ``.csv.gz`` and is plain text is read as it stands. Of an archive its one table is read.

    :raises DataError: if it is damaged, locked, holds no or several tables, or unpacks to far more
        than it takes.
    :raises OSError: if it cannot be read.
    """
    kind = file_kind(path)
    with path.open('rb') as stream:
        head = stream.read(8)
        stream.seek(0)
        opener = next((o for begin, o in _OPENERS.items() if head.startswith(begin)), None)
        if opener is None and not head.startswith(_ZIP):
            return '.txt' if kind in PACKED else kind, stream.read()
        most = most_unpacked(path)
        try:
            if opener is None:
                kind, content = _of_archive(path, stream, most + 1)
            else:
                content = opener(stream).read(most + 1)
        except EOFError:
            raise DataError(
                f'{path} ends before what is packed in it does: copy it again, or unpack what '
                'there is of it'
            ) from None
        # zipfile calls a kind of packing that it does not know a RuntimeError.
        except (OSError, zlib.error, lzma.LZMAError, zipfile.BadZipFile, RuntimeError) as error:
            raise DataError(f'{path} cannot be unpacked: {error}') from error
    if len(content) > most:
        raise DataError(
            f'{path} takes {path.stat().st_size} bytes and unpacks to more than {most}: unpack '
            'it, and keep the part that is needed'
        )
    return '.txt' if kind in PACKED else kind, content


def _of_archive(path: Path, stream: Any, most: int) -> tuple[str, bytes]:
    """Return the kind and the first bytes of the one table in an archive."""
    known = (*TEXT_SUFFIXES, *JSON_SUFFIXES)
    with zipfile.ZipFile(stream) as archive:
        if '[Content_Types].xml' in archive.namelist():
            raise DataError(f'{path} is a spreadsheet and no text: rename it .xlsx')
        files = [
            entry
            for entry in archive.infolist()
            if not entry.is_dir()
            and not entry.filename.startswith('__MACOSX/')
            and not Path(entry.filename).name.lower().startswith(('.', *_NO_TABLES))
        ]
        tables = [x for x in files if Path(x.filename).suffix.lower() in known]
        if len(files) == 1 and not Path(files[0].filename).suffix:
            tables = files
        if len(tables) != 1:
            names = ', '.join(x.filename for x in tables[:4])
            what = f'several tables ({names})' if tables else 'no table of text'
            raise DataError(f'{path} is an archive of {what}: unpack it, and give one table')
        if tables[0].flag_bits & 1:
            raise DataError(f'{path} is locked with a password: unpack it, and give the table')
        with archive.open(tables[0]) as member:
            return Path(tables[0].filename).suffix.lower() or '.txt', member.read(most)
