# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Run one node as a program: executor, signals, exit code."""

import gc
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.program_node import ProgramNode

# How soon a signal is seen where nothing comes [s]: Python runs its handlers between two waits of
# the executor. With an unlimited wait the EventsExecutor of rclpy 7.1.6 dispatches nothing.
_SPIN_TIMEOUT = 0.1


def make_executor() -> Executor:
    """Return the EventsExecutor where rclpy has one (half the CPU), else the single-threaded."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


@contextmanager
def plain_node(name: str, namespace: str = '') -> Iterator[tuple[Node, Executor]]:
    """Yield a node and its executor for a program that is no node itself, and end both with it."""
    # Ctrl-C is the program's own to handle: rclpy's handler would only end the context.
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = Node(name, namespace=namespace)
    try:
        executor = make_executor()
        executor.add_node(node)
        try:
            yield node, executor
        finally:
            executor.remove_node(node)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def stop_requested() -> bool:
    """Tell whether a signal asked this program to end: for what waits inside a callback."""
    return _stop is not None and _stop.is_set()


def run_node(
    factory: Callable[[], Node | Sequence[Node]],
    args: Sequence[str] | None = None,
    help_: NodeHelp | None = None,
) -> int:
    """
    Run what ``factory`` makes until SIGINT, SIGTERM or its own end, and return the exit code.

    That is one node, or several in one executor, of which any may end the program; they are
    destroyed in their order.

    Where ``args`` ask for ``--help``, ``help_`` is printed instead, without starting ROS.

    0 after a signal, after :meth:`ProgramNode.end` (the code it was given) and after
    the context was shut down; 2 after a :class:`SosmlFrictionError` from the factory or a
    callback, or after ROS arguments that cannot be read, with one sentence on stderr (rclpy logs
    an exception of a callback as well: refuse bad configuration in the factory). A node's
    ``destroy_node`` is called in every case, while the ROS context is still valid, so that it can
    still publish; a second signal does not cut it short.
    """
    if help_ is not None and help_.asked_for(args):
        print(help_.text(), end='')
        return 0
    # What is imported stays: to look for garbage among its 270 000 objects takes 0.2 s at a time.
    gc.freeze()
    try:
        # Our own handlers: rclpy's would shut the context down before destroy_node().
        rclpy.init(
            args=None if args is None else list(args),
            signal_handler_options=SignalHandlerOptions.NO,
        )
    except Exception as error:  # rclpy raises several types, none of them documented
        return _refuse(error, 'ROS arguments cannot be read')
    nodes: Sequence[Node] = ()
    global _stop
    stop = _stop = _StopSignal()
    try:
        made = factory()
        nodes = [made] if isinstance(made, Node) else made
        programs = [node for node in nodes if isinstance(node, ProgramNode)]
        for program in programs:
            program.refuse_unknown_parameters()
        executor = make_executor()
        for node in nodes:
            executor.add_node(node)
        try:
            while rclpy.ok() and not stop.is_set() and not any(own.outcome for own in programs):
                executor.spin_once(timeout_sec=_SPIN_TIMEOUT)
        finally:
            # Also where a callback raised: messages still come, for nodes that are destroyed next.
            for node in nodes:
                executor.remove_node(node)
        for program in programs:
            if program.outcome is not None:
                raise program.outcome
    except SosmlFrictionError as error:
        # A factory that a signal ends says what it waited for, which nobody asked.
        return 0 if not nodes and stop.is_set() else _refuse(error)
    except OSError as error:
        return _refuse(error, 'a file cannot be used')
    except RCLError as error:
        if nodes:
            raise
        return _refuse(error, 'the node cannot start')
    except SystemExit as request:
        return request.code if isinstance(request.code, int) else 0
    except (KeyboardInterrupt, ExternalShutdownException, ROSInterruptException):
        return 0
    finally:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
        stop.restore()
        _stop = None
    return 0


def _refuse(error: Exception, what: str = '') -> int:
    text = ' '.join(str(error).split())
    print(f'{what}: {text}' if what else text, file=sys.stderr)
    return 2


class _StopSignal:
    """
    Turn SIGINT, SIGTERM, SIGHUP and SIGQUIT into a flag, at which :func:`run_node` looks.

    Outside the main thread (tests) signals are left alone.
    """

    def __init__(self) -> None:
        self._event = threading.Event()
        self.is_set = self._event.is_set
        self._before: dict[int, Any] = {}
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
                self._before[number] = signal.signal(number, lambda *_: self._event.set())

    def restore(self) -> None:
        """Give the signals back to whoever had them before."""
        for number, handler in self._before.items():
            signal.signal(number, handler)


_stop: _StopSignal | None = None
