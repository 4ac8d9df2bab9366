# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The pages for who uses the API or takes the package over name things that exist."""

import re
from pathlib import Path

import pytest

import sosml_friction as sf

ROOT = Path(__file__).resolve().parents[2]
PAGES = ('docs/design.md', 'docs/python.md', 'CONTRIBUTING.md')


@pytest.mark.parametrize('page', PAGES)
def test_links_lead_somewhere(page):
    path = ROOT / page
    targets = re.findall(r'\]\(([^)#]+)', path.read_text())
    assert targets
    assert [x for x in targets if not (path.parent / x).exists()] == []


@pytest.mark.parametrize('page', PAGES)
def test_names_of_the_interface_exist(page):
    text = (ROOT / page).read_text()
    names = set(re.findall(r'\bsf\.(\w+)', text))
    assert names <= set(dir(sf))
    assert page != 'docs/python.md' or names >= set(sf._HOMES) - {
        'Diagnosis', 'Fit', 'Observation', 'Simulation', 'Terms',
    }  # fmt: skip


def test_every_folder_of_the_package_is_in_the_table_of_layers():
    text = (ROOT / 'docs' / 'design.md').read_text()
    folders = [
        x.name for x in (ROOT / 'sosml_friction').iterdir() if (x / '__init__.py').is_file()
    ]
    assert len(folders) > 10
    assert [name for name in folders if f'`{name}/`' not in text] == []
