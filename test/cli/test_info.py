# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml info``: what a bag holds, whole, cut off or without motion."""

import subprocess
import sys

import pytest
from slider_bags import checked, slider_log, text_bag, text_message

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import serialize_joint_state


def test_info_counts_gaps_repeats_and_steps_back(sosml, tmp_path):
    log = slider_log()
    t_ns = log.t_ns + 1_000_000_000
    t_ns[100:] += 40_000_000
    t_ns[201] = t_ns[200]
    t_ns[301] = t_ns[300] - 1
    bag = tmp_path / 'odd'
    with BagRecorder(bag) as recorder:
        recorder.add_topic('/robot_description', 'std_msgs/msg/String')
        recorder.write('/robot_description', text_message(), 0)
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for k, stamp in enumerate(t_ns.tolist()):
            message = serialize_joint_state(stamp, log.names, log.q[k], [], [])
            recorder.write('/joint_states', message, k)
    code, out, _ = sosml('info', bag, '--json')
    assert code == 0
    motion = checked(out, 'info')['joint_states']
    assert motion['rate_hz'] == pytest.approx(250.0)
    assert motion['repeated_stamps'] == 1
    assert motion['backward_stamps'] == 1
    # The pause, and the steps after the repeated and the backward stamp.
    assert motion['gaps'] == 3
    assert motion['longest_step_s'] == pytest.approx(0.044)
    text = sosml('info', bag)[1]
    assert 'robot_description; not model_description' in text
    assert '1 repeated and 1 backward' in text


def test_info_says_how_much_of_a_cut_off_bag_is_left(sosml, slider_bag, tmp_path):
    whole = Bag.open(slider_bag).messages_read
    cut = tmp_path / 'cut.mcap'
    content = next(slider_bag.glob('*.mcap')).read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    document = checked(sosml('info', cut, '--json')[1], 'info')
    assert document['recovered']
    assert 0 < document['messages'] < whole
    assert str(document['messages']) in document['recovery']
    assert document['recovery'] in sosml('info', cut)[1]


def test_a_table_is_told_as_a_bag_is(sosml, refused, tmp_path):
    (tmp_path / 'x.csv').write_text('q,f\n' + ''.join(f'{0.001 * k},{k}\n' for k in range(50)))
    columns = ('--position', 'q:m', '--effort', 'f:N', '--rate', '200')
    code, out, err = sosml('info', 'x.csv', *columns, '--json')
    assert code == 0, err
    document = checked(out, 'info')
    assert document['path'] == 'x.csv'
    assert document['joint_states']['rate_hz'] == pytest.approx(200.0)
    assert document['joint_states']['measured'] == {'joint': ['position', 'effort']}
    following = 'Next: sosml fit x.csv with the options that name its columns and --model ROBOT'
    assert following in ' '.join(sosml('info', 'x.csv', *columns)[1].split())
    assert 'name its columns, as --position q' in refused('info', 'x.csv')
    assert '--pendulum' not in sosml('info', '--help')[1]


def test_info_does_not_wait_for_the_heavy_libraries(slider_bag):
    code = (
        'import sys; from sosml_friction.cli.main import main; main(["info", sys.argv[1]]);'
        'heavy = "scipy", "numba", "pinocchio", "matplotlib", "rclpy", "sensor_msgs";'
        'print([m for m in heavy if m in sys.modules])'
    )
    command = [sys.executable, '-c', code, slider_bag]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines()[-1] == '[]'


def test_info_of_a_bag_without_motion_says_so(sosml, tmp_path):
    code, out, _ = sosml('info', text_bag(tmp_path / 'text'), '--json')
    assert code == 0
    document = checked(out, 'info')
    assert document['joint_states'] is None
    assert 'joint_states' in document['joint_states_problem']
    assert document['topics'] == {'/greeting': {'type': 'std_msgs/msg/String', 'messages': 1}}
    assert 'No motion' in sosml('info', tmp_path / 'text')[1]
