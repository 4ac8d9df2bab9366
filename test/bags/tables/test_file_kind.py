# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What kind of table a name says that a file is, and how its bag is called."""

from pathlib import Path

import pytest

from sosml_friction.bags.tables.file_kind import file_kind, is_table, table_name


@pytest.mark.parametrize(
    ('name', 'kind', 'bare'),
    [
        ('run.2.CSV', '.csv', 'run.2'),
        ('run.2.csv.GZ', '.csv', 'run.2'),
        ('run.txt.xz', '.txt', 'run'),
        ('run.zip', '.zip', 'run'),
        ('data.log', '.log', 'data'),
        ('run.mat.bz2', '.mat', 'run'),
        ('run.tar.gz', '.tar', 'run.tar'),
    ],
)
def test_the_kind_of_a_packed_table_stands_before_its_packing(name, kind, bare):
    assert file_kind(Path(name)) == kind
    assert table_name(Path(name)) == bare


def test_a_table_is_a_file_of_a_kind_that_is_read(tmp_path):
    for name in ('x.csv', 'x.json.gz', 'x.zip', 'x.mcap', 'x.tar.gz'):
        (tmp_path / name).touch()
    (tmp_path / 'folder.csv').mkdir()
    names = {path.name for path in tmp_path.iterdir() if is_table(path)}
    assert names == {'x.csv', 'x.json.gz', 'x.zip'}
