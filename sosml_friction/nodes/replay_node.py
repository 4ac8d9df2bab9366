# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""replay_node: play a bag, every topic as recorded, with ``/clock``."""

import fnmatch
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import Trigger

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.serialization import message_class
from sosml_friction.exceptions import BagError, ConfigurationError
from sosml_friction.nodes.diagnostics import OK, full_name, make_array, make_status
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.parameters import ParameterSpec, declare
from sosml_friction.nodes.program_node import ProgramNode
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.nodes.run import run_node

#: Last part of the names of topics whose last message a late subscriber must get.
LATCHED_TOPICS = (
    'robot_description',
    'model_description',
    'observer_configuration',
    'controller_configuration',
    'friction_parameters',
    'tf_static',
)
_STATES = 'joint_states'

PARAMETERS = (
    ParameterSpec('bag', 'string', None, 'the bag to play: a folder or a file'),
    ParameterSpec('rate', 'double', 1.0, 'speed, 2.0 plays twice as fast', '', (0.01, 100.0)),
    ParameterSpec(
        'exclude',
        'string_array',
        [],
        'topics not to play, with wildcards, for instance /friction_estimate*',
    ),
    ParameterSpec(
        'commands',
        'bool',
        False,
        'also play joint_trajectory, which moves an enabled robot that hears it',
    ),
    ParameterSpec(
        'subscribers',
        'integer',
        1,
        'subscribers of joint_states to wait for before playing; 0: none',
        '',
        (0, 100),
    ),
    ParameterSpec('wait', 'double', 10.0, 'longest wait for them', 's', (0.0, 3600.0)),
)


class ReplayNode(ProgramNode):
    """
    Publish the messages of a bag in the order and at the pace of their log times.

    Latched texts are published first. Playing begins when joint_states has its ``subscribers``, or
    after ``wait``; the program ends when every message was acknowledged.

    :raises BagError: if the bag cannot be read.
    :raises ConfigurationError: if nothing is left to play.
    """

    def __init__(self) -> None:
        super().__init__('replay_node')
        self._p = declare(self, PARAMETERS)
        self._bag = Bag.open(self._p['bag'])
        if self._bag.recovered:
            self.get_logger().warning(self._bag.recovery)
        self._outputs: dict[str, Any] = {}
        excluded = ['/clock', *self._p['exclude']]
        if not self._p['commands']:
            excluded += ['joint_trajectory', '*/joint_trajectory']
        for topic, (type_name, _) in self._bag.topics.items():
            if any(fnmatch.fnmatch(topic, pattern) for pattern in excluded):
                continue
            try:
                kind = message_class(type_name)
            except BagError as error:
                self.get_logger().warning(f'{topic} is not played: {error}')
                continue
            qos = LATCHED if _last_part(topic) in LATCHED_TOPICS else JOINT_STATES
            self._outputs[topic] = self.create_publisher(kind, topic, qos)
        if not self._outputs:
            raise ConfigurationError(
                f'nothing is left to play of {self._p["bag"]}: exclude fewer of its topics '
                f'{", ".join(self._bag.topics)}'
            )
        self._clock_output = self.create_publisher(ClockMessage, '/clock', 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_service(Trigger, '~/pause', self._on_pause)
        self.create_service(Trigger, '~/resume', self._on_resume)
        self._running = threading.Event()
        self._running.set()
        self._closing = threading.Event()
        self._finished = threading.Event()
        self._error: Exception | None = None
        self._played = 0
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(0.1, self._check_end, clock=steady)
        self.create_timer(1.0, self._diagnose, clock=steady)
        self._thread = threading.Thread(target=self._run, name='replay', daemon=True)
        self._thread.start()

    def destroy_node(self) -> None:
        """Stop playing, then destroy the node."""
        self._closing.set()
        self._running.set()
        self._thread.join(timeout=5.0)
        super().destroy_node()

    def _run(self) -> None:
        try:
            self._play()
        except Exception as error:  # the thread's own end of the world: told to the main thread
            self._error = error
        finally:
            self._finished.set()

    def _play(self) -> None:
        latched = {topic for topic in self._outputs if _last_part(topic) in LATCHED_TOPICS}
        for topic, _, data in self._bag.timeline():
            if topic in latched:
                latched.remove(topic)
                self._outputs[topic].publish(data)
        self._await_subscribers()
        self.get_logger().info(f'playing {self._bag.duration_s:.1f} s of {self._p["bag"]}')
        started = time.monotonic()
        paused = 0.0
        begin_ns = self._bag.start_ns
        for topic, log_time_ns, data in self._bag.timeline():
            if not self._running.is_set():
                since = time.monotonic()
                self._running.wait()
                paused += time.monotonic() - since
            due = started + paused + (log_time_ns - begin_ns) * 1e-9 / self._p['rate']
            wait = due - time.monotonic()
            if self._closing.wait(wait) if wait > 0.0 else self._closing.is_set():
                return
            if topic not in self._outputs:
                continue
            if _last_part(topic) == _STATES:
                seconds, nanoseconds = divmod(log_time_ns, 1_000_000_000)
                stamp = Time(sec=seconds, nanosec=nanoseconds)
                self._clock_output.publish(ClockMessage(clock=stamp))
            self._outputs[topic].publish(data)
            self._played += 1
        for output in self._outputs.values():
            output.wait_for_all_acked(Duration(seconds=5.0))

    def _await_subscribers(self) -> None:
        waiting = [own for topic, own in self._outputs.items() if _last_part(topic) == _STATES]
        wanted, end = self._p['subscribers'], time.monotonic() + self._p['wait']
        while any(output.get_subscription_count() < wanted for output in waiting):
            if time.monotonic() >= end:
                self.get_logger().warning(
                    f'joint_states has fewer than {wanted} subscribers: playing all the same'
                )
                return
            if self._closing.wait(0.02):
                return

    def _check_end(self) -> None:
        if self._finished.is_set():
            if self._error is None and self.outcome is None:
                self.get_logger().info(f'{self._played} messages played')
            self.end(self._error)

    def _on_pause(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._running.is_set()
        response.message = 'paused' if response.success else 'was paused already'
        self._running.clear()
        return response

    def _on_resume(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = not self._running.is_set()
        response.message = 'playing' if response.success else 'was playing already'
        self._running.set()
        return response

    def _diagnose(self) -> None:
        message = 'playing' if self._running.is_set() else 'paused'
        values = {'bag': self._p['bag'], 'messages played': self._played, 'rate': self._p['rate']}
        name = full_name(self)
        status = make_status(f'{name}: bag', OK, message, values)
        self._diagnostics.publish(make_array(self.get_clock().now().to_msg(), [status]))


def _last_part(topic: str) -> str:
    return topic.rpartition('/')[2]


HELP = NodeHelp(
    'replay_node',
    'Plays a bag: every topic as it was recorded, with /clock. ~/pause and ~/resume.',
    '--ros-args -p bag:=demo_output/run/bag',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit code."""
    return run_node(ReplayNode, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
