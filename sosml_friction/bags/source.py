# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which recording a result rests on: its name and its hash."""

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.other_bag import SUFFIXES, other_files
from sosml_friction.exceptions import ConfigurationError


class Source(NamedTuple):
    """
    Say which recording a result rests on.

    ``sha256`` of the bag's files, or of the samples of a log that no bag holds; ``recovery`` is
    what a bag that was cut off says of itself, '' of a whole one.
    """

    name: str
    sha256: str
    recovery: str = ''


def bag_name(bag: str | Path) -> str:
    """Return the name of a bag, which is a folder or a file."""
    path = Path(bag).resolve()
    return path.stem if path.suffix in ('.mcap', *SUFFIXES) else path.name


def bag_labels(paths: Sequence[str | Path]) -> dict[str, Path]:
    """
    Return the bags, each given once, by a label: its name, or where two share one, its path.

    :raises ConfigurationError: if a bag is given twice.
    """
    resolved = [Path(path).resolve() for path in paths]
    for k, path in enumerate(resolved):
        if path in resolved[:k]:
            raise ConfigurationError(f'bag {paths[k]} is given twice: give each bag once')
    names = [bag_name(path) for path in resolved]
    return {
        name if names.count(name) == 1 else str(path): Path(path)
        for name, path in zip(names, paths, strict=True)
    }


def bag_hash(path: Path) -> str:
    """Return the SHA-256 of a bag's files of messages, in the order of their names."""
    files = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    files = files or other_files(path)
    digest = hashlib.sha256()
    for file in files:
        with file.open('rb') as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


def bag_source(path: str | Path, bag: Bag) -> Source:
    """Return which recording a bag is."""
    return Source(Path(path).name, bag_hash(Path(path)), bag.recovery)


def log_source(log: JointLog, name: str) -> Source:
    """Return which recording a log is that no bag holds, by its joints, stamps and samples."""
    digest = hashlib.sha256('\n'.join(log.names).encode())
    for samples in (log.t_ns, log.q, log.v, log.tau, log.temperature):
        digest.update(b'' if samples is None else samples.ravel().data)
    return Source(name, digest.hexdigest())


def refuse_copies(sources: Iterable[Source]) -> None:
    """Refuse one recording under two labels with a ConfigurationError."""
    labels: dict[str, str] = {}
    for label, digest, _ in sources:
        copy_of = labels.setdefault(digest, label)
        if copy_of != label:
            raise ConfigurationError(
                f'bags {copy_of} and {label} are copies of one recording, which would count '
                'twice: give each recording once'
            )
