# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The catalogue of causes: the terms that a diagnosis looks for."""

import hashlib
import inspect
from collections.abc import Mapping
from pathlib import Path

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS, Term


def searched_terms() -> dict[str, type[Term]]:
    """Return the terms that are looked for where nothing else is asked, by identifier."""
    return {name: kind for name, kind in TERMS.classes.items() if kind.searched}


def make_library(without: tuple[str, ...] = ()) -> dict[str, Term]:
    """
    Return one of each term that is looked for, by identifier.

    :param without: terms to leave out; of :data:`DATA_CAUSES` there is none to leave out here.
    :raises ConfigurationError: if there is no term of such a name.
    """
    terms = searched_terms()
    known = {*terms, *DATA_CAUSES}
    unknown = sorted(set(without) - known)
    if unknown:
        raise ConfigurationError(
            f'effect {unknown[0]!r} is unknown: use {", ".join(sorted(known))}'
        )
    return {name: kind() for name, kind in terms.items() if name not in without}


def library_hash(library: Mapping[str, Term]) -> str:
    """Return the SHA-256 of the source of terms and their kinds: what was looked for."""
    kinds = {
        kind for term in library.values() for kind in type(term).__mro__ if issubclass(kind, Term)
    }
    digest = hashlib.sha256()
    for file in sorted(map(inspect.getfile, kinds)):
        digest.update(Path(file).read_bytes())
    return digest.hexdigest()
