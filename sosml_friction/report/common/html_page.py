# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the HTML reports share: one file that needs nothing else, for phone, screen and paper."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path

_HERE = Path(__file__).parent
#: How a reader uses the figures; said once, where there are any.
_HINT = (
    'Figures: point at a curve for its values, drag to zoom, double-click to go back, click an '
    'entry of a legend to hide its curves.'
)


def page(title: str, parts: Sequence[str]) -> str:
    """Return the document of the parts that are not empty, below its title."""
    body = '\n'.join(part for part in parts if part)
    style = (_HERE / 'page.css').read_text(encoding='utf-8')
    end = ''
    if '<svg' in body:
        script = (_HERE / 'page.js').read_text(encoding='utf-8')
        end = (
            f'\n<p class="hint">{escape(_HINT)}</p><div id="tip"></div>\n<script>{script}</script>'
        )
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark">'
        f'<title>{escape(title)}</title><style>\n{style}</style></head>\n'
        f'<body>\n<h1>{escape(title)}</h1>\n{body}{end}\n</body></html>\n'
    )


def picture(svg: str, caption: str, title: str) -> str:
    """Return a figure, which scrolls by itself where the page is too narrow to read it."""
    return (
        f'<figure title="{escape(title)}"><div class="wide">{svg}</div>'
        f'<figcaption>{escape(caption)}</figcaption></figure>'
    )


def heading(text: str, level: int = 2) -> str:
    """Return a heading."""
    return f'<h{level}>{escape(text)}</h{level}>'


def paragraph(text: str) -> str:
    """Return a paragraph, empty where there is nothing to say."""
    return f'<p>{escape(text)}</p>' if text else ''


def items(texts: Iterable[str], head: str = '') -> str:
    """Return a list with a heading above it, empty where there is nothing to list."""
    listed = ''.join(f'<li>{escape(text)}</li>' for text in texts)
    return f'{head}<ul>{listed}</ul>' if listed else ''


def folded(summary: str, body: str) -> str:
    """Return what is hidden until it is asked for, empty where there is nothing."""
    return f'<details><summary>{escape(summary)}</summary>{body}</details>' if body else ''


def facts(told: Mapping[str, str]) -> str:
    """Return what a report is about, as short entries in a row: those that are not empty."""
    entries = ''.join(
        f'<div><dt>{escape(name)}</dt><dd>{escape(text)}</dd></div>'
        for name, text in told.items()
        if text
    )
    return f'<dl class="facts">{entries}</dl>' if entries else ''


def verdict(kind: str, label: str, sentences: Iterable[str] = (), body: str = '') -> str:
    """
    Return the answer of a report: a badge, and a paragraph for each sentence.

    A sentence that begins with a name and a colon has the name in bold.

    :param kind: ``good``, ``open``, ``found`` or ``bad``, which is its colour.
    """
    text = ''.join(f'<p>{_with_name(sentence)}</p>' for sentence in sentences)
    return (
        f'<div class="result {kind}"><p><span class="badge">{escape(label)}</span></p>{text}{body}'
        '</div>'
    )


def _with_name(sentence: str) -> str:
    name, colon, rest = sentence.partition(':')
    if not colon or len(name) > 40:
        return escape(sentence)
    return f'<strong>{escape(name)}</strong>:{escape(rest)}'


def box(head: str, texts: Iterable[str], kind: str = 'note') -> str:
    """
    Return a box with a heading and a list, empty where there is nothing to list.

    :param kind: ``note`` for what a reader should know, ``next`` for what to do.
    """
    listed = items(texts)
    return f'<div class="box {kind}"><h3>{escape(head)}</h3>{listed}</div>' if listed else ''


def cards(bodies: Sequence[str]) -> str:
    """Return parts side by side where the page is wide enough, else below one another."""
    return '<div class="cards">' + ''.join(f'<section>{x}</section>' for x in bodies) + '</div>'
