# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Every observer there is, by name."""

from collections.abc import Iterable, Mapping, Sequence

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.observer import Observer

#: The classes of observers, those of other programs included, from simple to slow.
OBSERVERS = Observer.registry


def on_line_names() -> tuple[str, ...]:
    """Return those that can run in a node."""
    return tuple(name for name, observer in OBSERVERS.items() if observer.causal)


def refuse_offline(names: Iterable[str]) -> None:
    """
    Check that none of the named observers needs the whole recording; unknown ones pass.

    :raises ConfigurationError: if one does; the sentence lists those that can run on line.
    """
    offline = [name for name in names if name in OBSERVERS and not OBSERVERS[name].causal]
    if offline:
        raise ConfigurationError(
            f'observer {", ".join(offline)} needs the whole recording and cannot run on line: use '
            f'it on a bag, and choose from {", ".join(on_line_names())} here'
        )


def check_observers(names: Iterable[str]) -> None:
    """
    Check that every named observer exists.

    :raises ConfigurationError: if one does not; the sentence lists those that do.
    """
    for name in names:
        if name not in OBSERVERS:
            raise ConfigurationError(f'observer {name!r} is unknown: use {", ".join(OBSERVERS)}')


def make_observer(name: str, gains: Mapping[str, Sequence[float]]) -> Observer:
    """
    Build an observer from its name.

    :raises ConfigurationError: if no observer has that name; the sentence lists those that exist.
    """
    check_observers([name])
    return OBSERVERS[name](gains)
