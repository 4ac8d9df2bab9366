# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml simulate``: closed loop and windows, files, schema, exit codes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from full_runs import in_full
from jsonschema import Draft202012Validator
from known_robots import coulomb_viscous

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.cli.main import main
from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.model.model_folder import (
    EffectTerm,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory
from sosml_friction.simulation.cascade_loop import CascadeController, simulate_closed_loop
from sosml_friction.simulation.recorded.controlled_joint import recorded_controllers

SCHEMA = Path(__file__).resolve().parents[2] / 'docs/schema/simulation.schema.json'
STEP, MASS, COULOMB, VISCOUS, BIAS = 2e-3, 95.1089, 20.0, 200.0, -3.0
GAINS = {'kp': 50.0, 'kv': 100.0, 'scale': 35.0, 'limit': 10.0}


def make_model(viscous=VISCOUS, effects=(), friction=True):
    model = read_model(share_directory() / 'config/emps')
    slider = replace(model.joints['slider'], friction=None)
    if friction:
        slider = replace(slider, friction=coulomb_viscous(COULOMB, viscous, BIAS, 'N', 'm'))
    return replace(model, joints={'slider': slider}, effects=tuple(effects))


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    """Return a bag of a slider under its controller, by another integrator and a smooth sign."""
    t = np.arange(0.0, 8.0, STEP)
    reference = 0.05 * (1.0 - np.cos(1.5 * t)) + 0.01 * np.sin(4.0 * t) ** 2
    parameters = {'inertia': MASS, 'viscous': VISCOUS, 'coulomb': COULOMB, 'bias': BIAS}
    run = simulate_closed_loop(reference, STEP, CascadeController(**GAINS), parameters, 0.0, 1e-4)
    t_ns = np.rint(t * 1e9).astype(np.int64)
    unknown = np.full((len(t), 1), np.nan)
    tags = {'controller.slider': json.dumps(GAINS)}
    log = JointLog(('slider',), t_ns, run.q[:, None], unknown, run.effort[:, None], tags=tags)
    bag = tmp_path_factory.mktemp('recording') / 'bag'
    return write_joint_log(log, bag, reference=reference[:, None])


@pytest.fixture
def folder(tmp_path):
    def write(model):
        model.write(tmp_path / 'model')
        return str(tmp_path / 'model')

    return write


def run(recording, *more, capsys):
    code = main(['simulate', str(recording), *more])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_the_closed_loop_of_the_true_model_is_the_recording(recording, folder, tmp_path, capsys):
    out = tmp_path / 'out'
    code, stdout, _ = run(
        recording, '--model', folder(make_model()), '--out', str(out), '--json', capsys=capsys
    )
    assert code == 0
    document = json.loads(stdout)
    assert not list(Draft202012Validator(json.loads(SCHEMA.read_text())).iter_errors(document))
    assert {**json.loads((out / 'simulation.json').read_text()), 'output': str(out)} == document
    assert document['mode'] == 'closed_loop'
    errors = document['joints']['slider']['errors']
    # Friction over a displacement is not friction over a velocity: at each reversal, for a moment.
    assert errors['position']['relative_percent'] < 0.01
    assert errors['effort']['relative_percent'] < 2.0
    assert '<svg' in (out / 'report.html').read_text()


def test_a_wrong_viscous_friction_shows_in_closed_loop_and_in_windows(
    recording, folder, tmp_path, capsys
):
    model = folder(make_model(viscous=400.0))
    for more, what in (((), 'closed loop'), (('--horizon', '0.3'), 'windows of 0.3 s')):
        code, stdout, _ = run(
            recording, '--model', model, '--out', str(tmp_path / 'out'), *more, capsys=capsys
        )
        assert code == 0
        assert what in stdout.splitlines()[0]
        document = json.loads((tmp_path / 'out/simulation.json').read_text())
        errors = document['joints']['slider']['errors']
        # 200 N s/m of which the speed's root mean square is 0.06 m/s, beside some 25 N.
        assert 20.0 < errors['effort']['relative_percent'] < 60.0
        if more:
            # v(t) lags by 200 v t / M: after 0.3 s by 0.63 t v, the way by half of that.
            assert 10.0 < errors['position']['relative_percent'] < 40.0


def test_the_effects_of_the_model_take_part(recording):
    """Half of viscous friction as an effect is the same as all of it in the law."""
    bag = Bag.open(recording)
    log = bag.joint_log()
    controlled = recorded_controllers(bag, log)
    change = {'change': Parameter(0.5 * VISCOUS, 'N s/m')}
    model = make_model(0.5 * VISCOUS, [EffectTerm('viscous', 'slider', change)])
    split = simulate_model(log, model, controlled)
    whole = simulate_model(log, make_model(), controlled)
    assert split.mode == 'closed_loop'
    for what in ('position', 'effort'):
        assert split.simulated[what] == pytest.approx(whole.simulated[what], abs=1e-9)


@pytest.mark.parametrize('delay', [4e-3, in_full(-4e-3)])
def test_an_effort_that_is_late_beside_position_is_late_in_the_simulated_report(recording, delay):
    bag = Bag.open(recording)
    log = bag.joint_log()
    controlled = recorded_controllers(bag, log)
    known = {'delay': Parameter(delay, 's')}
    model = make_model(effects=[EffectTerm('effort_delay', '*', known)])
    late = simulate_model(log, model, controlled).simulated['effort'][:, 0]
    plain = simulate_model(log, make_model(), controlled).simulated['effort'][:, 0]
    shift = round(delay / STEP)
    # Without a delay it is reported when it was recorded, and not a sample before or after.
    apart = [np.std(plain[10 + k : k - 10] - log.tau[10:-10, 0]) for k in (-1, 0, 1)]
    assert np.argmin(apart) == 1
    if shift > 0:
        # What the controller asked for does not change, and is reported two samples later.
        assert late[10:] == pytest.approx(plain[10 - shift : -shift], abs=1e-9)
    else:
        # It acts two samples later: the loop rings, and asks for more.
        assert np.std(late) > np.std(plain)


def test_without_its_controller_a_recording_is_simulated_in_windows_and_says_so(
    recording, folder, tmp_path, capsys
):
    log = replace(Bag.open(recording).joint_log(), tags={})
    bag = write_joint_log(log, tmp_path / 'plain')
    code, stdout, _ = run(
        bag, '--model', folder(make_model(friction=False)), '--out', str(tmp_path / 'out'),
        capsys=capsys,
    )  # fmt: skip
    assert code == 0
    first = stdout.splitlines()[0]
    assert 'because the closed loop needs' in first
    assert 'has none of slider' in first
    assert 'no friction in the model' in stdout


@pytest.mark.parametrize(
    ('more', 'what'),
    [
        (('--horizon', '0'), 'horizon is 0 s'),
        (('--horizon', '50'), 'shorter --horizon'),
        (('--model', '/nowhere'), '/nowhere'),
    ],
)
def test_bad_input_ends_with_code_2_a_sentence_and_nothing_written(
    recording, folder, tmp_path, more, what, capsys
):
    if '--model' not in more:
        more = (*more, '--model', folder(make_model()))
    code, _, stderr = run(recording, '--out', str(tmp_path / 'out'), *more, capsys=capsys)
    assert code == 2
    assert what in stderr
    assert len(stderr.strip().splitlines()) == 1
    assert not (tmp_path / 'out').exists()


def test_a_model_that_runs_away_is_no_result(recording, folder, tmp_path, capsys):
    pushed = {'stiffness': Parameter(-1e7, 'N/m'), 'offset': Parameter(0.0, 'N')}
    model = folder(make_model(effects=[EffectTerm('spring', 'slider', pushed)]))
    code, _, stderr = run(
        recording, '--model', model, '--out', str(tmp_path / 'out'), capsys=capsys
    )
    assert code == 2
    assert 'runs away' in stderr
    assert not (tmp_path / 'out').exists()


def test_a_bag_that_was_cut_off_says_so(recording, folder, tmp_path, capsys):
    cut = tmp_path / 'cut.mcap'
    content = next(recording.glob('*.mcap')).read_bytes()
    cut.write_bytes(content[: 3 * len(content) // 4])
    model = folder(make_model())
    code, stdout, _ = run(
        cut, '--model', model, '--out', str(tmp_path / 'out'), capsys=capsys
    )  # fmt: skip
    assert code == 0
    assert 'up to the last whole one, were read' in ' '.join(stdout.split())
    document = json.loads((tmp_path / 'out' / 'simulation.json').read_text())
    assert 'was not closed or is damaged' in document['remarks'][0]


def test_a_place_that_cannot_be_written_is_refused_before_the_bag_is_read(tmp_path, capsys):
    code, _, stderr = run(tmp_path / 'no_bag', '--out', '/proc/nowhere', capsys=capsys)
    assert code == 2
    assert 'cannot be written' in stderr
