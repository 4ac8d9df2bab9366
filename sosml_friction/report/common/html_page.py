# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the HTML reports share: one file that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
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
    """Return the document of the parts that are not empty."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><style>{_STYLE}</style></head>\n<body>\n'
        + '\n'.join(part for part in parts if part)
        + '\n</body></html>\n'
    )


def picture(png: bytes, caption: str) -> str:
    """Return a figure with its picture inside the document."""
    data = base64.b64encode(png).decode('ascii')
    return (
        f'<figure><img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
        f'<figcaption>{escape(caption)}</figcaption></figure>'
    )


def table(columns: Mapping[str, str], rows: Iterable[Sequence[str]], caption: str = '') -> str:
    """
    Return a table of texts.

    :param columns: heads, each with the class of its column: 'n' for numbers, '' for text.
    """
    styles = [f' class="{style}"' if style else '' for style in columns.values()]

    def line(tag: str, texts: Sequence[str]) -> str:
        cells = (
            f'<{tag}{style}>{escape(text)}</{tag}>'
            for style, text in zip(styles, texts, strict=True)
        )
        return f'<tr>{"".join(cells)}</tr>'

    told = f'<caption>{escape(caption)}</caption>' if caption else ''
    body = ''.join(line('td', row) for row in rows)
    head = line('th', list(columns))
    return f'<table>{told}<thead>{head}</thead><tbody>{body}</tbody></table>'


def number_cell(text: str, style: str = 'n') -> str:
    """Return a cell of a table, its text to the right."""
    return f'<td class="{style}">{escape(text)}</td>'
