# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Driver and observer in one process: each sample is observed where it was measured.

The nodes are driver_node and observer_node with their parameters, topics and services, but no
message goes from one to the other: the driver hands each sample to the observer as soon as it is
published, in the thread that publishes, so that the cycle never waits. A topic joint_states of
another publisher is not heard. The numbers are those of two processes.
"""

import sys
import threading
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sosml_friction.bags.joint_state_form import of_message
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.nodes.driver_node import DriverNode, make_driver_node
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.observer_node import ObserverNode
from sosml_friction.nodes.parameters import ParameterSpec
from sosml_friction.nodes.run import run_node

#: It has those of the two nodes, under their names, and none of its own.
PARAMETERS: tuple[ParameterSpec, ...] = ()


class DirectObserverNode(ObserverNode):
    """
    Observe the samples of a driver in this process.

    The driver's thread and the executor's take turns: samples come in one, parameters, services
    and timers in the other.

    :raises ConfigurationError: if the parameters do not fit.
    """

    def __init__(self, driver: DriverNode) -> None:
        self._driver = driver
        self._turn = threading.RLock()
        super().__init__()

    def describe(self) -> None:
        """Take the robot that the driver describes by now, if it does."""
        if self._driver.description:
            self._on_description(String(data=self._driver.description))

    def refuse_unknown_parameters(self) -> None:
        """
        Refuse as the other nodes do, and say whose parameter it may be.

        :raises ConfigurationError: with the way out.
        """
        try:
            super().refuse_unknown_parameters()
        except ConfigurationError as error:
            raise ConfigurationError(
                f'{error}; a parameter of one of the two nodes is given as '
                '-p driver_node:NAME:=VALUE or -p observer_node:NAME:=VALUE'
            ) from error

    def _subscribe(self) -> None:
        # No topic: nobody publishes what is handed over.
        self._driver.listen(self._on_sample)

    def _on_sample(self, message: JointState) -> None:
        with self._turn:
            self._on_joint_states(of_message(message))

    def _on_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        with self._turn:
            return super()._on_parameters(changes)

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Any:
        with self._turn:
            return super()._on_reset(request, response)

    def _diagnose(self) -> None:
        with self._turn:
            super()._diagnose()


def make_nodes() -> list[Node]:
    """
    Make the driver and the observer of its samples; where one cannot start no output is on.

    :raises SosmlFrictionError: why they cannot start; then no output is on.
    """
    nodes: list[Node] = []
    try:
        nodes.append(driver := make_driver_node(starts=False))
        nodes.append(observer := DirectObserverNode(driver))
        # No motor is asked for anything before it is known that nothing was meant otherwise.
        observer.refuse_unknown_parameters()
        driver.autostart()
        observer.describe()
    except BaseException:
        for node in nodes:
            node.destroy_node()
        raise
    return nodes


HELP = NodeHelp(
    'exoskeleton_node',
    'Runs driver_node and observer_node in one process: the observer is called with each sample, '
    'and the topics are outputs only. Parameters are those of the two nodes, by their names: see '
    'driver_node --help and observer_node --help.',
    '--ros-args --params-file config/exoskeleton.yaml',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit code."""
    return run_node(make_nodes, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
