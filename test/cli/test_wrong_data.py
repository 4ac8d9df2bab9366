# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Wrong data through the tool: a sentence, an exit code, and nothing that looks like a result.

The right data are a speed ladder of the EMPS axis with 20 N of Coulomb and 200 N s/m of viscous
friction; each case spoils them in one way.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from slider_bags import COULOMB, EMPS, VISCOUS, slider_log

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import serialize_joint_state
from sosml_friction.cli import main as cli
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.share import share_directory

EXOSKELETON = share_directory() / 'config' / 'exoskeleton'
PERIOD = 0.004


def good_log() -> JointLog:
    """Return a ladder of three speeds, 0.3 N of noise on effort, an encoder of 2 um."""
    log = slider_log()
    return replace(log, t_ns=log.t_ns + 10**9, q=2e-6 * np.round(log.q / 2e-6))


def rows(log: JointLog, which) -> JointLog:
    return replace(log, t_ns=log.t_ns[which], q=log.q[which], v=log.v[which], tau=log.tau[which])


@pytest.fixture(scope='module')
def good() -> JointLog:
    return good_log()


def record(log: JointLog, folder, model=EMPS, described=True):
    """Write a bag message by message: stamps need not rise."""
    nominal = read_model(model)
    stamps = log.t_ns
    plain = replace(log, t_ns=10**9 + np.arange(len(log)) * 10**6)
    if (np.diff(stamps) > 0).all():
        return write_joint_log(
            log,
            folder,
            nominal.urdf if described else None,
            (model / 'model.yaml').read_text() if described else None,
        )
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for k, stamp in enumerate(stamps.tolist()):
            message = serialize_joint_state(
                stamp, log.names, *(x[k].tolist() for x in (log.q, log.v, log.tau))
            )
            recorder.write('/joint_states', message, int(plain.t_ns[k]))
    return folder


@pytest.fixture
def fit(monkeypatch, tmp_path, capsys):
    """Return a function that fits a log: (exit code, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(log, *options, model=EMPS):
        bag = record(log, tmp_path / 'bag', model)
        given = options or ('--model', str(model))
        code = cli.main(['fit', str(bag), '--out', 'result', '--body-tolerance', '0', *given])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def still(log):
    return replace(log, q=np.full_like(log.q, 0.1), v=0.0 * log.v)


def trembling(log):
    """A joint that is held, its encoder on the edge of a count."""
    flicker = np.random.default_rng(0).integers(0, 2, log.q.shape)
    return replace(log, q=0.1 + 2e-6 * flicker, v=0.0 * log.v)


def forwards_only(log):
    """The effort of every movement backwards is missing."""
    return replace(log, tau=np.where(log.v < 0.0, np.nan, log.tau))


def clipped(log):
    return replace(log, tau=np.clip(log.tau, -22.0, 22.0))


def ten_samples(log):
    return rows(log, slice(500, 510))


def without_effort(log):
    return replace(log, tau=np.full_like(log.tau, np.nan))


def effort_of_zero(log):
    return replace(log, tau=np.zeros_like(log.tau))


def in_millimetres(log):
    return replace(log, q=1e3 * log.q, v=1e3 * log.v)


def speed_in_millimetres(log):
    return replace(log, v=1e3 * log.v)


def turned_effort(log):
    return replace(log, tau=-log.tau)


def coarse_stamps(log):
    """A driver that stamps five samples alike."""
    return replace(log, t_ns=log.t_ns[np.arange(len(log)) // 5 * 5])


def three_passes(log):
    """A bag in which three recordings follow each other with the same stamps."""
    third = len(log) // 3
    return replace(log, t_ns=log.t_ns[np.arange(len(log)) % third])


def without_position(log):
    return replace(log, q=np.full_like(log.q, np.nan))


def name_of(value):
    """Name a case after what spoils it."""
    return getattr(value, '__name__', '')


REFUSED = [
    (still, 'joint slider does not move', 'record motion in both directions'),
    (trembling, 'joint slider does not move', 'record motion in both directions'),
    (forwards_only, 'one direction only (forwards', 'record motion in both directions'),
    (clipped, 'stays at its extreme of 22 N in', 'raise the limit'),
    (ten_samples, '10 usable samples over 0.036 s', 'record a trajectory'),
    (without_effort, 'joint_states carries no effort for slider', 'let the driver fill'),
    (effort_of_zero, 'the effort of joint slider is 0 N in every sample', 'let the driver fill'),
    (in_millimetres, 'its URDF allows', 'convert millimetres to m'),
    (turned_effort, 'friction would drive it', 'turn the sign of its effort'),
    (coarse_stamps, 'repeat the stamp of the one before', 'stamp each sample'),
    (three_passes, 'the stamps go back', 'one pass'),
    (without_position, 'joint slider has no position', 'let its driver report it'),
]


@pytest.mark.parametrize(('spoil', 'wrong', 'remedy'), REFUSED, ids=name_of)
def test_wrong_data_end_in_one_sentence_and_leave_nothing(
    fit, good, tmp_path, spoil, wrong, remedy
):
    code, out, err = fit(spoil(good))
    assert code in (1, 2)
    assert out == ''
    assert err.count('\n') == 1
    assert 'Traceback' not in err
    assert wrong in err
    assert remedy in err
    assert [p.name for p in tmp_path.iterdir()] == ['bag']


def test_wrong_data_leave_an_earlier_result_as_it_was(fit, good, tmp_path):
    assert fit(good)[0] == 0
    before = {p: p.read_bytes() for p in sorted((tmp_path / 'result').rglob('*')) if p.is_file()}
    (tmp_path / 'bag').rename(tmp_path / 'good')
    assert fit(turned_effort(good))[0] == 2
    after = {p: p.read_bytes() for p in sorted((tmp_path / 'result').rglob('*')) if p.is_file()}
    assert after == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ['bag', 'good', 'result']


def nan_runs(log):
    """Ten runs of 40 samples without position, and as many single ones without effort."""
    q, tau = log.q.copy(), log.tau.copy()
    for k in np.linspace(300, len(log) - 300, 10).astype(int):
        q[k : k + 40] = np.nan
        tau[k - 100] = np.nan
    return replace(log, q=q, tau=tau)


def some_repeated(log):
    """Every fiftieth message twice."""
    return rows(log, np.sort(np.r_[np.arange(len(log)), np.arange(0, len(log), 50)]))


def some_late(log):
    """Every fiftieth message after its successor."""
    order = np.arange(len(log))
    at = np.arange(10, len(log) - 2, 50)
    order[at], order[at + 1] = at + 1, at
    return rows(log, order)


def clock_set(log):
    """The clock goes back by a minute when a fifth of the recording is done."""
    late = np.arange(len(log)) < len(log) // 5
    return replace(log, t_ns=log.t_ns + np.where(late, 60_000_000_000, 0))


def some_saturated(log):
    """The controller's limit is reached in the fastest ramps."""
    return replace(log, tau=np.clip(log.tau, -80.0, 80.0))


