# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The installed data is found whichever way the package was installed, and belongs to its code."""

import sys

import pytest

import sosml_friction.share as share_module
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.share import share_directory


def make_share(prefix):
    share = prefix / 'share' / 'sosml_friction'
    (share / 'config').mkdir(parents=True)
    return share


def make_module(prefix, monkeypatch):
    package = prefix / 'lib' / 'python3.12' / 'site-packages' / 'sosml_friction'
    package.mkdir(parents=True)
    monkeypatch.setattr(share_module, '__file__', str(package / 'share.py'))


def test_share_is_the_source_tree_for_code_that_runs_from_it(monkeypatch, tmp_path):
    source = tmp_path / 'checkout'
    (source / 'config').mkdir(parents=True)
    (source / 'package.xml').write_text('<package/>')
    monkeypatch.setattr(share_module, '__file__', str(source / 'sosml_friction' / 'share.py'))
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(make_share(tmp_path / 'ament').parents[1]))
    assert share_directory() == source


@pytest.mark.parametrize('name', ['opt', 'sosml_friction'])
def test_share_beside_installed_code_comes_before_any_other(monkeypatch, tmp_path, name):
    """Also when the prefix has the package's name, as in an isolated colcon workspace."""
    make_module(tmp_path / name, monkeypatch)
    own = make_share(tmp_path / name)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(make_share(tmp_path / 'ament').parents[1]))
    monkeypatch.setattr(sys, 'prefix', str(make_share(tmp_path / 'python').parents[1]))
    assert share_directory() == own


def test_share_in_the_ament_prefixes_comes_before_that_of_the_interpreter(monkeypatch, tmp_path):
    make_module(tmp_path / 'bare', monkeypatch)
    ament = make_share(tmp_path / 'ament')
    python = make_share(tmp_path / 'python')
    monkeypatch.setattr(sys, 'prefix', str(tmp_path / 'python'))
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{tmp_path / "other"}:{tmp_path / "ament"}')
    assert share_directory() == ament
    monkeypatch.delenv('AMENT_PREFIX_PATH')
    assert share_directory() == python


def test_missing_share_is_one_sentence_that_says_where_it_looked(monkeypatch, tmp_path):
    make_module(tmp_path / 'bare', monkeypatch)
    monkeypatch.setattr(sys, 'prefix', str(tmp_path / 'python'))
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    with pytest.raises(ConfigurationError, match=r'install the package again$') as error:
        share_directory()
    assert str(tmp_path / 'bare') in str(error.value)
