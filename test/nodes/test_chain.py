# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The whole chain: emulator, driver, observers and identifier as processes, CAN bytes over TCP, DDS.

One run at 500 Hz serves all tests here, of 60 s in ``make validate`` and 31 s else. It is one of
real time on a machine that may be busy, and judged by wiring, counts, order and flags; numbers are
judged in emulated time (``test_emulated_t1.py``, ``test_busy_machine.py``).
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from full_runs import FULL
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import read_controllers
from sosml_friction.bags.serialization import deserialize
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.nodes.demo import run_chain
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.share import share_directory
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop, recorded_loop
from validation.busy import judge, replayed

PARAMETERS = share_directory() / 'config' / 'exoskeleton.yaml'
OBSERVERS = ('first_order', 'sosml')
#: The least length of the run [s], and the plateaus that make it with the speeds of T1 [s].
LEAST, PLATEAU = (60.0, 1.6) if FULL else (31.0, 0.4)


@pytest.fixture(scope='module')
def phases() -> list[str]:
    return []


@pytest.fixture(scope='module')
def run(tmp_path_factory: pytest.TempPathFactory, phases: list[str]) -> Path:
    """Return the folder of a finished run."""

    def note(what, share=None) -> None:
        if not phases or phases[-1] != what:
            phases.append(what)

    return run_chain(tmp_path_factory.mktemp('chain'), 1, note, plateau=PLATEAU)


@pytest.fixture(scope='module')
def bag(run: Path) -> Bag:
    return Bag.open(run / 'bag')


def stamps(bag: Bag, topic: str) -> np.ndarray:
    return bag.joint_log(topic).t_ns


def test_every_sample_of_the_run_at_500_hz_has_its_estimates(bag):
    """
    None is lost between driver, observers and recorder, and none comes twice.

    The driver publishes one message per completed cycle; on a busy machine it completes fewer
    than 500 a second, which is its to count, so only the span is judged here, not the number.
    """
    sampled = stamps(bag, '/joint_states')
    assert (sampled[-1] - sampled[0]) * 1e-9 >= LEAST
    assert (np.diff(sampled) > 0).all()
    for topic in ('/friction_estimate', *(f'/friction_estimate/{name}' for name in OBSERVERS)):
        np.testing.assert_array_equal(stamps(bag, topic), sampled, err_msg=topic)


def estimates(bag):
    """Return what each observer said, its tau_f as effort."""
    return {name: bag.joint_log(f'/friction_estimate/{name}') for name in OBSERVERS}


def test_live_estimates_equal_the_batch_path(run, bag):
    """Largest difference over the whole run at most 1e-9; they are the same steps, so it is 0."""
    batch = replayed(run).estimates
    # What is fitted without an observer has estimates besides, each its own.
    assert set(OBSERVERS) <= set(batch)
    for name, live in estimates(bag).items():
        np.testing.assert_array_equal(np.isnan(live.tau), np.isnan(batch[name]))
        assert np.nanmax(np.abs(live.tau - batch[name])) <= 1e-9


def test_the_judge_of_a_busy_machine_finds_no_broken_promise(run):
    told, broken = judge(run)
    assert not broken, told


def test_the_bag_names_the_controllers_that_ran(bag):
    """For a simulation of the closed loop: the gains of config/exoskeleton.yaml."""
    controllers = read_controllers(bag)
    assert controllers['shoulder']['kind'] == 'pd'
    assert (controllers['shoulder']['kp'], controllers['shoulder']['kd']) == (250.0, 12.0)
    assert controllers['elbow']['kind'] == 'actuator'


def test_the_bag_closes_the_loop_of_a_simulation(run, bag):
    """What sosml simulate needs of it: who was driven by a law, and who followed."""
    loop = recorded_loop(bag, run / 'bag', bag.joint_log())
    if not isinstance(loop, RecordedLoop):
        # On a machine so busy that samples are lost, this is what is said.
        assert 'was recorded at' in loop
        return
    assert list(loop.gains) == ['shoulder']
    assert list(loop.followed) == ['elbow']


def test_a_bag_begins_with_a_fresh_start_of_the_observers(bag):
    """
    Its first estimate is NaN, so a replay of it starts alike; else only one after a gap is.

    A busy machine may make a gap: the observers must not integrate across it, and the driver has
    no velocity until its window is full again.
    """
    log = bag.joint_log()
    gap = np.diff(log.t_ns, prepend=0) > 50_000_000
    blind = ~np.isfinite(log.v).all(axis=1)
    starts = gap | blind | np.roll(blind, 1)
    assert starts[0]
    for live in estimates(bag).values():
        unknown = np.isnan(live.tau)
        np.testing.assert_array_equal(unknown.all(axis=1), starts)
        np.testing.assert_array_equal(unknown.any(axis=1), starts)


