# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number is never broken in its middle, however narrow the terminal is."""

import re
from io import StringIO

import pytest
from rich.console import Console

from sosml_friction.report.common.table import print_table, terminal_table

ROWS = [
    ['shoulder', 'coulomb', '0.80042', '0.0088 to 0.0439', '0.39836..0.4016'],
    ['', 'stribeck_velocity', '0.02617', '-', '0.0252..0.0351'],
]
COLUMNS = {'joint': 'w', 'parameter': 'w', 'FO': 'n', 'SOSML': 'n', 'std error\n(Weak form)': 'n'}


def shown(width):
    stream = StringIO()
    Console(file=stream, width=width).print(terminal_table(COLUMNS, ROWS, sections=True))
    return stream.getvalue()


@pytest.mark.parametrize('width', [42, 50, 60, 80, 120])
def test_every_number_is_whole_and_every_line_fits(width):
    text = shown(width)
    for row in ROWS:
        for cell in row:
            for word in cell.split():
                assert re.search(rf'(?<!\S){re.escape(word)}(?!\S)', text), word
    assert max(map(len, text.splitlines())) <= width


def test_what_is_below_one_another_names_its_joint_each_time():
    assert shown(42).count('shoulder') == 2
    assert shown(120).count('shoulder') == 1


def test_a_file_gets_the_whole_width_and_no_colour(capsys):
    print_table(terminal_table(dict.fromkeys('abcdefghij', 'w'), [['x' * 20] * 10]))
    text = capsys.readouterr().out
    assert text.count('x' * 20) == 10
    assert '\x1b' not in text
