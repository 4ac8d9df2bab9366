# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""YAML from outside: plain values alone, and bounds on what a document may ask for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from yaml.constructor import ConstructorError
from yaml.nodes import MappingNode, Node, ScalarNode

from sosml_friction.exceptions import ConfigurationError

#: Characters of a document: metadata.yaml of a thousand topics has a third of it.
_LONGEST = 2_000_000
#: Levels of a document; this package writes six.
_DEEPEST = 40
#: Nodes of a document with its aliases written out: more than any of that length without them.
_MOST_NODES = 1_000_000
#: Whole numbers that a double and a message can hold, about.
_LARGEST = 2**64
_TAG = 'tag:yaml.org,2002:'
_KINDS = ('null', 'bool', 'int', 'float', 'str', 'seq', 'map', 'merge')


def read_yaml(path: Path, what: str = '', needed: str = 'give a YAML file') -> Any:
    """
    Return the content of a YAML file, None of an empty one.

    :param what: what the file is, for the error sentence; ``needed``: what to give in its place.
    :raises ConfigurationError: if it cannot be read or is no such YAML, with line and key.
    """
    where = f'{what} {path}'.lstrip()
    try:
        # One more than is allowed tells, and a device without an end is not read for ever.
        with path.open(encoding='utf-8') as stream:
            text = stream.read(_LONGEST + 1)
    except UnicodeDecodeError as error:
        raise ConfigurationError(f'{where} is not YAML: it is no text in UTF-8') from error
    except OSError as error:
        raise ConfigurationError(f'{where} cannot be read ({error.strerror}): {needed}') from error
    return parse_yaml(text, where)


def parse_yaml(text: str, where: str) -> Any:
    """
    Return the content of a YAML document, None of an empty one.

    Dates stay text. Depth, length, whole numbers and what aliases multiply are bounded, and a key
    that is there twice is an error.

    :param where: the file or topic it came from, for the error sentence.
    :raises ConfigurationError: if it is no such YAML, with line and key.
    """
    if len(text) > _LONGEST:
        raise ConfigurationError(
            f'{where} is not YAML of this package: it is longer than {_LONGEST} characters'
        )
    loader = None
    try:
        loader = _BoundedLoader(text)
        return loader.get_single_data()
    except (yaml.YAMLError, ValueError, TypeError, OverflowError, RecursionError) as error:
        raise ConfigurationError(_sentence(error, loader, where)) from error
    finally:
        if loader is not None:
            loader.dispose()


def _sentence(error: Exception, loader: _BoundedLoader | None, where: str) -> str:
    mark = getattr(error, 'problem_mark', None) or getattr(error, 'context_mark', None)
    place = [] if mark is None else [f'line {mark.line + 1}']
    if loader is not None and loader.path:
        place.append(f'key {".".join(loader.path)}')
    parts = [getattr(error, name, None) for name in ('context', 'problem')]
    reason = ', '.join(part for part in parts if part) or str(error)
    shown = f' ({", ".join(place)})' if place else ''
    return f'{where} is not YAML{shown}: {" ".join(reason.split())}'


class _BoundedLoader(yaml.SafeLoader):
    """Compose and construct plain values; ``path`` is where in the document it is."""

    def __init__(self, text: str) -> None:
        self.path: list[str] = []
        self._sizes: dict[Node, int] = {}
        self._open: list[int] = [0]
        super().__init__(text)

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        """Compose one node, and count what it holds with its aliases written out."""
        self._enter(parent, index)
        is_alias = self.check_event(yaml.events.AliasEvent)
        mark = self.peek_event().start_mark
        if len(self._open) > _DEEPEST:
            raise ConstructorError(None, None, f'it is deeper than {_DEEPEST} levels', mark)
        self._open.append(1)
        node = super().compose_node(parent, index)
        size = self._open.pop()
        if node is not None:
            if is_alias and node not in self._sizes:
                raise ConstructorError(None, None, 'an alias stands within what it names', mark)
            size = self._sizes.setdefault(node, size)
            self._open[-1] += size
            if self._open[-1] > _MOST_NODES:
                problem = f'its aliases stand for more than {_MOST_NODES} entries'
                raise ConstructorError(None, None, problem, mark)
            self._check(node)
        self._leave(parent, index)
        return node

    def _enter(self, parent: Node | None, index: Any) -> None:
        if isinstance(index, ScalarNode):
            self.path.append(str(index.value))
        elif isinstance(index, int):
            self.path.append(str(index))

    def _leave(self, parent: Node | None, index: Any) -> None:
        if isinstance(index, (ScalarNode, int)):
            self.path.pop()

    def _check(self, node: Node) -> None:
        """Construct a scalar where its key is known, and see that each key is there once."""
        kind = node.tag.removeprefix(_TAG)
        if kind not in _KINDS:
            raise ConstructorError(None, None, f'{node.tag!r} is no plain value', node.start_mark)
        if isinstance(node, ScalarNode) and kind != 'merge':
            try:
                # Half of a character, as "\\ud800", can be written nowhere.
                node.value.encode('utf-8')
                value = self.construct_object(node)
            except (ValueError, OverflowError, TypeError, AttributeError, KeyError) as error:
                shown = node.value if len(node.value) < 40 else node.value[:37] + '...'
                problem = f'{shown!r} is no {kind}'
                raise ConstructorError(None, None, problem, node.start_mark) from error
            if isinstance(value, int) and abs(value) >= _LARGEST:
                problem = f'{node.value[:20]}... is too large a number'
                raise ConstructorError(None, None, problem, node.start_mark)
        elif isinstance(node, MappingNode):
            seen = set()
            for key, _ in node.value:
                name = (key.tag, key.value) if isinstance(key, ScalarNode) else None
                if name is not None and name in seen:
                    problem = f'the key {key.value!r} is there twice'
                    raise ConstructorError(None, None, problem, key.start_mark)
                seen.add(name)


# A date is text here: nobody asks for one, and JSON has none.
_BoundedLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in found if tag != f'{_TAG}timestamp']
    for first, found in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
