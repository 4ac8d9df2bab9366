# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers in a bag: from its tags, or from the topic that ros2 bag record keeps."""

from __future__ import annotations

import json

import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import CONTROLLER_TOPIC as TOPIC
from sosml_friction.bags.controllers import (
    controller_tags,
    parse_controllers,
    read_controllers,
)
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize
from sosml_friction.exceptions import BagError

PD = {
    'kind': 'pd', 'kp': 250.0, 'kd': 12.0, 'limit': 8.0, 'rate_limit': 625.0, 'rate': 500.0,
    'velocity_window': 11,
}  # fmt: skip
ENTRIES = {'shoulder': PD, 'elbow': {'kind': 'actuator', 'reason': 'a servo'}}


def bag_of(folder, tags, topic=None):
    texts = {'/robot_description': '<robot/>'} | ({} if topic is None else {f'/{TOPIC}': topic})
    with BagRecorder(folder, tags) as recorder:
        for name, content in texts.items():
            text = message_class('std_msgs/msg/String')()
            text.data = content
            recorder.add_topic(name, 'std_msgs/msg/String')
            recorder.write(name, serialize(text), 1)
    return Bag.open(folder)


def test_entries_come_back_from_tags_and_from_the_topic(tmp_path):
    assert read_controllers(bag_of(tmp_path / 'tags', controller_tags(ENTRIES))) == ENTRIES
    assert read_controllers(bag_of(tmp_path / 'topic', {}, json.dumps(ENTRIES))) == ENTRIES
    assert read_controllers(bag_of(tmp_path / 'none', {'operator': 'me'})) == {}


def test_an_entry_without_kind_is_a_cascade(tmp_path):
    """As bags before version 1 have it, and as sosml import writes it."""
    entry = {'kp': 160.0, 'kv': 240.0, 'scale': 35.0}
    bag = bag_of(tmp_path / 'bag', {'controller.slider': json.dumps(entry)})
    assert read_controllers(bag) == {'slider': {'kind': 'cascade', **entry}}


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('{', 'as JSON'),
        ('[]', 'names no joints'),
        ('{"shoulder": 3}', 'give it a kind'),
        ('{"shoulder": {"kind": "magic"}}', 'give it a kind'),
        ('{"shoulder": {"kind": "pd", "kp": 1.0}}', 'kind pd has the numbers'),
        (json.dumps({'shoulder': PD | {'kp': 'much'}}), 'kind pd has the numbers'),
        (json.dumps({'shoulder': PD | {'ki': 1.0}}), 'kind pd has the numbers'),
    ],
)
def test_what_is_no_controller_is_refused_in_one_sentence(text, words):
    with pytest.raises(BagError, match=words):
        parse_controllers(text, 'the topic')
