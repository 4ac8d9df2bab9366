# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the HTML reports share: one file that needs nothing else."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c1c1c; background: #fff; margin: 0 auto;
       max-width: 1040px; padding: 1.2em 20px 4em; }
h1 { font-size: 1.6em; margin: 0 0 .4em; } h2 { font-size: 1.3em; margin: 2em 0 .4em;
     border-bottom: 1px solid #ccc; } h3 { font-size: 1.05em; margin: 1.4em 0 .3em; }
.result { font-size: 1.1em; background: #f1f6f3; border-left: 4px solid #009e73;
          padding: .6em 1em; margin: 0 0 1em; } .result p { margin: .3em 0; }
.note { background: #fdf3e3; border-left: 4px solid #e69f00; padding: .5em 1em; margin: 0 0 1em; }
.note ul { margin: 0; padding-left: 1.2em; }
table { border-collapse: collapse; margin: .5em 0; font-size: 14px; }
caption { text-align: left; color: #555; }
th, td { padding: .2em .6em; border-bottom: 1px solid #e2e2e2; text-align: left;
         vertical-align: top; }
thead th { border-bottom: 1px solid #888; } th.n, td.n { text-align: right; }
td.w, td.n { white-space: nowrap; } td.n { font-variant-numeric: tabular-nums; }
th.g { text-align: center; } .l { border-left: 1px solid #ccc; }
.wide { overflow-x: auto; } tr.no td { color: #888; }
figure { margin: .6em 0; } img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .93em; } code { font-size: .92em; overflow-wrap: anywhere; }
@media print { body { max-width: none; } figure, table { break-inside: avoid; } }
"""


def page(title: str, parts: Sequence[str]) -> str:
    """Return the document of the parts that are not empty, below its title."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><style>{_STYLE}</style></head>\n'
        f'<body>\n<h1>{escape(title)}</h1>\n'
        + '\n'.join(part for part in parts if part)
        + '\n</body></html>\n'
    )


def picture(png: bytes, caption: str, title: str) -> str:
    """Return a figure with its picture inside the document."""
    data = base64.b64encode(png).decode('ascii')
    return (
        f'<figure><img alt="{escape(caption)}" title="{escape(title)}" '
        f'src="data:image/png;base64,{data}"><figcaption>{escape(caption)}</figcaption></figure>'
    )


def heading(text: str, level: int = 2) -> str:
    """Return a heading."""
    return f'<h{level}>{escape(text)}</h{level}>'


def items(texts: Iterable[str], head: str = '') -> str:
    """Return a list with a heading above it, empty where there is nothing to list."""
    listed = ''.join(f'<li>{escape(text)}</li>' for text in texts)
    return f'{head}<ul>{listed}</ul>' if listed else ''


def folded(summary: str, body: str) -> str:
    """Return what is hidden until it is asked for, empty where there is nothing."""
    return f'<details><summary>{escape(summary)}</summary>{body}</details>' if body else ''


def result_box(sentences: Iterable[str]) -> str:
    """Return the answer of a report, a paragraph for each sentence."""
    text = ''.join(f'<p>{escape(sentence)}</p>' for sentence in sentences)
    return f'<div class="result">{text}</div>' if text else ''


def joints_box(sentences: Iterable[str]) -> str:
    """Return the answer of a report by joint, ``joint: sentence``, the joints in bold."""
    text = ''
    for name, _, rest in (sentence.partition(':') for sentence in sentences):
        text += f'<p><strong>{escape(name)}</strong>:{escape(rest)}</p>'
    return f'<div class="result">{text}</div>'


def notes_box(remarks: Iterable[str]) -> str:
    """Return what a reader should know first, empty where there is nothing."""
    listed = items(remarks)
    return f'<div class="note">{listed}</div>' if listed else ''