def test_replay_and_observer_nodes_give_the_live_estimates(ros, start_node, run, bag):
    """For every stamp of the first third the difference is at most 1e-9, at twice the speed."""
    received = {
        name: ros.collect(JointState, f'friction_estimate/{name}', JOINT_STATES, raw=True)
        for name in OBSERVERS
    }
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node(
        'observer_node',
        f'urdf_path:={share_directory() / "urdf" / "exoskeleton.urdf"}',
        f'configuration:={run / "bag"}',
    )
    ros.spin_until(lambda: configuration)
    for name in OBSERVERS:
        topic = f'friction_estimate/{name}'
        ros.spin_until(lambda topic=topic: ros.node.count_publishers(topic) == 1)
    replay = start_node(
        'replay_node',
        f'bag:={run / "bag"}',
        'rate:=2.0',
        "exclude:=['*/friction_estimate*', '*/observer_configuration']",
    )
    live = estimates(bag)
    count = len(live['sosml'].t_ns) // 3
    ros.spin_until(lambda: min(map(len, received.values())) >= count)
    replay.stop()
    for name, messages in received.items():
        states = [deserialize(data, 'sensor_msgs/msg/JointState') for data in messages]
        again = {
            state.header.stamp.sec * 10**9 + state.header.stamp.nanosec: state.effort
            for state in states
        }
        assert list(again) == live[name].t_ns[: len(again)].tolist()
        difference = np.array(list(again.values())) - live[name].tau[: len(again)]
        assert np.nanmax(np.abs(difference)) <= 1e-9


def test_a_replay_does_not_command_a_robot_unless_asked_to(ros, start_node, run):
    """Without commands:=true it does not even offer the topic joint_trajectory."""
    commands = ros.collect(JointTrajectory, 'joint_trajectory', 10)
    played = ros.collect(JointState, 'joint_states', JOINT_STATES, raw=True)
    replay = start_node('replay_node', f'bag:={run / "bag"}', 'rate:=20.0')
    # The trajectory is at the beginning of the bag.
    ros.spin_until(lambda: len(played) > 500)
    assert ros.node.count_publishers('joint_trajectory') == 0
    assert not commands
    replay.stop()
    start_node('replay_node', f'bag:={run / "bag"}', 'commands:=true')
    ros.spin_until(lambda: ros.node.count_publishers('joint_trajectory') == 1)


def test_an_independent_reader_finds_the_same_topics_types_counts_and_stamps(run, bag):
    """Package rosbags, which shares no code with ours."""
    with AnyReader([run / 'bag']) as reader:
        found = {item.topic: (item.msgtype, item.msgcount) for item in reader.connections}
        assert found == bag.topics
        types = {topic: kind for topic, (kind, _) in found.items()}
        assert types['/joint_states'] == 'sensor_msgs/msg/JointState'
        assert types['/joint_temperatures'] == 'sensor_msgs/msg/Temperature'
        assert types['/joint_trajectory'] == 'trajectory_msgs/msg/JointTrajectory'
        assert types['/robot_description'] == 'std_msgs/msg/String'
        connections = [item for item in reader.connections if item.topic == '/joint_states']
        seen = []
        for connection, _, data in reader.messages(connections=connections):
            stamp = reader.deserialize(data, connection.msgtype).header.stamp
            seen.append(stamp.sec * 10**9 + stamp.nanosec)
    np.testing.assert_array_equal(seen, stamps(bag, '/joint_states'))


def test_the_recorded_trajectory_is_t1_and_names_its_commander(run, bag):
    log = bag.joint_log()
    names = ('shoulder', 'elbow')
    settings = yaml.safe_load(PARAMETERS.read_text())['/**/identifier_node']['ros__parameters']
    centre = dict(zip(names, settings['centre'], strict=True))
    start = dict(zip(names, log.select(names).q[0].tolist(), strict=True))
    planned = speed_ladder(start, centre, settings['speeds'], PLATEAU, settings['ramp'])
    (sent,) = bag.trajectories()
    assert sent.names == names
    np.testing.assert_allclose(sent.times, planned.t, atol=1e-3)
    # From where the joints were a cycle or two before the recording began.
    np.testing.assert_allclose(sent.positions, planned.q, atol=2e-3)
    ((_, message),) = bag.decoded('/joint_trajectory')
    assert message.header.frame_id == 'identifier_node'


def test_the_model_folder_holds_friction_with_its_errors_and_provenance(run, phases):
    """On a machine that was too busy for a joint there is none, and the checks have told why."""
    model = read_model(run / 'model')
    checks = json.loads((run / 'model' / 'fit.json').read_text())['data_checks']
    told = [finding for finding in checks['findings'] if finding['level'] == 'warning']
    for joint in ('shoulder', 'elbow'):
        found = model.joints[joint].friction
        assert found is not None or told, joint
        for name, parameter in found.parameters.items() if found else ():
            # A value with its error, or none with the reason.
            assert parameter.std_error > 0.0 or parameter.reason, name
    assert model.provenance['bag'] == 'bag'
    assert model.provenance['samples'] == len(Bag.open(run / 'bag').joint_log())
    parameters = yaml.safe_load((run / 'parameters.yaml').read_text())
    assert read_model(parameters['/**']['ros__parameters']['model']).joints == model.joints
    assert any('running T1' in phase for phase in phases)
    assert 'shoulder: ' in phases[-1]


def test_every_stamp_that_is_missing_is_told_by_the_fit(run, bag):
    """Cycles that never ran or came late are gaps, counted in the checks of the report."""
    steps = np.diff(stamps(bag, '/joint_states')) * 1e-9
    checks = json.loads((run / 'model' / 'fit.json').read_text())['data_checks']
    assert checks['gaps'] == int(np.sum(steps > 1.5 * np.median(steps)))
    assert checks['longest_step_s'] == pytest.approx(steps.max())
