# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of the project's own driver, simulated in closed loop."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from known_robots import slider_model
from lockstep import (
    default_configuration,
    emulated_exoskeleton,
    nominal_robot,
)
from lockstep_run import run_lockstep

from sosml_friction.actuators.driver.configuration import controller_entries
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import controller_tags
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize, serialize_joint_state
from sosml_friction.cli.main import main
from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.model.known_terms import model_friction
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.reference_motion import ReferenceMotion
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_follower import TrajectoryFollower
from sosml_friction.share import share_directory
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.loop_start import LoopReference, find_reference
from sosml_friction.simulation.recorded.pd_drive import PdDrive
from sosml_friction.simulation.recorded.recorded_loop import PdGains, during, recorded_loop

SCHEMA = Path(__file__).resolve().parents[3] / 'docs/schema/simulation.schema.json'
STRING = 'std_msgs/msg/String'


def write_run(folder, log, trajectory, model, entries, sent_ns=0):
    """Write a bag as the identifier does."""
    text = message_class(STRING)()
    with BagRecorder(folder, controller_tags(entries)) as recorder:
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for k, t_ns in enumerate(log.t_ns.tolist()):
            values = (x[k].tolist() for x in (log.q, log.v, log.tau))
            recorder.write('/joint_states', serialize_joint_state(t_ns, log.names, *values), t_ns)
        at = int(log.t_ns[0]) + sent_ns
        texts = {}
        if model is not None:
            texts = {'/robot_description': model.urdf, '/model_description': model.to_yaml()}
        for topic, content in texts.items():
            text.data = content
            recorder.add_topic(topic, STRING)
            recorder.write(topic, serialize(text), at)
        if trajectory is not None:
            message = message_class('trajectory_msgs/msg/JointTrajectory')()
            message.joint_names = list(trajectory.names)
            point = message_class('trajectory_msgs/msg/JointTrajectoryPoint')
            for t, q, v in zip(trajectory.t, trajectory.q, trajectory.v, strict=True):
                own = point(positions=q.tolist(), velocities=v.tolist())
                seconds, own.time_from_start.nanosec = divmod(round(t * 1e9), 1_000_000_000)
                own.time_from_start.sec = seconds
                message.points.append(own)
            recorder.add_topic('/joint_trajectory', 'trajectory_msgs/msg/JointTrajectory')
            recorder.write('/joint_trajectory', serialize(message), at)
    return folder


def simulated(bag, model, log=None):
    opened = Bag.open(bag)
    log = log or opened.joint_log()
    return simulate_model(log, model, loop=recorded_loop(opened, bag, log))


@pytest.mark.parametrize('with_velocity', [True, False])
@pytest.mark.parametrize('first', [0.0, 0.3])
def test_the_reference_is_that_of_the_driver(with_velocity, first):
    rng = np.random.default_rng(3)
    times = first + np.array([0.0, 0.7, 1.1, 2.0])
    q, v = rng.normal(size=(4, 2)), rng.normal(size=(4, 2))
    v[-1] = 0.0
    hold = q[0] + [0.01, -0.02]
    here = hold - 0.003
    wanted = Trajectory(('a', 'b'), times, q, v if with_velocity else None)
    motion = ReferenceMotion(wanted, here)
    if first:
        # What prepare_trajectory makes of it.
        times = np.concatenate([[0.0], times])
        q, v = np.vstack([here, q]), np.vstack([np.zeros(2), v])
    follower = TrajectoryFollower(hold)
    follower.follow(Trajectory(('a', 'b'), times, q, v if with_velocity else None))
    t_ns = np.concatenate([[0], np.sort(rng.integers(1, 2_600_000_000, 400))])
    expected = [follower.sample(int(now)) for now in t_ns]
    for k, got in enumerate(motion.at(t_ns * 1e-9, hold)):
        assert got == pytest.approx(np.array([row[k] for row in expected]), abs=1e-9)
    before = motion.at(np.array([-0.1]), hold)
    assert before[0][0] == pytest.approx(hold)
    assert not np.any(before[1:])


# A slider of mass M under viscous friction B and a constant force: between two commands
# v = v_end + (v_0 - v_end) exp(-B t / M), v_end = (u - F) / B, an exact plant of another kind.
MASS, VISCOUS, FORCE = 95.1089, 200.0, -3.0
PD = {
    'kind': 'pd', 'kp': 4e4, 'kd': 2e3, 'limit': 300.0, 'rate_limit': 1e5, 'rate': 500.0,
    'velocity_window': 11,
}  # fmt: skip


