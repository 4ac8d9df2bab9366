# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Classes found by a name that they say themselves: terms, observers, actuators, trajectories."""

import importlib
import importlib.util
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from sosml_friction.exceptions import ConfigurationError

T = TypeVar('T')


class UnknownNameError(ConfigurationError, KeyError):
    """No class has that name; a KeyError, too, so that a registry is a mapping."""

    # That of KeyError puts the sentence into quotes.
    __str__ = Exception.__str__


def import_folder(package: str, file: str = '', but: str = '') -> None:
    """
    Import the modules of a package, so that their classes register themselves.

    :param file: of a folder in the package, this file is imported if it exists; '': the folder.
    :param but: a module that is not imported.
    """
    for module in pkgutil.iter_modules(importlib.import_module(package).__path__):
        name = f'{package}.{module.name}'
        if module.ispkg and file:
            name = f'{name}.{file}'
            if importlib.util.find_spec(name) is None:
                continue
        if module.name != but:
            importlib.import_module(name)


class Registry(Mapping[str, type[T]]):
    """
    Hold the classes of one kind, by identifier.

    A base class calls :meth:`add` in its ``__init_subclass__``, so that a class is found because
    it exists, wherever it was written. The modules of ``package`` are imported at the first look,
    so that one more file there is all that a new class needs. ``known``: the classes that were
    defined up to now.

    :param what: what the classes are, for the error sentence, such as ``term``.
    :param order: what the classes are sorted by, before their identifiers.
    :param file: see :func:`import_folder`.
    """

    def __init__(
        self,
        what: str,
        package: str,
        order: Callable[[type[T]], Any] = lambda _: 0,
        file: str = '',
    ) -> None:
        self._what, self._package, self._order, self._file = what, package, order, file
        self.known: dict[str, type[T]] = {}
        self._loaded = False

    def add(self, kind: type[T], name: str = '') -> None:
        """
        Register a class.

        :param name: if not the ``identifier`` in the class's own body; a base class has none, and
            is not registered.
        :raises ConfigurationError: if another class has that identifier.
        """
        name = name or vars(kind).get('identifier', '')
        if not name:
            return
        found = self.known.get(name, kind)
        # One that is defined again is no other.
        if (found.__module__, found.__qualname__) != (kind.__module__, kind.__qualname__):
            raise ConfigurationError(
                f'there are two {self._what}s of the name {name!r}, in {found.__module__} and in '
                f'{kind.__module__}: rename one'
            )
        self.known[name] = kind

    def remove(self, identifier: str) -> None:
        """Forget a class, such as one that a test defined."""
        self.known.pop(identifier, None)

    @property
    def classes(self) -> dict[str, type[T]]:
        """Return all classes in their order."""
        if not self._loaded:
            import_folder(self._package, self._file)
            self._loaded = True
        return dict(sorted(self.known.items(), key=lambda item: (self._order(item[1]), item[0])))

    def __iter__(self) -> Iterator[str]:
        """Return the identifiers in the order of the classes."""
        return iter(self.classes)

    def __len__(self) -> int:
        """Return the number of classes."""
        return len(self.classes)

    def __getitem__(self, identifier: str) -> type[T]:
        """
        Return the class of an identifier.

        :raises ConfigurationError: if there is none; the sentence lists those that exist.
        """
        classes = self.classes
        if identifier not in classes:
            raise UnknownNameError(
                f'{self._what} {identifier!r} is unknown: use one of {", ".join(classes)}'
            )
        return classes[identifier]