PARTLY = [
    (nan_runs, 'lack a position of slider and are left out, up to 40 in a row', 'incomplete'),
    (some_repeated, 'repeat the stamp of the one before and are left out', 'repeated_stamps'),
    (some_late, '', 'backward_stamps'),
    (clock_set, 'outside the longest stretch are left out', 'backward_stamps'),
    (some_saturated, 'stays at its extreme in', 'saturation'),
    (speed_in_millimetres, 'times the slope of its position, in mm/s', 'velocity_unit'),
]


@pytest.mark.parametrize(('spoil', 'told', 'check'), PARTLY, ids=name_of)
def test_what_is_usable_is_fitted_and_what_is_not_is_counted(
    fit, good, tmp_path, spoil, told, check
):
    """Coulomb within 0.5 % and viscous within 2 %: three times what good data are off by."""
    code, _, err = fit(spoil(good))
    assert code == 0, err
    document = json.loads((tmp_path / 'result' / 'fit.json').read_text())
    parameters = document['joints']['slider']['sosml']['parameters']
    assert parameters['coulomb']['value'] == pytest.approx(COULOMB, rel=0.005)
    assert parameters['viscous']['value'] == pytest.approx(VISCOUS, rel=0.02)
    findings = document['data_checks']['findings']
    assert any(check in finding['check'] for finding in findings)
    assert told in err
    assert told in ''.join(finding['sentence'] for finding in findings)