def slider(viscous=VISCOUS):
    return slider_model(0.0, viscous, FORCE)


@pytest.fixture(scope='module')
def uneven(tmp_path_factory):
    """Return a bag whose cycles take 1.2 to 3.2 ms, and when its trajectory began [s]."""
    rng = np.random.default_rng(11)
    steps = rng.uniform(1.2e-3, 2.8e-3, 2600)
    steps[rng.random(2600) < 0.02] = 6e-3
    t = np.cumsum(np.rint(steps * 1e9).astype(np.int64)) * 1e-9
    begin = 9
    times = np.linspace(0.0, 5.0, 101)
    way = 0.05 * (1.0 - np.cos(2.0 * np.pi * times / 2.5))
    rate = 0.05 * 2.0 * np.pi / 2.5 * np.sin(2.0 * np.pi * times / 2.5)
    rate[[0, -1]] = 0.0
    trajectory = Trajectory(('slider',), times, way[:, None], rate[:, None])
    motion = ReferenceMotion(
        Trajectory(('slider',), times, way[:, None], rate[:, None]), np.zeros(1)
    )
    hold = np.array([4e-4])
    q_r, v_r, a_r = (x[:, 0] for x in motion.at(t - t[begin], hold))
    # At rest under a force, the controller leans against its reference.
    q, v, u = hold[0] - FORCE / PD['kp'], 0.0, FORCE
    seen, rows = [], []
    for k in range(len(t)):
        if k:
            h = t[k] - t[k - 1]
            end, fade = (u - FORCE) / VISCOUS, np.exp(-VISCOUS * h / MASS)
            q += end * h + (v - end) * MASS / VISCOUS * (1.0 - fade)
            v = end + (v - end) * fade
        rows.append((q, u))
        if k:
            window = seen[-11:]
            slope = np.polyfit(*np.array(window).T, 1)[0] if len(window) == 11 else 0.0
            wanted = MASS * a_r[k] + PD['kp'] * (q_r[k] - seen[-1][1])
            wanted += PD['kd'] * (v_r[k] - slope)
            u = np.clip(np.clip(wanted, -300.0, 300.0), u - 200.0, u + 200.0)
        # The driver's window begins anew after a long pause; none is so long here.
        seen.append((t[k], q))
    q, tau = np.array(rows).T
    t_ns = 10**9 + np.rint(t * 1e9).astype(np.int64)
    unknown = np.full((len(t), 1), np.nan)
    log = JointLog(('slider',), t_ns, q[:, None], unknown, tau[:, None])
    bag = tmp_path_factory.mktemp('uneven') / 'bag'
    nominal = read_model(share_directory() / 'config/emps')
    write_run(bag, log, trajectory, nominal, {'slider': PD})
    return bag, float(t[begin] - t[0])


def test_an_exact_plant_under_uneven_cycles_is_reproduced(uneven):
    """
    Its law is found to rounding, its motion as well as a command's time is known.

    A cycle is one step of integration with the mean of the commands in it: a change du has its
    impulse, and were its time off by 0.15 ms rms, that were du 0.15 / 2 of force in that cycle.
    White from cycle to cycle it moves the loop, w^2 = kp / M and 2 z w = kd / M + B / M, by x and
    v with x^2 = f^2 T / (4 z w^3 M^2) and v = w x.
    """
    bag, begin = uneven
    log = Bag.open(bag).joint_log()
    reference = find_reference(log, recorded_loop(Bag.open(bag), bag, log))
    assert reference.start == pytest.approx(begin, abs=1e-5)
    assert reference.left['slider'] < 0.5
    found = simulated(bag, slider())
    assert found.mode == 'closed_loop'
    assert found.steps == 1
    force = 0.15 / 2.0 * float(np.std(np.diff(log.tau[:, 0])))
    w = np.sqrt(PD['kp'] / MASS)
    z = 0.5 * (PD['kd'] + VISCOUS) / MASS / w
    x = force * np.sqrt(2e-3 / (4.0 * z * w**3)) / MASS
    errors = found.errors['slider']
    # Of one draw; a command that acts a cycle late makes three times x.
    assert errors['position'].rms < 2.0 * x
    assert errors['effort'].rms < 2.0 * np.hypot(PD['kp'] * x, PD['kd'] * w * x)
    # At the recorded stamps, and all of them but for the first ones.
    assert len(found.time) > 0.97 * len(log)
    assert np.isin(found.time, log.time).all()


