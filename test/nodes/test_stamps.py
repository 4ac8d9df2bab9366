# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps are moved between clocks without the jitter of a preempted process."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from sosml_friction.nodes.stamps import StampConverter

OFFSET = 1_700_000_000_000_000_000


class Machine:
    """Two clocks; reading the second takes the times told."""

    def __init__(self, delays):
        self.now = 1_000
        self.delays = list(delays)
        self.offset = OFFSET

    def monotonic(self):
        return self.now

    def ros(self):
        delay = self.delays.pop(0) if self.delays else 1_000
        self.now += delay // 2
        value = self.now + self.offset
        self.now += delay - delay // 2
        return value


def test_a_stamp_is_moved_by_the_offset_of_the_clocks():
    machine = Machine([1_000])
    converter = StampConverter(machine.monotonic, machine.ros)
    assert converter.to_ros_ns(5_000_000) == 5_000_000 + OFFSET


def test_an_interrupted_reading_is_taken_again():
    class Interrupted(Machine):
        def ros(self):
            value = super().ros()
            if len(self.delays) == 2:
                self.now += 8_000_000
            return value

    machine = Interrupted([1_000, 1_000, 1_000])
    converter = StampConverter(machine.monotonic, machine.ros)
    assert converter.to_ros_ns(0) == OFFSET


def test_refresh_follows_a_clock_that_was_set():
    machine = Machine([])
    converter = StampConverter(machine.monotonic, machine.ros)
    machine.offset += 5_000_000_000
    assert converter.to_ros_ns(0) == OFFSET
    converter.refresh()
    assert converter.to_ros_ns(0) == OFFSET + 5_000_000_000
