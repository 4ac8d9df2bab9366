# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A file that was not fetched is told from a recording."""

import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.exceptions import DataError

POINTER = b'version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n'


@pytest.mark.parametrize('kind', ['csv', 'json', 'mat', 'npz', 'h5', 'parquet', 'xlsx'])
def test_a_pointer_in_the_place_of_a_table_says_how_to_fetch_it(tmp_path, kind):
    path = tmp_path / f'x.{kind}'
    path.write_bytes(POINTER)
    with pytest.raises(DataError, match='a pointer of Git LFS'):
        DataFile(path)


@pytest.mark.parametrize('kind', ['mcap', 'db3', 'bag'])
def test_so_does_one_in_the_place_of_a_bag(tmp_path, kind):
    path = tmp_path / f'x.{kind}'
    path.write_bytes(POINTER)
    with pytest.raises(DataError, match='git lfs pull'):
        Bag.open(path)


def test_a_page_in_the_place_of_a_file_is_told(tmp_path):
    path = tmp_path / 'x.csv'
    path.write_text('<!DOCTYPE html>\n<html><body>404</body></html>\n')
    with pytest.raises(DataError, match='a web page'):
        DataFile(path)
