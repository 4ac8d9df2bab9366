# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of causes."""

from __future__ import annotations

import hashlib
import importlib
import inspect
import pkgutil
from pathlib import Path

from sosml_friction.diagnosis import effects
from sosml_friction.diagnosis.effect import Effect
from sosml_friction.exceptions import ConfigurationError


def _found() -> list[type[Effect]]:
    """Return the concrete effects of every module in ``diagnosis/effects``."""
    result: list[type[Effect]] = []
    for entry in sorted(pkgutil.iter_modules(effects.__path__), key=lambda module: module.name):
        module = importlib.import_module(f'{effects.__name__}.{entry.name}')
        for _, kind in inspect.getmembers(module, inspect.isclass):
            if issubclass(kind, Effect) and kind.__module__ == module.__name__:
                result.append(kind)
    return sorted(result, key=lambda kind: kind.identifier)


_KINDS = _found()
_OF_JOINTS = {kind.identifier for kind in _KINDS if not kind.of_robot}
EFFECTS: dict[str, type[Effect]] = {
    kind.identifier: kind
    for kind in _KINDS
    if not (kind.of_robot and kind.identifier in _OF_JOINTS)
}
#: Causes of a joint that may act in all joints alike, too: the same identifier, in joint '*'.
EVERYWHERE: dict[str, type[Effect]] = {
    kind.identifier: kind for kind in _KINDS if kind.of_robot and kind.identifier in _OF_JOINTS
}
#: Causes without a column, found in the data themselves: data_checks.py and bursts.py.
DATA_CAUSES = ('dropped_samples', 'external_contact', 'velocity_lag')


def make_library(without: tuple[str, ...] = ()) -> dict[str, Effect]:
    """
    Return one of each effect, by identifier.

    :param without: effects to leave out; of :data:`DATA_CAUSES` there is none to leave out here.
    :raises ConfigurationError: if there is no effect of such a name.
    """
    known = {*EFFECTS, *DATA_CAUSES}
    unknown = sorted(set(without) - known)
    if unknown:
        raise ConfigurationError(
            f'effect {unknown[0]!r} is unknown: use {", ".join(sorted(known))}'
        )
    return {name: kind() for name, kind in EFFECTS.items() if name not in without}


def library_hash(library: dict[str, Effect]) -> str:
    """Return the SHA-256 of the source of the effects: what was looked for, fixed beforehand."""
    digest = hashlib.sha256()
    for name in sorted(library):
        for kind in (type(library[name]), EVERYWHERE.get(name)):
            if kind is not None:
                digest.update(Path(inspect.getfile(kind)).read_bytes())
    return digest.hexdigest()
