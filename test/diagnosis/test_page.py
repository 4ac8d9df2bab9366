# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""docs/diagnosis.md says of every effect what the code says, and of none that is not there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sosml_friction.cli.main import main
from sosml_friction.diagnosis.decision.verdict import VERDICTS
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS

PAGE = (Path(__file__).resolve().parents[2] / 'docs' / 'diagnosis.md').read_text()


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the first table below a heading."""
    section = PAGE.split(f'\n## {heading}\n')[1].split('\n## ')[0]
    lines = [line for line in section.splitlines() if line.startswith('|')]
    cells = [re.split(r'(?<!\\)\|', line)[1:-1] for line in lines[2:]]
    return [[cell.strip() for cell in row] for row in cells]


TABLE = {row[0].strip('`'): row for row in rows('The effects')}


def test_the_table_names_exactly_the_registry_and_the_faults_of_data():
    assert sorted(TABLE) == sorted([*searched_terms(), *DATA_CAUSES])
    assert len(rows('The effects')) == len(TABLE)
    assert all(len(row) == 7 for row in TABLE.values())
    assert f'a catalogue of {len(TABLE)}' in PAGE


@pytest.mark.parametrize('name', sorted(searched_terms()))
def test_twins_are_those_of_the_effect(name):
    told = re.findall(r'`(\w+)`( \(I\))?', TABLE[name][4])
    kinds = [TERMS[name], *filter(None, [TERMS[name].counterpart])]
    inseparable = {twin for kind in kinds for twin in kind.inseparable}
    assert {twin for twin, _ in told} == {*TERMS[name].aliases} | inseparable
    assert {twin for twin, mark in told if mark} == inseparable


@pytest.mark.parametrize('name', sorted(TABLE))
def test_where_an_effect_lives_is_where_the_extension_puts_it(name):
    place = TABLE[name][6]
    if name in DATA_CAUSES:
        assert place == 'nowhere'
    elif issubclass(TERMS[name], BodyTerm):
        assert place == ('armature' if name == 'inertia' else 'robot.urdf')
    elif TERMS[name].of_law and TERMS[name].parameter_error:
        assert place == 'law'
    else:
        assert place == (
            'terms, corrected' if issubclass(TERMS[name], MeasurementTerm) else 'terms'
        )


def test_every_verdict_is_explained():
    assert [row[0].strip('`') for row in rows('The verdict')] == list(VERDICTS)


def test_help_names_the_page_and_the_unknown_structure_gate(capsys):
    assert main(['diagnose', '--help']) == 0
    text = ' '.join(capsys.readouterr().out.split())
    assert 'unknown_structure' in text
    assert 'docs/diagnosis.md' in text
