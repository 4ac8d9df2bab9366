# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The example: as script and as notebook the same, and it finds what was put into its data."""

import importlib.util
import json
import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / 'examples'


def make_notebook():
    spec = importlib.util.spec_from_file_location('make_notebook', EXAMPLES / 'make_notebook.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope='module')
def run(tmp_path_factory):
    """Return the names that the script leaves, and the folder in which it ran."""
    folder = tmp_path_factory.mktemp('example')
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv('MPLBACKEND', 'agg')
        return runpy.run_path(str(EXAMPLES / 'pendulum.py')), folder / 'pendulum_output'


def test_the_law_that_was_simulated_is_in_the_intervals_of_the_fit(run):
    names, _ = run
    intervals = names['fit'].conf_int()['pivot']
    for name in ('coulomb', 'viscous'):
        low, high = intervals[name]
        assert low < names[name.upper()] < high
        assert high - low < names[name.upper()]
    # The cogging, which the law lacks, is not taken for a weight that is off.
    low, high = intervals['bias']
    assert low < 0.0 < high


def test_the_diagnosis_names_the_cogging_with_its_size_and_period(run):
    names, _ = run
    (cause,) = names['diagnosis'].causes
    assert (cause.effect, cause.joint) == ('cogging', 'pivot')
    assert cause.parameters['sine'].value == pytest.approx(names['COGGING'], rel=0.1)
    assert cause.parameters['frequency'].value == pytest.approx(names['PERIODS'], rel=0.01)


def test_the_extended_model_halves_the_error_of_the_simulation(run):
    names, _ = run
    diagnosis, log = names['diagnosis'], names['log']
    before = names['sf'].simulate(log, names['fit'].model).found.errors['pivot']
    after = diagnosis.predict(log).found.errors['pivot']
    assert after['position'].rms < 0.5 * before['position'].rms


def test_it_writes_a_figure_a_model_and_a_report(run):
    _, output = run
    assert (output / 'friction.png').stat().st_size > 10_000
    for name in ('model/model.yaml', 'diagnosis/report.html', 'diagnosis/model.yaml'):
        assert (output / name).is_file()


@pytest.mark.parametrize('name', make_notebook().SCRIPTS)
def test_the_notebook_is_the_one_of_the_script(name):
    assert (EXAMPLES / f'{name}.ipynb').read_text() == make_notebook().text_of(name), (
        'make it anew: python examples/make_notebook.py'
    )


def test_the_code_cells_of_the_notebook_hold_all_code_of_the_script():
    cells = json.loads((EXAMPLES / 'pendulum.ipynb').read_text())['cells']
    code = [''.join(cell['source']) for cell in cells if cell['cell_type'] == 'code']
    script = (EXAMPLES / 'pendulum.py').read_text()
    known = [line for line in script.split('# %%', 1)[1].splitlines() if line[:1] not in ('', '#')]
    assert [x for x in '\n'.join(code).splitlines() if x[:1] not in ('', '#')] == known[1:]
