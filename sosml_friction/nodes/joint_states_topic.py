# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The subscription to joint_states, which finds out how its publishers send."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from sosml_friction.nodes.qos import JOINT_STATES

_BEST_EFFORT = QoSProfile(depth=JOINT_STATES.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
_TOPIC = 'joint_states'


class JointStatesTopic:
    """
    Subscribe to joint_states.

    :param reliability: of :data:`~sosml_friction.nodes.observer_parameters.RELIABILITIES`.
    :param take: is called with the CDR bytes of each message.
    :param lose: is called with the number of messages that DDS lost.
    """

    def __init__(
        self,
        node: Node,
        reliability: str,
        take: Callable[[bytes], None],
        lose: Callable[[int], None],
    ) -> None:
        self._node, self._reliability = node, reliability
        self._take, self._lose = take, lose
        self._is_best_effort = reliability == 'best_effort'
        self._subscription = self._subscribe()

    def look(self) -> tuple[list[str], str]:
        """
        Return the nodes that publish, one for each publisher, and what is to be said of how.

        With ``automatic``, where all send best effort, the subscription then does, too.
        """
        found = self._node.get_publishers_info_by_topic(_TOPIC)
        names = [info.node_name for info in found]
        loose = [
            info.node_name
            for info in found
            if info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
        ]
        if not loose or self._is_best_effort:
            return names, ''
        if len(loose) == len(found) and self._reliability == 'automatic':
            self._node.get_logger().info(
                f'{", ".join(loose)} publishes joint_states best_effort: it is subscribed so, '
                'and messages may be lost'
            )
            self._is_best_effort = True
            self._node.destroy_subscription(self._subscription)
            self._subscription = self._subscribe()
            return names, ''
        return names, (
            f'{", ".join(loose)} publishes joint_states best_effort, which a reliable '
            'subscription never receives: set parameter reliability to best_effort'
        )

    def _subscribe(self) -> Any:
        qos = _BEST_EFFORT if self._is_best_effort else JOINT_STATES
        events = SubscriptionEventCallbacks(message_lost=self._on_lost)
        try:
            return self._node.create_subscription(
                JointState, _TOPIC, self._take, qos, event_callbacks=events, raw=True
            )
        except UnsupportedEventTypeError:
            return self._node.create_subscription(JointState, _TOPIC, self._take, qos, raw=True)

    def _on_lost(self, event: Any) -> None:
        self._lose(int(event.total_count_change))
