# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The demo's own node: it calls the services of the others and follows the identification."""

import os
import time
from collections.abc import Callable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node

from sosml_friction.exceptions import ActuatorError
from sosml_friction.nodes.node_process import NodeProcess
from sosml_friction.report.common.progress import Step

#: A service that has not replied by then [s] is asked again.
_REPLY_PATIENCE = 5.0
#: What has not succeeded by then [s] never will.
_PATIENCE = 60.0
#: An identification of which nothing new was heard for this time [s] has come to a stop.
_LONGEST_SILENCE = 300.0


class DemoClient:
    """Call services, follow the identifier's phase, and watch the processes, which may grow."""

    def __init__(
        self, node: Node, executor: Executor, processes: Sequence[NodeProcess], step: Step
    ) -> None:
        self._node, self._executor = node, executor
        self._processes, self._step = processes, step
        self._phase, self._message = '', ''
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 50)

    def require_no_driver(self) -> None:
        """Refuse to go on where another driver hears the demo's commands (ActuatorError)."""
        self._spin_for(1.0)
        if 'driver_node' in self._node.get_node_names():
            raise ActuatorError(
                f'a driver_node runs already in ROS domain {os.environ["ROS_DOMAIN_ID"]}: stop '
                'it, or start the demo again, which takes another domain'
            )

    def call(
        self, kind: Any, name: str, request: Any, done: Callable[[], bool] = lambda: False
    ) -> None:
        """
        Call a service until it says yes: a node that is still starting says no.

        :param done: tells that it said yes by what it does, where its reply may be lost.
        :raises ActuatorError: if it does not within a minute.
        """
        client: Client = self._node.create_client(kind, name)
        answer = 'it is not there'
        end = time.monotonic() + _PATIENCE
        while time.monotonic() < end:
            if not client.service_is_ready():
                self._spin()
                continue
            future = client.call_async(request)
            # DDS loses a reply to a client that a busy node has not discovered yet.
            late = min(end, time.monotonic() + _REPLY_PATIENCE)
            while not future.done() and time.monotonic() < late:
                self._spin()
            if done() or (future.done() and future.result().success):
                return
            if future.done():
                answer = future.result().message
            else:
                client.remove_pending_request(future)
                answer = 'no answer'
            self._spin_for(0.3)
        raise ActuatorError(f'{name} did not succeed within {_PATIENCE:.0f} s: {answer}')

    def has_begun(self) -> bool:
        """Tell whether the identifier reports a run."""
        return self._phase not in ('', 'idle')

    def await_end(self) -> None:
        """Return when the identifier is done; an ActuatorError if it fails or stops."""
        heard, before = time.monotonic(), ''
        while self._phase != 'done':
            self._spin()
            if self._phase == 'failed':
                raise ActuatorError(f'the identification failed: {self._message}')
            if (state := f'{self._phase}{self._message}') != before:
                before, heard = state, time.monotonic()
            elif time.monotonic() - heard > _LONGEST_SILENCE:
                raise ActuatorError(
                    f'the identifier is still {self._phase!r} after {_LONGEST_SILENCE:.0f} s'
                )

    def _spin_for(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._spin()

    def _spin(self) -> None:
        self._executor.spin_once(timeout_sec=0.1)
        for process in self._processes:
            process.require_running()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == 'identifier_node: run':
                values = {item.key: item.value for item in status.values}
                self._phase, self._message = values.get('phase', ''), status.message
                share = values.get('progress [%]')
                self._step(
                    'waiting for the robot' if self._phase == 'idle' else status.message,
                    None if share is None else float(share) / 100.0,
                )