def test_a_bag_cut_off_at_half_is_fitted_with_a_remark(good, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bag = record(good, tmp_path / 'bag')
    (file,) = bag.glob('*.mcap')
    file.write_bytes(file.read_bytes()[: 6 * file.stat().st_size // 10])
    assert cli.main(['fit', str(bag), '--out', 'result']) == 0
    assert 'up to the last whole one, were read' in capsys.readouterr().err


def test_a_bag_cut_off_before_anything_moved_says_how_much_is_left(
    good, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    bag = record(good, tmp_path / 'bag')
    (file,) = bag.glob('*.mcap')
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 20])
    assert cli.main(['fit', str(bag), '--out', 'result']) == 2
    err = capsys.readouterr().err
    assert err.count('\n') == 1
    assert 'usable samples over' in err
    assert not (tmp_path / 'result').exists()


def test_a_bag_with_joint_states_alone_says_what_it_needs(good, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bag = record(good, tmp_path / 'bag', described=False)
    assert cli.main(['fit', str(bag), '--out', 'result']) == 2
    err = capsys.readouterr().err
    assert err.count('\n') == 1
    assert 'give a URDF with --urdf' in err
    assert not (tmp_path / 'result').exists()


def arm_log(elbow_moves=True, speeds=(0.05, 0.2, 0.5)) -> JointLog:
    """Return the shoulder's ladder on the default arm, with friction on both joints."""
    robot = read_model(EXOSKELETON).make_robot()
    start = {'shoulder': -1.5, 'elbow': 1.2}
    ladder = speed_ladder(start, start, speeds, 0.6, scale=(1.0, float(elbow_moves)))
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, PERIOD)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += 0.5 * np.sign(v) + 0.2 * v + np.random.default_rng(3).normal(0.0, 0.01, v.shape)
    return JointLog(robot.names, np.rint(t * 1e9).astype(np.int64) + 10**9, q, v, tau)


def test_a_joint_that_is_missing_is_named(fit):
    log = arm_log().select(['shoulder'])
    code, _, err = fit(log, '--model', str(EXOSKELETON), model=EXOSKELETON)
    assert code == 2
    assert err.count('\n') == 1
    assert 'joint elbow is not in the recording' in err


def test_joints_in_messages_of_their_own_are_fitted(fit, tmp_path):
    """Two publishers, one joint each, in turn: the other one is interpolated."""
    log = arm_log()
    q, v, tau = (x.copy() for x in (log.q, log.v, log.tau))
    for x in (q, v, tau):
        x[::2, 0], x[1::2, 1] = np.nan, np.nan
    log = replace(log, q=q, v=v, tau=tau)
    code, _, err = fit(log, '--model', str(EXOSKELETON), model=EXOSKELETON)
    assert code == 0, err
    document = json.loads((tmp_path / 'result' / 'fit.json').read_text())
    for joint in log.names:
        coulomb = document['joints'][joint]['sosml']['parameters']['coulomb']
        low, high = coulomb['interval']
        assert low < 0.5 < high
    found = {finding['check'] for finding in document['data_checks']['findings']}
    assert found >= {'sparse_position', 'sparse_effort'}


def test_one_joint_that_cannot_be_fitted_is_a_no_and_the_other_is_fitted(fit, tmp_path):
    log = arm_log(elbow_moves=False)
    code = fit(log, '--model', str(EXOSKELETON), model=EXOSKELETON)[0]
    assert code == 1
    document = json.loads((tmp_path / 'result' / 'fit.json').read_text())
    assert set(document['joints']) == {'shoulder'}
    assert 'joint elbow does not move' in document['unavailable']['elbow']


@pytest.mark.parametrize(
    ('once_more', 'said'),
    [(np.rad2deg, 'is in degrees:'), (np.deg2rad, 'is in rad that were taken for degrees:')],
)
def test_a_position_in_another_unit_than_was_stated_is_refused(fit, once_more, said):
    log = arm_log()
    log = replace(log, q=once_more(log.q), v=once_more(log.v))
    code, _, err = fit(log, '--model', str(EXOSKELETON), model=EXOSKELETON)
    assert code == 2
    assert err.count('\n') == 1
    assert said in err
    assert 'state its own unit' in err


@pytest.mark.filterwarnings('error::RuntimeWarning')
def test_efforts_that_come_far_too_seldom_for_the_motion_end_in_no_traceback(fit):
    """At 19 Hz the filter of velocities runs away, and those of the positions are used."""
    log = arm_log(speeds=(0.05, 0.1, 0.2, 0.3, 0.5, 0.7))
    tau = np.full_like(log.tau, np.nan)
    tau[::13] = log.tau[::13]
    code, _, err = fit(replace(log, tau=tau), '--model', str(EXOSKELETON), model=EXOSKELETON)
    assert code in (0, 1)
    assert 'is not in each sample, of shoulder at 19.2 Hz' in err
    assert 'Traceback' not in err
