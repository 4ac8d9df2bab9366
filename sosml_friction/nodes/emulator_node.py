# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Answer CAN frames as the exoskeleton's actuators would, in real time."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter

from sosml_friction.actuators.bus.open_bus import SLCAN_SERVER, open_bus
from sosml_friction.actuators.driver.configuration import joints_from_parameters
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator, hanging_position
from sosml_friction.actuators.emulator.emulator_thread import EmulatorThread
from sosml_friction.actuators.emulator.fault import FAULTS, parse_faults
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.exceptions import ActuatorError, ConfigurationError
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.actuator_parameters import all_joint_specs, declare_joints, specs_of
from sosml_friction.nodes.diagnostics import OK, WARN, full_name, make_array, make_status
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.parameters import ParameterSpec, declare
from sosml_friction.nodes.program_node import ProgramNode
from sosml_friction.nodes.run import run_node
from sosml_friction.share import share_directory

_RANGES = {'double': (0.0, 1e6), 'integer': (1, 2**31 - 1)}

_OWN_PARAMETERS = (
    ParameterSpec('joints', 'string_array', None, 'the joints, in the order of the model'),
    ParameterSpec(
        'model',
        'string',
        '',
        'the model folder that is the truth; empty: config/emulated_exoskeleton of the package',
    ),
    ParameterSpec(
        'can_interface',
        'string',
        SLCAN_SERVER,
        'slcan_server (slcan on a TCP port or a terminal) or any python-can interface',
    ),
    ParameterSpec(
        'can_channel',
        'string',
        '127.0.0.1:29536',
        'its channel; HOST:PORT of the server, or pty:PATH',
    ),
    ParameterSpec(
        'can_bitrate', 'integer', 1000000, 'the bit rate', unit='bit/s', range=(10000, 1000000)
    ),
    ParameterSpec('seed', 'integer', 0, 'of all noise', range=(0, 2**31 - 1)),
    ParameterSpec(
        'start_position',
        'double_array',
        [],
        'where the joints rest at the start; empty: hanging, -pi/2 and zeros',
        unit='rad or m',
    ),
    ParameterSpec(
        'faults',
        'string',
        '',
        'the faults that stand now (may be set while it runs; see docs/faults.md), with '
        'semicolons between them, as in drop joint=shoulder fraction=0.5; one of '
        + ', '.join(fault.name for fault in FAULTS),
        read_only=False,
    ),
)


def _option_specs() -> tuple[ParameterSpec, ...]:
    """Return the rows of the hardware's options, all types of actuator."""
    return tuple(
        replace(spec, range=_RANGES.get(spec.type))
        for spec in specs_of(EmulatorOptions.parameters())
    )


PARAMETERS = (*_OWN_PARAMETERS, *_option_specs(), *all_joint_specs(mount=True))


class EmulatorNode(ProgramNode):
    """
    Run :class:`ExoskeletonEmulator` on a CAN bus; it publishes nothing but ``/diagnostics``.

    The parameter ``faults`` may be set while it runs: what is new in it begins, what is gone ends,
    an empty one ends all. A fault that does not exist is refused with a reason.

    :raises SosmlFrictionError: if a parameter, the model or the bus does not fit.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('emulator_node', **kwargs)
        self._lost_s = 0.0
        values = declare(self, _OWN_PARAMETERS)
        values |= declare_joints(self, values['joints'], mount=True)
        options = EmulatorOptions(**declare(self, _option_specs()))
        model_path = Path(values['model'] or share_directory() / 'config' / 'emulated_exoskeleton')
        mounts = joints_from_parameters(values)
        self._emulator = ExoskeletonEmulator(
            read_model(model_path),
            mounts,
            values['start_position'] or hanging_position(len(mounts)),
            options=options,
            seed=values['seed'],
        )
        parse_faults(values['faults'], self._emulator.names)
        self._bus = open_bus(values['can_interface'], values['can_channel'], values['can_bitrate'])
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_timer(1.0, self._on_timer)
        self._thread = EmulatorThread(self._bus, self._emulator)
        self._thread.set_faults(values['faults'])
        self.add_on_set_parameters_callback(self._on_parameters)
        self._thread.start()
        self.get_logger().info(
            f'emulating {model_path} on {values["can_interface"]} {self._bus.channel_info}'
        )

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name != 'faults':
                continue
            try:
                self._thread.set_faults(str(parameter.value))
            except ConfigurationError as error:
                return SetParametersResult(successful=False, reason=str(error))
            self.get_logger().info(f'faults: {parameter.value or "none"}')
        return SetParametersResult(successful=True)

    def _on_timer(self) -> None:
        if self._thread.error is not None:
            self.end(ActuatorError(f'the emulation ended: {self._thread.error!r}'))
        name = full_name(self)
        emulator = self._emulator
        q, v, effort = emulator.q, emulator.v, emulator.effort
        lost_s = self._thread.lost_ns * 1e-9
        level, text = OK, 'running'
        if lost_s > self._lost_s:
            level = WARN
            text = (
                f'the machine did not get to the emulation for {lost_s - self._lost_s:.3f} s, in '
                'which no emulated joint moved: end other programs'
            )
        self._lost_s = lost_s
        statuses = [
            make_status(
                f'{name}: plant',
                level,
                text,
                {
                    'emulated time [s]': emulator.time_ns * 1e-9,
                    'time lost [s]': lost_s,
                    'frames foreign': emulator.foreign_frames,
                    'faults': '; '.join(map(str, emulator.faults)) or 'none',
                },
            )
        ]
        for i, actuator in enumerate(emulator.actuators):
            values = {
                'true position': float(q[i]),
                'true velocity': float(v[i]),
                'true effort': float(effort[i]),
                'commanded current [A]': actuator.commanded_current,
                **actuator.counters(),
            }
            statuses.append(make_status(f'{name}: {actuator.name}', OK, 'running', values))
        self._diagnostics.publish(make_array(self.get_clock().now().to_msg(), statuses))

    def destroy_node(self) -> None:
        """Stop the emulation and close the bus."""
        self._thread.stop()
        self._bus.shutdown()
        super().destroy_node()


def make_emulator_node() -> EmulatorNode:
    """
    Make the node.

    :raises SosmlFrictionError: why it cannot start.
    """
    # As in the driver: replies are due within a fraction of a millisecond.
    sys.setswitchinterval(5e-4)
    return EmulatorNode()


HELP = NodeHelp(
    'emulator_node',
    'Answers CAN frames as the actuators of the exoskeleton would, over a simulated arm with '
    'friction: for trying the driver without hardware.',
    '--ros-args --params-file config/exoskeleton.yaml',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit code."""
    return run_node(make_emulator_node, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
