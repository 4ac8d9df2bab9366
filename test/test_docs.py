# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The pages say what the code says: terms, lists, files, and an example that is one term."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
import typer

import sosml_friction
from sosml_friction.cli.main import app
from sosml_friction.model.laws import TERM_LISTS
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import TERMS
from validation.constants import constants, constants_document
from validation.terms_table import terms_document

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob('*.md'), *(ROOT / 'docs').glob('*.md')])
#: Folders that a path in a page begins with; below the package, it may leave that away.
FOLDERS = ('test', 'validation', 'benchmarks', 'examples', 'config', 'docs', 'launch', 'urdf')
INNER = tuple(
    path.name for path in (ROOT / 'sosml_friction').iterdir() if (path / '__init__.py').is_file()
)
SYMBOLS = {
    'coulomb': 'C s', 'viscous': "B q'", 'stribeck': 'S s e', 'load_dependent_friction': 'k L s',
    'load_dependent_stribeck': 'k_s L s e', 'quadratic_load_friction': 'k_2 L^2 s',
    'directional_load_friction': '(k_d d_m + k_b (1 - d_m)) L s',
}  # fmt: skip


def test_the_page_of_terms_is_what_the_terms_say():
    """Run ``python -m validation.terms_table > docs/terms.md`` if it fails."""
    assert (ROOT / 'docs' / 'terms.md').read_text() == terms_document()


def test_the_page_of_constants_is_what_the_sources_say():
    """Run ``python -m validation.constants > docs/constants.md`` if it fails."""
    assert (ROOT / 'docs' / 'constants.md').read_text() == constants_document()


def test_every_constant_of_the_diagnosis_says_what_it_is():
    assert [number.label for number in constants() if not number.comment] == []


def test_every_term_and_every_parameter_is_in_the_table():
    rows = [line for line in terms_document().splitlines() if line.startswith('| `')]
    cells = [re.split(r'(?<!\\)\|', row)[1:-1] for row in rows]
    found = {row[0].strip(' `'): row for row in cells if len(row) == 7}
    assert sorted(found) == sorted(TERMS)
    for name, kind in TERMS.classes.items():
        told = re.findall(r'`(\w+)` \[', found[name][2])
        assert told == [*kind.amplitudes, *kind.inner]
        assert '{' not in found[name][2]
        assert (found[name][6].strip() == 'yes') == kind.searched


@pytest.mark.parametrize('page', PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(page):
    targets = re.findall(r'\]\((?!https?:)([^)#]+)', page.read_text())
    # The site makes these of the code.
    made = re.findall(
        r"'(\w+)': \w+", (ROOT / 'docs' / 'hooks.py').read_text().split('PAGES =')[1]
    )
    targets = [x for x in targets if x not in {f'reference/{name}.md' for name in made}]
    assert [x for x in targets if not (page.parent / x).exists()] == []


@pytest.mark.parametrize('page', PAGES, ids=lambda path: path.name)
def test_files_and_folders_that_a_page_names_exist(page):
    named = re.findall(r'[\w./]+/[\w./]*', page.read_text())
    missing = []
    for path in {x.rstrip('.') for x in named}:
        first, _, rest = path.partition('/')
        # NAME and REPORT stand for any; a sentence may join words by a stroke.
        if re.search(r'\b[A-Z]{3,}\b', path) or not (rest == '' or re.search(r'\.\w+$|/$', path)):
            continue
        known = first in (*FOLDERS, *INNER, 'sosml_friction')
        places = (ROOT, ROOT / 'sosml_friction', page.parent)
        if known and not any((place / path).exists() for place in places):
            missing.append(path)
    assert sorted(missing) == []


def commands(page):
    """Return the lines of a page's code blocks that call the tool, as lists of words."""
    blocks = re.findall(r'^```(?:sh)?\n(.+?)^```', page.read_text(), re.DOTALL | re.MULTILINE)
    lines = '\n'.join(blocks).replace('\\\n', ' ').splitlines()
    return [shlex.split(x, comments=True)[1:] for x in lines if x.startswith('sosml ')]


@pytest.mark.parametrize('page', PAGES, ids=lambda path: path.name)
def test_commands_and_options_that_a_page_shows_exist(page):
    for words in commands(page):
        command, rest = typer.main.get_command(app), list(words)
        while rest and hasattr(command, 'commands'):
            assert rest[0] in command.commands, ' '.join(words)
            command = command.commands[rest.pop(0)]
        known = {name for p in command.params for name in (*p.opts, *p.secondary_opts)}
        known |= {'--help', '-h'}
        stated = {word.partition('=')[0] for word in rest if re.match(r'--?[a-z]', word)}
        assert stated <= known, ' '.join(words)


def test_pages_that_are_to_show_commands_do():
    for name in (
        'README.md',
        'docs/tutorial_csv.md',
        'docs/tutorial_emulator.md',
        'docs/how_to.md',
    ):
        assert len(commands(ROOT / name)) >= 3


def test_jobs_that_need_no_recording_are_done_as_the_page_says(sosml, tmp_path):
    shutil.copy(ROOT / 'urdf' / 'exoskeleton.urdf', tmp_path / 'robot.urdf')
    ran = 0
    for words in commands(ROOT / 'docs' / 'how_to.md'):
        if '--help' in words or words[0] in ('trajectory', 'model'):
            code, _, err = sosml(*words)
            assert code == 0, err
            ran += 1
    assert ran >= 5
    assert (tmp_path / 'ladder.png').read_bytes().startswith(b'\x89PNG')
    assert (tmp_path / 'robot_model' / 'model.yaml').is_file()


def test_the_citation_has_the_version_of_the_package():
    text = (ROOT / 'CITATION.cff').read_text()
    assert f'version: {sosml_friction.__version__}\n' in text


def test_every_page_is_on_the_site():
    listed = re.findall(r': ([\w/]+\.md)$', (ROOT / 'mkdocs.yml').read_text(), re.MULTILINE)
    pages = {path.name for path in (ROOT / 'docs').glob('*.md')}
    assert {name for name in listed if not name.startswith('reference/')} == pages


def test_the_equations_of_the_lists_are_their_terms():
    text = (ROOT / 'docs' / 'identification.md').read_text()
    written = dict(re.findall(r'^\| `(m\d)` \| (.+) \|$', text, re.MULTILINE))
    assert list(written) == list(TERM_LISTS)
    for name, terms in TERM_LISTS.items():
        whole = name
        while re.search(r'm\d', whole):
            whole = re.sub(r'm\d', lambda m: written[m[0]], whole)
        assert whole == ' + '.join(SYMBOLS[term] for term in terms)


def test_the_example_of_a_term_is_a_term():
    text = (ROOT / 'docs' / 'diagnosis.md').read_text()
    (source,) = re.findall(r'```python\n(.+?)```', text, re.DOTALL)
    names = {'__name__': 'page'}
    try:
        exec(source, names)
        kind = TERMS['drag']
        assert issubclass(kind, EffortTerm)
        v = np.array([[-2.0], [3.0]])
        (effort,) = kind().effort(Motion.steady(v, np.sign(v)), 0, {}, np.zeros((2, 0)))
        assert effort.tolist() == [-4.0, 9.0]
        assert kind.unit('drag', 'N') == 'N s2/m2'
    finally:
        TERMS.remove('drag')
