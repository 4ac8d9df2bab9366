# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
How goals of FollowJointTrajectory begin and end, with stand-ins for control_msgs and its server.

control_msgs is no wheel: what rclpy makes of the real type is not tested here.
"""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.nodes.follow_action import FollowAction


class Kind:
    """The action's type, as far as it is used."""

    class Result(SimpleNamespace):
        """Codes as control_msgs states them."""

        SUCCESSFUL, INVALID_GOAL, PATH_TOLERANCE_VIOLATED = 0, -1, -4

    class Feedback(SimpleNamespace):
        """A point each for what is wanted, what is, and their difference."""

        def __init__(self, **values) -> None:
            points = {name: SimpleNamespace() for name in ('header', 'actual', 'error', 'desired')}
            super().__init__(**points, **values)


class Driver:
    """A driver that moves for three looks."""

    def __init__(self, looks=3, refusal='') -> None:
        self.commands, self.looks, self.refusal = 0, looks, refusal
        self.state, self.reason, self.halted = DriverState.ENABLED, '', False

    def begin(self, message, senders) -> None:
        if self.refusal:
            raise TrajectoryError(self.refusal)
        self.commands += 1

    def report(self):
        self.looks -= 1
        joint = SimpleNamespace(name='hip', q=0.5, tracking_error=0.1)
        return SimpleNamespace(
            state=self.state,
            reason=self.reason,
            trajectory_running=self.looks > 0,
            joints=(joint,),
        )

    def halt(self) -> None:
        self.halted = True

    def get_publishers_info_by_topic(self, *_, **__):
        return []

    def resolve_service_name(self, name):
        return name

    def get_clock(self):
        return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: 'now'))


class Handle:
    """A goal's handle: what it was told."""

    def __init__(self, **goal) -> None:
        goal = {'trajectory': None, 'path_tolerance': [], 'goal_tolerance': [], **goal}
        self.request = SimpleNamespace(**goal)
        self.is_cancel_requested, self.ended, self.feedback = False, [], []
        self.publish_feedback = self.feedback.append
        self.succeed, self.abort, self.canceled = (
            lambda what=what: self.ended.append(what) for what in ('succeed', 'abort', 'canceled')
        )


def end_of(driver: Driver, handle: Handle, meanwhile=lambda looked: None):
    """Execute a goal as an executor does, with a look whenever it waits; return its result."""
    action = FollowAction(driver, Kind, lambda *args, **_: args)
    task = action.server[3](handle)
    for looked in range(10):
        try:
            task.send(None)
        except StopIteration as stop:
            return stop.value
        meanwhile(looked)
        action.watch()
    raise AssertionError('the goal did not end')


def test_a_goal_succeeds_when_its_motion_has_ended_and_tells_where_it_is_meanwhile():
    handle = Handle()
    result = end_of(Driver(looks=5), handle)
    assert (handle.ended, result.error_code, result.error_string) == (['succeed'], 0, '')
    assert handle.feedback[0].joint_names == ['hip']
    assert handle.feedback[0].desired.positions == [pytest.approx(0.6)]


def test_a_refused_goal_is_aborted_with_the_reason():
    handle = Handle()
    result = end_of(Driver(refusal='demo holds this driver'), handle)
    assert (handle.ended, result.error_code) == (['abort'], Kind.Result.INVALID_GOAL)
    assert result.error_string == 'demo holds this driver'


def test_tolerances_are_refused_and_not_ignored():
    driver, handle = Driver(), Handle(goal_tolerance=[0.1])
    assert 'set tracking_limit' in end_of(driver, handle).error_string
    assert driver.commands == 0


def test_a_cancelled_goal_brakes_and_another_command_ends_it():
    driver, handle = Driver(looks=9), Handle()
    end_of(driver, handle, lambda looked: setattr(handle, 'is_cancel_requested', looked == 1))
    assert (driver.halted, handle.ended) == (True, ['canceled'])
    driver, handle = Driver(looks=9), Handle()
    result = end_of(driver, handle, lambda looked: setattr(driver, 'commands', 7))
    assert (driver.halted, handle.ended) == (False, ['abort'])
    assert 'another command' in result.error_string


def test_a_fault_aborts_the_goal_with_its_reason():
    driver, handle = Driver(looks=9), Handle()

    def fail(looked: int) -> None:
        driver.state, driver.reason = DriverState.FAULT, 'joint hip is blocked'

    result = end_of(driver, handle, fail)
    assert (handle.ended, result.error_string) == (['abort'], 'joint hip is blocked')


def test_without_control_msgs_there_is_no_action_and_the_log_says_so():
    said: list[str] = []
    node = SimpleNamespace(get_logger=lambda: SimpleNamespace(info=said.append))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, 'control_msgs.action', None)
        assert FollowAction.offer(node) is None
    assert 'control_msgs is not installed' in said[0]
