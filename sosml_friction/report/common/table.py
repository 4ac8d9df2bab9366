# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One table for both: the rows of a page and those of the terminal."""

import itertools
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape
from typing import NamedTuple

from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

#: Width of a table that is not printed to a terminal.
_PLAIN_WIDTH = 100


class Column(NamedTuple):
    """
    Describe one column; neighbours of one ``group`` have a common head above their own.

    :param style: any of n (numbers), w (never wrapped), l (a line to the left), with spaces.
    """

    head: str
    style: str = ''
    group: str = ''


class Markup(str):
    """Is the text of a cell that is HTML already."""

    __slots__ = ()


Columns = Sequence[Column] | Mapping[str, str]


def _columns(columns: Columns) -> Sequence[Column]:
    if isinstance(columns, Mapping):
        return [Column(head, style) for head, style in columns.items()]
    return columns


def html_table(
    columns: Columns, rows: Iterable[Sequence[str]], caption: str = '', dim: Collection[int] = ()
) -> str:
    """
    Return a table as HTML that scrolls sideways where the page is too narrow for it.

    :param columns: a mapping has heads and their styles.
    :param dim: numbers of the rows that are pale.
    """
    columns = _columns(columns)

    def cells(tag: str, texts: Sequence[str], extra: str = '') -> str:
        return ''.join(
            f'<{tag}{extra}{_class(column.style)}>'
            f'{text if isinstance(text, Markup) else escape(text)}</{tag}>'
            for column, text in zip(columns, texts, strict=True)
        )

    heads = [f'<tr>{cells("th", [column.head for column in columns])}</tr>']
    if any(column.group for column in columns):
        heads = ['<tr>', '<tr>']
        for group, members in itertools.groupby(columns, key=lambda column: column.group):
            some = list(members)
            own = [f'{_class(column.style)}>{escape(column.head)}</th>' for column in some]
            if group:
                heads[0] += f'<th class="g l" colspan="{len(some)}">{escape(group)}</th>'
                heads[1] += ''.join(f'<th{each}' for each in own)
            else:
                heads[0] += ''.join(f'<th rowspan="2"{each}' for each in own)
        heads = [f'{head}</tr>' for head in heads]
    body = ''.join(
        f'<tr{_class("no" if k in dim else "")}>{cells("td", row)}</tr>'
        for k, row in enumerate(rows)
    )
    told = f'<caption>{escape(caption)}</caption>' if caption else ''
    return (
        f'<div class="wide"><table>{told}<thead>{"".join(heads)}</thead>'
        f'<tbody>{body}</tbody></table></div>'
    )


def _class(style: str) -> str:
    return f' class="{style}"' if style else ''


def terminal_table(
    columns: Columns, rows: Iterable[Sequence[str]], sections: bool = False
) -> Table:
    """
    Return the same table for the terminal.

    :param sections: a line ends each group of rows; the first cell of a group's other rows is
        empty.
    """
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    for head, style, _ in _columns(columns):
        table.add_column(
            Text(head),
            justify='right' if 'n' in style else 'left',
            no_wrap='w' in style,
            overflow='ellipsis' if 'w' in style else 'fold',
        )
    shown = list(rows)
    for k, row in enumerate(shown, 1):
        last = k == len(shown) or bool(shown[k][0])
        table.add_row(*map(Text, row), end_section=sections and last)
    return table


def print_table(table: RenderableType) -> None:
    """Print a table on stdout, at a fixed width where stdout is no terminal."""
    console = Console(width=None if sys.stdout.isatty() else _PLAIN_WIDTH, highlight=False)
    console.print(table)
