# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Schemas are the concatenated definitions rosbag2 writes."""

import pytest

from sosml_friction.bags.message_definitions import message_definition, type_hash
from sosml_friction.exceptions import BagError


def test_joint_state_definition_has_its_dependencies_in_the_order_rosbag2_writes_them():
    lines = message_definition('sensor_msgs/msg/JointState').splitlines()
    marks = [i for i, line in enumerate(lines) if line == '=' * 80]
    assert [lines[i + 1] for i in marks] == [
        'MSG: std_msgs/Header',
        'MSG: builtin_interfaces/Time',
    ]
    assert 'float64[] effort' in lines[: marks[0]]
    assert 'string frame_id' in lines[marks[0] : marks[1]]
    assert 'uint32 nanosec' in lines[marks[1] :]


def test_definition_is_parsed_by_an_independent_reader_to_the_standard_types():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for name in ('sensor_msgs/msg/JointState', 'trajectory_msgs/msg/JointTrajectory'):
        parsed = get_types_from_msg(message_definition(name), name)
        for type_name, fields in parsed.items():
            assert fields[1] == store.fielddefs[type_name][1]


def test_constants_comments_and_bounded_types_are_no_dependencies(tmp_path, monkeypatch):
    folder = tmp_path / 'share' / 'sosml_test_msgs' / 'msg'
    folder.mkdir(parents=True)
    (folder / 'Odd.msg').write_text(
        '# Other unused\nuint8 A = 1\nstring<=10 label\nfloat64[<=3] x  # Third comment\n'
        'Inner[] inner\nstd_msgs/Empty empty\n'
    )
    (folder / 'Inner.msg').write_text('int32 value\n')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    text = message_definition('sosml_test_msgs/msg/Odd')
    named = [line for line in text.splitlines() if line.startswith('MSG: ')]
    assert named == ['MSG: sosml_test_msgs/Inner', 'MSG: std_msgs/Empty']
    assert type_hash('sosml_test_msgs/msg/Odd') == ''


def test_type_hash_is_the_published_one():
    # As it stands in the metadata.yaml of bags recorded with ROS 2 Jazzy.
    assert type_hash('std_msgs/msg/String') == (
        'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18'
    )


@pytest.mark.parametrize(
    ('name', 'sentence'),
    [
        ('nowhere_msgs/msg/Thing', 'nowhere_msgs/msg/Thing.msg\\) is not installed: source'),
        ('sensor_msgs/msg/NoSuchThing', 'is not installed'),
        ('JointState', "'JointState' is no message type: write it as"),
        ('a/srv/B', 'is no message type'),
    ],
)
def test_unknown_types_are_named(name, sentence):
    with pytest.raises(BagError, match=sentence):
        message_definition(name)