def test_a_command_is_limited_and_then_its_change():
    """As in RmdXActuator: 1 N per cycle up to 3 N, from what was reported before."""
    model = slider()
    robot = model.make_robot()
    gains = PdGains(1e3, 0.0, 3.0, 500.0, 500.0, 2)
    cycles = 8
    rows = np.zeros((cycles, 1))
    reference = LoopReference(0.0, rows + 0.1, rows, rows, {})
    stamps = np.arange(cycles) * 2_000_000
    tau = np.full((cycles, 1), -0.5)
    times = np.arange(cycles) - 1.0
    made = [-0.5, 0.5, 1.5, 2.5, 3.0, 3.0, 3.0, 3.0]
    # A cycle reports the command that flowed until then, or two cycles before.
    for delay, reported in ((0.0, made[:-1]), (4e-3, [-0.5, -0.5, *made[:-3]])):
        forward = ForwardModel(robot, model_friction(model), np.ones(1), delay=delay)
        drive = PdDrive(forward, 2e-3, {0: gains}, stamps, times, reference, rows, tau)
        for k in range(cycles - 1):
            drive.begin(k, np.zeros((1, 1)))
        assert np.ravel(drive.commands) == pytest.approx(made)
        assert drive.reported()[:, 0] == pytest.approx(reported)


def test_a_wrong_viscous_friction_shows_by_what_the_controller_has_to_make_up(uneven):
    bag, _ = uneven
    errors = simulated(bag, slider(viscous=VISCOUS + 40.0)).errors['slider']
    # A force of 40 N s/m times the speed, and the way that the gain gives for it.
    speed = 0.05 * 2.0 * np.pi / 2.5 / np.sqrt(2.0)
    assert errors['effort'].rms == pytest.approx(40.0 * speed, rel=0.1)
    assert errors['position'].rms == pytest.approx(40.0 * speed / PD['kp'], rel=0.1)


def test_lost_samples_and_a_gap_are_lived_with(uneven):
    """One sample in fifty is missing, and half a second at one go between 1 s and 3 s."""
    bag, _ = uneven
    log = Bag.open(bag).joint_log()
    rng = np.random.default_rng(5)
    kept = (rng.random(len(log)) > 0.02) & ~((log.time > 1.2) & (log.time < 1.7))
    part = {name: getattr(log, name)[kept] for name in ('t_ns', 'q', 'v', 'tau')}
    found = simulated(bag, slider(), replace(log, **part))
    assert found.mode == 'closed_loop'
    assert np.count_nonzero(found.begins) == 2
    assert not ((found.time > 1.2) & (found.time < 1.7)).any()
    # Where the message of a cycle is lost, its command is: du of force in one cycle of fifty.
    force = np.sqrt(0.02) * float(np.std(np.diff(log.tau[:, 0])))
    assert found.errors['slider']['position'].rms < force / PD['kp']


@pytest.fixture(scope='module')
def emulated(tmp_path_factory):
    """Return a bag of the real driver on the emulated exoskeleton, in emulated time."""
    rest = np.array([-np.pi / 2.0, 0.0])
    times = np.linspace(0.0, 6.0, 121)
    w = 2.0 * np.pi / 3.0
    share = np.sin(0.5 * w * times / 2.0) ** 2
    rate = 0.5 * w * 0.5 * np.sin(0.5 * w * times)
    way = np.array([0.5, 0.6])
    trajectory = Trajectory(
        ('shoulder', 'elbow'), times, rest + share[:, None] * way, rate[:, None] * way
    )
    log = run_lockstep(trajectory, emulated_exoskeleton(seed=7))
    entries = controller_entries(default_configuration(), nominal_robot().limits)
    nominal = read_model(share_directory() / 'config/exoskeleton')
    return write_run(
        tmp_path_factory.mktemp('emulated') / 'bag', log, trajectory, nominal, entries
    )


def arm(coulomb=1.0):
    """Return the model in the emulator, with a share of its shoulder's Coulomb friction."""
    model = read_model(share_directory() / 'config/emulated_exoskeleton')
    shoulder = model.joints['shoulder']
    own = dict(shoulder.friction.parameters)
    own['coulomb'] = replace(own['coulomb'], value=coulomb * own['coulomb'].value)
    shoulder = replace(shoulder, friction=replace(shoulder.friction, parameters=own))
    return replace(model, joints={**model.joints, 'shoulder': shoulder})


