# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The action FollowJointTrajectory of a driver, where the distribution has control_msgs.

MoveIt and others command by it: they learn when a motion has ended, why it was refused, and may
cancel it. control_msgs is no wheel on PyPI; where it is absent the topic joint_trajectory remains.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future

from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.nodes.commander import callers

NAME = '~/follow_joint_trajectory'
#: The service by which a goal is sent: whoever has a client of it may be the sender.
GOALS = f'{NAME}/_action/send_goal'


class Outcome(NamedTuple):
    """Say how a goal ended: which call of its handle, and the result's code and sentence."""

    state: str
    code: int = 0
    sentence: str = ''


class FollowAction:
    """
    Execute goals one at a time: another goal, trajectory or ~/stop ends the one before it.

    Nothing here waits: a goal is looked after whenever :meth:`watch` is called. Tolerances in a
    goal are refused, as the driver has its own (tracking_limit).

    :param driver: the :class:`~sosml_friction.nodes.driver_node.DriverNode`, which imports this.
    """

    def __init__(self, driver: Any, kind: Any, serve: Callable[..., Any]) -> None:
        self._driver, self._kind = driver, kind
        self._next = Future()
        self.server = serve(
            driver, kind, NAME, self._execute, cancel_callback=lambda _: CancelResponse.ACCEPT
        )

    @staticmethod
    def offer(driver: Any) -> FollowAction | None:
        """Offer the action; return None, and say so in the log, where control_msgs is absent."""
        try:
            from control_msgs.action import FollowJointTrajectory
        except ImportError:
            driver.get_logger().info(
                'control_msgs is not installed: the action follow_joint_trajectory is not '
                'offered, the topic joint_trajectory is'
            )
            return None
        return FollowAction(driver, FollowJointTrajectory, ActionServer)

    def watch(self) -> None:
        """Let the goals look at how far they are."""
        due, self._next = self._next, Future()
        due.set_result(None)

    def destroy(self) -> None:
        """Withdraw the action."""
        self.server.destroy()

    async def _execute(self, handle: Any) -> Any:
        outcome = self._begin(handle.request)
        number = self._driver.commands
        while outcome is None:
            await self._next
            outcome = self._look(handle, number)
            if outcome is None:
                self._tell(handle)
        # succeed(), canceled() or abort() of the goal.
        getattr(handle, outcome.state)()
        return self._kind.Result(error_code=outcome.code, error_string=outcome.sentence)

    def _begin(self, goal: Any) -> Outcome | None:
        invalid = self._kind.Result.INVALID_GOAL
        if len(goal.path_tolerance) or len(goal.goal_tolerance):
            sentence = (
                'the goal states tolerances, which are not looked at: leave them out, and set '
                'tracking_limit of the joints'
            )
            return Outcome('abort', invalid, sentence)
        try:
            self._driver.begin(goal.trajectory, callers(self._driver, GOALS))
        except SosmlFrictionError as error:
            return Outcome('abort', invalid, str(error))
        return None

    def _look(self, handle: Any, number: int) -> Outcome | None:
        """Return how the goal has ended, None while it has not."""
        violated = self._kind.Result.PATH_TOLERANCE_VIOLATED
        report = self._driver.report()
        if report is None or report.state is not DriverState.ENABLED:
            reason = 'the driver is not active' if report is None else report.reason
            return Outcome('abort', violated, reason or 'the driver was disabled')
        if self._driver.commands != number:
            return Outcome('abort', violated, 'another command took the place of this goal')
        if handle.is_cancel_requested:
            self._driver.halt()
            return Outcome('canceled', sentence='canceled: the joints hold')
        return None if report.trajectory_running else Outcome('succeed')

    def _tell(self, handle: Any) -> None:
        report = self._driver.report()
        if report is None:
            return
        feedback = self._kind.Feedback(joint_names=[joint.name for joint in report.joints])
        feedback.header.stamp = self._driver.get_clock().now().to_msg()
        feedback.actual.positions = [joint.q for joint in report.joints]
        feedback.error.positions = [joint.tracking_error for joint in report.joints]
        feedback.desired.positions = [joint.q + joint.tracking_error for joint in report.joints]
        handle.publish_feedback(feedback)
