# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One process commands a driver at a time; who does is known as far as ROS tells."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from sosml_friction.nodes.commander import Commander, Endpoint

MINE, OTHER = Endpoint(b'a' * 12, 'arm/plan'), Endpoint(b'b' * 12, 'demo')


@pytest.fixture
def held() -> Commander:
    """Return a commander that holds since 10 s, for 5 s."""
    commander = Commander(5.0)
    commander.take([MINE], 10.0)
    return commander


def test_whoever_moves_holds_and_another_is_refused_and_named(held):
    assert held.refusal([MINE]) == ''
    assert held.refusal([OTHER]).startswith('demo may not command: arm/plan holds this driver')


def test_a_hold_ends_with_silence_after_the_last_motion(held):
    held.moves(13.0)
    held.watch(17.9, [MINE, OTHER])
    assert held.refusal([OTHER])
    held.watch(18.1, [MINE, OTHER])
    assert (held.name, held.refusal([OTHER])) == ('', '')


def test_a_holder_that_has_left_holds_until_its_motion_ends(held):
    held.moves(11.0)
    held.watch(11.1, [OTHER])
    assert held.refusal([OTHER])
    held.watch(11.3, [OTHER])
    assert held.refusal([OTHER]) == ''


def test_released_anybody_may_command(held):
    held.release()
    assert held.refusal([OTHER]) == ''


def test_of_several_publishers_the_one_that_is_named_has_sent():
    assert Commander.senders([MINE, OTHER], '/arm/plan') == [MINE]
    assert Commander.senders([MINE, OTHER], 'base_link') == [MINE, OTHER]
    assert Commander.senders([MINE], '') == [MINE]


def test_who_may_have_been_another_is_refused_and_told_how_to_say_it(held):
    refusal = held.refusal([MINE, OTHER])
    assert refusal.startswith('arm/plan or demo (ROS does not tell which')
    assert 'header.frame_id' in refusal


def test_two_nodes_of_one_process_are_one_commander(held):
    assert held.refusal([MINE, Endpoint(MINE.process, 'arm/view')]) == ''


def test_two_processes_of_one_name_are_two(held):
    assert held.refusal([Endpoint(b'c' * 12, MINE.node)])


def test_a_sender_that_is_not_known_holds_as_well_and_is_nobody_else():
    commander = Commander(5.0)
    commander.take([], 0.0)
    assert commander.name == 'a node that has left'
    assert commander.refusal([])
    assert commander.refusal([OTHER])
