# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the nodes say while they run, as a table: all of ``sosml watch`` but its options."""

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext, suppress
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import Executor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rich.console import Group, RenderableType
from rich.live import Live
from rich.text import Text
from sensor_msgs.msg import JointState

from sosml_friction.identification.number_text import format_number
from sosml_friction.model.parameter import Z_95
from sosml_friction.nodes.diagnostics import ERROR, OK, WARN
from sosml_friction.nodes.run import plain_node
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.table import terminal_table

FORMAT = 'sosml_friction/watch/1'
#: How often the table is drawn anew [1/s].
_REFRESH = 5.0
#: What has not been heard for this time [s] is said to be silent.
_SILENT = 2.0
_LEVELS = {OK: 'good', WARN: 'warning', ERROR: 'error'}
#: The newest message is what counts; best effort hears reliable publishers too.
_NEWEST = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
_TOPICS = ('joint_states', 'friction_estimate', 'friction_estimate_error')
_COLUMNS = {'joint': 'w', 'velocity': 'n', 'effort': 'n', 'friction': 'n', '± error': 'n',
            'estimate': 'w'}  # fmt: skip


class Heard:
    """Hold the newest of what the nodes published, and when it came [s]."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._messages: dict[str, JointState] = {}
        self._came: dict[str, float] = {}
        self._statuses: dict[str, tuple[str, str]] = {}

    def take(self, topic: str, message: JointState) -> None:
        """Take a message of one of :data:`_TOPICS`."""
        self._messages[topic], self._came[topic] = message, self._clock()

    def on_diagnostics(self, message: DiagnosticArray) -> None:
        """Take a message of ``/diagnostics``."""
        for status in message.status:
            phase = next((x.value for x in status.values if x.key == 'phase'), '')
            told = ', '.join(filter(None, (phase, status.message)))
            self._statuses[status.name] = (_LEVELS.get(status.level, 'stale'), told)

    @property
    def anything(self) -> bool:
        """Tell whether a node was heard at all."""
        return bool(self._came or self._statuses)

    def joints(self) -> Iterator[tuple[str, dict[str, float], str]]:
        """Yield by joint velocity, effort, friction and its standard error, and its validity."""
        states, friction, error = (self._messages.get(topic) for topic in _TOPICS)
        for joint in dict.fromkeys(n for x in (states, friction) if x for n in x.name):
            numbers = {
                'velocity': _of(states, joint, 'velocity'),
                'effort': _of(states, joint, 'effort'),
                'friction': _of(friction, joint, 'effort'),
                'std_error': _of(error, joint, 'effort'),
            }
            valid = 'no observer' if friction is None else 'valid'
            if friction is not None and not math.isfinite(numbers['friction']):
                valid = 'not known'
            yield joint, numbers, self._silence('friction_estimate') or valid

    def rows(self) -> Iterator[tuple[str, ...]]:
        """Yield a row for each joint: velocity, effort, friction, its error, its validity."""
        for joint, own, told in self.joints():
            velocity, effort, friction, error = own.values()
            numbers = (format_number(velocity), format_number(effort))
            known = (format_number(friction, error), format_number(Z_95 * error, error))
            yield joint, *numbers, *known, told

    def _silence(self, topic: str) -> str:
        came = self._came.get(topic)
        if came is None or self._clock() - came < _SILENT:
            return ''
        return f'silent for {self._clock() - came:.0f} s'

    def document(self) -> dict[str, Any]:
        """Return the object of ``sosml watch --json``: docs/schema/watch.schema.json."""
        joints = {joint: {**own, 'estimate': told} for joint, own, told in self.joints()}
        nodes = {
            name: {'state': state, 'message': told}
            for name, (state, told) in self._statuses.items()
        }
        return to_plain({'format': FORMAT, 'joints': joints, 'nodes': nodes})

    def table(self) -> RenderableType:
        """Return joints and nodes as tables, or what is waited for."""
        if not self.anything:
            return Text('waiting for joint_states, friction_estimate or /diagnostics')
        parts: list[RenderableType] = []
        if self._came:
            parts.append(terminal_table(_COLUMNS, list(self.rows())))
        if self._statuses:
            rows = [(name, *told) for name, told in sorted(self._statuses.items())]
            parts.append(terminal_table({'node': 'w', 'state': 'w', 'what it says': ''}, rows))
        silent = self._silence('joint_states')
        if silent:
            parts.append(Text(f'joint_states {silent}'))
        return Group(*parts)


def _of(message: JointState | None, joint: str, what: str) -> float:
    """Return a number of a joint, NaN where the message does not have it."""
    if message is None or joint not in message.name:
        return math.nan
    values: Sequence[float] = getattr(message, what)
    k = list(message.name).index(joint)
    return float(values[k]) if k < len(values) else math.nan


def run_watch(
    namespace: str = '', seconds: float | None = None, live: bool | None = None
) -> Heard:
    """
    Listen to the nodes until Ctrl-C or for some seconds, and return what they said last.

    :param namespace: of the robot.
    :param live: whether it is shown meanwhile; None: where stdout is a terminal.
    """
    live = sys.stdout.isatty() if live is None else live
    heard = Heard()
    screen = Live(heard.table(), refresh_per_second=_REFRESH) if live else nullcontext()
    with suppress(KeyboardInterrupt), plain_node('sosml_watch', namespace) as (node, executor):
        for topic in _TOPICS:
            node.create_subscription(JointState, topic, partial(heard.take, topic), _NEWEST)
        node.create_subscription(DiagnosticArray, '/diagnostics', heard.on_diagnostics, _NEWEST)
        end = math.inf if seconds is None else time.monotonic() + seconds
        with screen as shown:
            while time.monotonic() < end:
                _listen(executor)
                if shown is not None:
                    shown.update(heard.table())
    return heard


def _listen(executor: Executor) -> None:
    """Take all that comes until the table is drawn anew."""
    end = time.monotonic() + 1.0 / _REFRESH
    while (left := end - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=left)
