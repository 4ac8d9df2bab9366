# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""XML as it is read and written: comments stay, and numbers read back as the same."""

from collections.abc import Iterable, Sequence
from xml.etree import ElementTree


def parse_xml(text: str) -> ElementTree.Element:
    """Return the root of a document with its comments; ``ParseError`` if it is no XML."""
    builder = ElementTree.TreeBuilder(insert_comments=True)
    return ElementTree.fromstring(text, ElementTree.XMLParser(target=builder))


def number_list(values: Iterable[float]) -> str:
    """Return numbers with blanks between; repr is the shortest text that reads back the same."""
    return ' '.join(repr(float(x)) for x in values)


def commented(root: ElementTree.Element, notes: Sequence[str]) -> str:
    """Return a document below a comment of a line for each note."""
    lines = '\n  '.join(notes).replace('--', '- -')
    return f'<!--\n  {lines}\n-->\n{ElementTree.tostring(root, encoding="unicode")}\n'
