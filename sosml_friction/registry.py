# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Classes found by a name that they say themselves: terms, observers, actuators, figures."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from typing import Any, Generic, TypeVar

from sosml_friction.exceptions import ConfigurationError

T = TypeVar('T')


class Registry(Generic[T]):
    """
    Hold the classes of one kind, by identifier.

    A base class calls :meth:`add` in its ``__init_subclass__``, so that a class is found because
    it exists, wherever it was written. ``package``: its modules are imported at the first look,
    so that one more file there is all that a new class needs.

    :param what: what the classes are, for the error sentence, such as ``term``.
    """

    def __init__(self, what: str, package: str) -> None:
        self._what, self._package = what, package
        self._classes: dict[str, type[T]] = {}
        self._loaded = False

    def add(self, kind: type[T]) -> None:
        """
        Register a class that says an ``identifier`` of its own; a base class does not.

        :raises ConfigurationError: if another class has that identifier.
        """
        name = kind.__dict__.get('identifier')
        if not isinstance(name, str):
            return
        other: Any = self._classes.get(name)
        own: Any = kind
        same = (getattr(other, '__module__', ''), getattr(other, '__qualname__', ''))
        if other is not None and same != (own.__module__, own.__qualname__):
            raise ConfigurationError(
                f'there are two {self._what}s of the name {name!r}, in {other.__module__} and in '
                f'{own.__module__}: rename one'
            )
        self._classes[name] = kind

    def remove(self, identifier: str) -> None:
        """Forget a class, such as one that a test defined."""
        self._classes.pop(identifier, None)

    @property
    def classes(self) -> dict[str, type[T]]:
        """Return all classes in the order of their identifiers."""
        if not self._loaded:
            self._loaded = True
            package = importlib.import_module(self._package)
            for module in pkgutil.iter_modules(package.__path__):
                importlib.import_module(f'{self._package}.{module.name}')
        return dict(sorted(self._classes.items()))

    def __iter__(self) -> Iterator[str]:
        """Return the identifiers."""
        return iter(self.classes)

    def __getitem__(self, identifier: str) -> type[T]:
        """
        Return the class of an identifier.

        :raises ConfigurationError: if there is none; the sentence lists those that exist.
        """
        classes = self.classes
        if identifier not in classes:
            raise ConfigurationError(
                f'{self._what} {identifier!r} is unknown: use one of {", ".join(classes)}'
            )
        return classes[identifier]