def test_the_driver_on_the_emulator_is_followed_and_a_wrong_friction_is_not(emulated):
    true, wrong = simulated(emulated, arm()), simulated(emulated, arm(0.7))
    assert true.mode == wrong.mode == 'closed_loop'
    assert true.followed == ('elbow',)
    assert np.isnan(true.errors['elbow']['position'].rms)
    assert any('elbow moves as recorded' in text for text in true.remarks)
    errors, others = true.errors['shoulder'], wrong.errors['shoulder']
    # 0.24 Nm of Coulomb friction is missing, and the way that kp = 250 Nm/rad gives for it.
    missing = 0.3 * 0.8
    assert others['effort'].rms == pytest.approx(missing, rel=0.15)
    assert others['position'].rms == pytest.approx(missing / 250.0, rel=0.15)
    # Current ripples by 0.03 A at 1.25 Nm/A; the noise of position and velocity, 50 urad and
    # 2.4 mrad/s, is in the commands by kp and kd = 12 Nm s/rad. The simulation has none.
    noise = np.linalg.norm([0.03 * 1.25, 5e-5 * 250.0, 2.4e-3 * 12.0])
    assert errors['effort'].rms < 2.0 * noise
    assert errors['position'].rms < 0.25 * others['position'].rms


def test_the_command_simulates_such_a_bag_in_closed_loop(emulated, tmp_path, capsys):
    arm().write(tmp_path / 'model')
    command = ['simulate', str(emulated), '--model', str(tmp_path / 'model')]
    assert main([*command, '--out', str(tmp_path / 'out'), '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    assert not list(Draft202012Validator(json.loads(SCHEMA.read_text())).iter_errors(document))
    assert document['mode'] == 'closed_loop'
    assert not document['joints']['elbow']['driven']
    assert document['joints']['shoulder']['driven']
    assert '<svg' in (tmp_path / 'out/report.html').read_text()


def test_what_was_before_the_robot_was_enabled_is_left_out(emulated):
    """Two seconds at rest without a command, as ros2 bag record may have them, change nothing."""
    opened = Bag.open(emulated)
    log = opened.joint_log()
    loop = recorded_loop(opened, emulated, log)
    count = 1000
    early = log.t_ns[0] + (np.arange(-count, 0) * 2_000_000)
    first = np.repeat(log.q[:1], count, axis=0)
    longer = replace(
        log,
        t_ns=np.concatenate([early, log.t_ns]),
        q=np.vstack([first, log.q]),
        v=np.vstack([np.zeros_like(first), log.v]),
        # As if something had pushed, of which the law knows nothing.
        tau=np.vstack([np.full_like(first, 2.0), log.tau]),
    )
    part, own = during(longer, replace(loop, sent=loop.sent + 2.0))
    assert part.time[-1] == pytest.approx(log.time[-1] + 0.1, abs=5e-3)
    assert own.sent == pytest.approx(0.1, abs=5e-3)
    found = simulate_model(longer, arm(), loop=replace(loop, sent=loop.sent + 2.0))
    assert found.mode == 'closed_loop'


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'trajectory': None}, 'no trajectory'),
        ({'kp': 60.0}, 'do not make the recorded effort of shoulder'),
        ({'rate': 2000.0}, 'ran at 2000 Hz and was recorded at 500 Hz'),
        ({'model': 'torn'}, "the driver's own model"),
        ({'kind': 'actuator'}, 'in the actuators and not known'),
    ],
)
def test_where_something_is_missing_it_is_windows_and_a_sentence(
    emulated, tmp_path, change, words
):
    opened = Bag.open(emulated)
    log = opened.joint_log()
    part = {name: getattr(log, name)[:1500] for name in ('t_ns', 'q', 'v', 'tau')}
    sent = opened.trajectories()[0]
    trajectory = Trajectory(sent.names, sent.times, sent.positions, sent.velocities)
    entries = controller_entries(default_configuration(), nominal_robot().limits)
    entries['shoulder'] |= {key: change[key] for key in ('kp', 'rate') if key in change}
    if 'kind' in change:
        entries['shoulder'] = change
    bag = write_run(
        tmp_path / 'bag',
        replace(log, **part),
        change.get('trajectory', trajectory),
        read_model(share_directory() / 'config/exoskeleton') if 'model' not in change else None,
        entries,
    )
    found = simulated(bag, arm())
    assert found.mode == 'windows'
    assert words in found.why_not
    # Then every joint with effort is driven by it.
    assert found.followed == ()
