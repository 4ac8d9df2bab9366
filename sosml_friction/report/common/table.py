# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One table for both: the rows of a page and those of the terminal."""

import itertools
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape
from typing import NamedTuple

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.table import Table
from rich.text import Text

#: Width of a table that is not printed to a terminal.
_PLAIN_WIDTH = 100
#: Characters from which a cell is a sentence: it stays wide where the page is narrow.
_LONG = 60


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

    def cells(tag: str, texts: Sequence[str]) -> str:
        return ''.join(
            f'<{tag}{_class(column.style or ("t" if len(text) > _LONG else ""))}>'
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


class FittingTable(Table):
    """Is a table that has its rows below one another where the terminal is too narrow for it."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the table, or each of its rows as a list of heads and cells."""
        spare = options.max_width - self.least()
        if spare >= 0:
            self._share(spare)
            yield from super().__rich_console__(console, options)
            return
        heads = [' '.join(str(column.header).split()) for column in self.columns]
        cells = [[str(cell) for cell in column.cells] for column in self.columns]
        first = ''
        for name, *row in zip(*cells, strict=True):
            first = name or first
            yield Text(first, style='bold')
            grid = Table.grid(padding=(0, 2, 0, 0))
            for head, cell in zip(heads[1:], row, strict=True):
                if cell:
                    grid.add_row(f'  {head}', Text(cell))
            yield grid

    def least(self) -> int:
        """Return the width below which a word, or a cell that is never wrapped, is broken."""
        return sum(self._widths(whole=False)) + 2 * len(self.columns)

    def _widths(self, whole: bool) -> list[int]:
        """Return by column the longest line, or the longest of what cannot be broken."""
        widths = []
        for column in self.columns:
            texts = [str(column.header), *map(str, column.cells)]
            lines = [line for text in texts for line in text.split('\n')]
            if not (whole or column.no_wrap):
                lines = [word for line in lines for word in line.split()]
            widths.append(max(map(cell_len, lines), default=0))
        return widths

    def _share(self, spare: int) -> None:
        """Give each column what it needs, and what is left to those that are cut most."""
        least, most = self._widths(whole=False), self._widths(whole=True)
        widths = list(least)
        while spare > 0 and widths != most:
            k = max(range(len(widths)), key=lambda k: most[k] - widths[k])
            widths[k] += 1
            spare -= 1
        for column, width in zip(self.columns, widths, strict=True):
            column.width = width


def terminal_table(
    columns: Columns, rows: Iterable[Sequence[str]], sections: bool = False
) -> FittingTable:
    """
    Return the same table for the terminal.

    :param sections: a line ends each group of rows; the first cell of a group's other rows is
        empty.
    """
    table = FittingTable(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
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
    """Print a table on stdout; where that is no terminal without colour, and never too narrow."""
    if sys.stdout.isatty():
        Console(highlight=False).print(table)
        return
    parts = table.renderables if isinstance(table, Group) else [table]
    tables = [part for part in parts if isinstance(part, FittingTable)]
    width = max([_PLAIN_WIDTH, *(part.least() for part in tables)])
    Console(width=width, highlight=False, no_color=True).print(table)
