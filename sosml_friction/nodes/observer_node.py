# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
observer_node: joint_states in, friction_estimate out, at whatever rate they come.

Everything follows from the messages and their stamps, so a replayed bag gives the same numbers at
any speed. A position that wraps is made continuous. ``friction_estimate`` is the friction torque
tau_f in ``effort``, positive for positive velocity; NaN in it marks a fresh start (first sample,
after a gap, after ``~/reset``).

Of the effects that a diagnosed model lists, those of the effort's measurement are undone before
the observers (:class:`~sosml_friction.model.effort_correction.EffortCorrection`); the others are
what the joint spends beside its rigid body, and so part of tau_f.
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sosml_friction.arrays import IndexArray
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.wrap import RunningUnwrap
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError
from sosml_friction.model.effort_correction import EffortCorrection
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.nodes.diagnostics import ERROR, OK, STALE, WARN, make_array, make_status
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.parameters import ParameterSpec, declare
from sosml_friction.nodes.program_node import ProgramNode
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.nodes.run import run_node
from sosml_friction.nodes.stated_model import WITHOUT_MODEL, MeasuredJoints, StatedModel
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.observers.log_conditions import DEFAULT_OBSERVERS
from sosml_friction.observers.momentum_sampler import EFFORT_HOLDS, VELOCITY_SOURCES
from sosml_friction.observers.recipe import BANDWIDTH, recipe_gains
from sosml_friction.observers.registry import OBSERVERS, on_line_names, refuse_offline

#: Unusable messages, without a usable one, after which the node ends with a sentence. Chosen, no
#: measurement.
PATIENCE = 50
#: Time without a robot_description after which the node warns that it waits [s]. Chosen, no
#: measurement.
QUIET = 5

_OPTIONS = (
    ParameterSpec(
        'model',
        'string',
        '',
        'model folder with the armature of the joints; empty: exoskeleton, or with armature the '
        'robot of robot_description',
    ),
    *WITHOUT_MODEL,
    ParameterSpec(
        'urdf_path', 'string', '', 'URDF file; empty: wait for the topic robot_description'
    ),
    ParameterSpec(
        'configuration',
        'string',
        '',
        'bag, or file of its observer_configuration, whose observers and gains are run instead of '
        'those below: for a replay that gives the same numbers',
    ),
    ParameterSpec('observers', 'string_array', list(DEFAULT_OBSERVERS), 'observers to run'),
    ParameterSpec(
        'selected', 'string', 'sosml', 'observer whose output is published as friction_estimate'
    ),
    ParameterSpec(
        'friction_jump',
        'double_array',
        [],
        'change of friction at a reversal, twice its level, of each joint: gains are made from it '
        'and the three that follow (sosml tune measures them in a bag); empty: from bandwidth',
        'Nm or N',
    ),
    ParameterSpec(
        'reversal_time', 'double_array', [], 'time between reversals of each joint', 's'
    ),
    ParameterSpec(
        'position_noise',
        'double_array',
        [],
        'standard deviation of the position of each joint, resolution / sqrt(12) included',
        'rad or m',
    ),
    ParameterSpec(
        'velocity_noise',
        'double_array',
        [],
        'standard deviation of the velocity of each joint; with bandwidth alone, empty: no '
        'sliding term is added',
        'rad/s or m/s',
    ),
    ParameterSpec(
        'bandwidth',
        'double',
        BANDWIDTH,
        'bandwidth the gains are made for, where neither friction_jump nor they are given',
        'rad/s',
        (0.1, 1e4),
    ),
    ParameterSpec(
        'effort_hold',
        'string_array',
        ['start'],
        'where in an interval an effort sample holds, for all joints or one for each: '
        f'{", ".join(EFFORT_HOLDS)}',
    ),
    ParameterSpec(
        'velocity_source',
        'string',
        'message',
        'velocity of joint_states, or backward difference of its position',
        choices=VELOCITY_SOURCES,
    ),
    ParameterSpec(
        'maximum_gap',
        'double',
        0.05,
        'a longer gap starts the observers afresh',
        's',
        (1e-4, 10.0),
    ),
    ParameterSpec(
        'reliability',
        'string',
        'reliable',
        'of the subscription to joint_states; best_effort for a driver that publishes so',
        choices=('reliable', 'best_effort'),
    ),
)


def parameters() -> tuple[ParameterSpec, ...]:
    """Return the table with the gains of every observer that there is by now."""
    gains = (
        ParameterSpec(
            f'{name}.{gain}',
            'double_array',
            [],
            f'gain of observer {name}, one for each joint; empty: by recipe',
            unit,
        )
        for name in on_line_names()
        for gain, unit in OBSERVERS[name].gain_units.items()
    )
    return (*_OPTIONS, *gains)


PARAMETERS = parameters()


class ObserverNode(ProgramNode):
    """
    Run momentum observers on joint_states.

    Where parameters, URDF and joint_states turn out not to fit together the program ends with exit
    code 2.

    :raises ConfigurationError: if the parameters do not fit.
    """

    def __init__(self) -> None:
        super().__init__('observer_node')
        self._p = declare(self, parameters())
        self._stated = StatedModel(self._p)
        self._measured: MeasuredJoints | None = None
        self._early: list[JointState] = []
        self._correction: EffortCorrection | None = None
        if self._stated.model is not None:
            self._correct(self._stated.model)
        refuse_offline(self._p['observers'])
        unknown = [name for name in self._p['observers'] if name not in OBSERVERS]
        if unknown or self._p['selected'] not in self._p['observers']:
            raise ConfigurationError(
                f'observers {self._p["observers"]} with {self._p["selected"]!r} selected: choose '
                f'from {", ".join(on_line_names())} and select one that runs'
            )
        self._estimator: Any = None
        self._columns: dict[tuple[str, ...], IndexArray | None] = {}
        self._unusable = {'joints': 0, 'effort': 0, 'velocity': 0}
        self._has_estimated = False
        self._lost = 0
        self._published = 0
        self._waited = 0
        self._first_ns = self._last_ns = 0
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._timer = self.create_timer(
            1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self.create_service(Trigger, '~/reset', self._on_reset)
        if self._p['urdf_path']:
            try:
                urdf = Path(self._p['urdf_path']).read_text(encoding='utf-8')
            except (OSError, UnicodeDecodeError) as error:
                raise ConfigurationError(
                    f'URDF {self._p["urdf_path"]} (parameter urdf_path) cannot be read: give the '
                    'path of a file'
                ) from error
            if self._stated.model is not None:
                # What is stated counts, even beside a model whose rigid body was identified.
                self._stated.model = replace(self._stated.model, urdf=urdf)
            self._take(urdf)
        else:
            self.create_subscription(String, 'robot_description', self._on_description, LATCHED)

    def _on_description(self, message: String) -> None:
        if self._estimator is not None or self._measured is not None:
            return
        try:
            self._take(message.data)
            if self._stated.model is not None and self._stated.model.is_rigid_body_identified:
                self.get_logger().info('the URDF of the model is used, not robot_description')
        except SosmlFrictionError as error:
            self.end(error)

    def _correct(self, model: RobotModelFile) -> None:
        names = ', '.join(model.joint_names)
        self.get_logger().info(f'model {self._stated.label}: joints {names}')
        correction = EffortCorrection(model)
        if correction:
            self.get_logger().info(f'effort is corrected: {", ".join(correction.done)}')
            self._correction = correction
        for sentence in correction.left_out:
            self.get_logger().warning(sentence)

    def _take(self, urdf: str) -> None:
        """Begin; or wait for joint_states, if it has to say which joints there are, or where."""
        if self._stated.model is None and self._stated.joints:
            self._correct(self._stated.make(urdf))
        model = self._stated.model
        robot = None if model is None else self._stated.robot(urdf)
        if model is not None and robot is not None and not robot.remarks and not model.unseen:
            self._begin(robot)
            return
        self._measured = MeasuredJoints(urdf, PATIENCE)
        self._urdf = urdf
        self._subscribe()
        self.get_logger().info('waiting for joint_states, to know which joints are measured')

    def _see_joints(self, measured: MeasuredJoints, message: JointState) -> None:
        """Keep a message until it is known which joints there are, and begin with all of them."""
        self._early.append(message)
        measured.see(message.name, message.position)
        if measured.known is None:
            return
        early, self._early = self._early, []
        try:
            model = self._stated.model
            if model is None:
                model = self._stated.make(self._urdf, measured.known)
                self._correct(model)
            self._stated.model = model.of_measured(measured.known)
            self._begin(self._stated.robot(self._urdf, measured.first))
        except SosmlFrictionError as error:
            self.end(error)
            return
        for kept in early:
            self._on_joint_states(kept)

    def _begin(self, robot: Robot) -> None:
        for sentence in robot.remarks:
            self.get_logger().warning(sentence)
        configuration = self._configure(robot)
        refuse_offline(configuration.gains)
        self._estimator = configuration.make_estimator(robot)
        self._unwrap = RunningUnwrap(robot.n)
        self._joints = list(robot.names)
        self._outputs = {
            name: self.create_publisher(JointState, f'friction_estimate/{name}', JOINT_STATES)
            for name in self._estimator.observers
        }
        self._selected_output = self.create_publisher(
            JointState, 'friction_estimate', JOINT_STATES
        )
        self._configuration_output = self.create_publisher(
            String, 'observer_configuration', LATCHED
        )
        self._configuration_output.publish(String(data=configuration.to_yaml()))
        if self._measured is None:
            self._subscribe()
        self.get_logger().info(f'observing {", ".join(self._joints)}')

    def _subscribe(self) -> None:
        # Only now: whoever waits for this subscription knows that every message will be estimated.
        qos = JOINT_STATES
        if self._p['reliability'] == 'best_effort':
            qos = QoSProfile(depth=JOINT_STATES.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
        events = SubscriptionEventCallbacks(message_lost=self._on_lost)
        try:
            self.create_subscription(
                JointState, 'joint_states', self._on_joint_states, qos, event_callbacks=events
            )
        except UnsupportedEventTypeError:
            self.create_subscription(JointState, 'joint_states', self._on_joint_states, qos)

    def _configure(self, robot: Robot) -> ObserverConfiguration:
        p = self._p
        if p['configuration']:
            return self._configuration_of(Path(p['configuration']))
        recipe = recipe_gains(
            robot,
            p['bandwidth'],
            p['position_noise'],
            p['velocity_noise'],
            p['friction_jump'],
            p['reversal_time'],
        )
        gains: dict[str, dict[str, Sequence[float]]] = {}
        for name in p['observers']:
            given = {
                gain: p[f'{name}.{gain}']
                for gain in OBSERVERS[name].gain_units
                if p[f'{name}.{gain}']
            }
            missing = [gain for gain in OBSERVERS[name].gain_units if gain not in given]
            if missing and name not in recipe:
                lacking = ', '.join(f'{name}.{gain}' for gain in missing)
                raise ConfigurationError(
                    f'observer {name} has no gains by bandwidth: set the parameters '
                    'friction_jump, reversal_time, position_noise and velocity_noise (sosml tune '
                    f'measures them in a bag), or {lacking}'
                )
            gains[name] = {**recipe.get(name, {}), **given}
        holds = p['effort_hold']
        return ObserverConfiguration(
            robot.names,
            gains,
            tuple(holds * robot.n if len(holds) == 1 else holds),
            p['velocity_source'],
            p['maximum_gap'],
        )

    def _configuration_of(self, source: Path) -> ObserverConfiguration:
        if source.suffix == '.yaml' and source.is_file():
            text: str | None = source.read_text(encoding='utf-8')
        else:
            text = Bag.open(source).text('observer_configuration')
        if text is None:
            raise ConfigurationError(
                f'bag {source} (parameter configuration) has no observer_configuration: give the '
                'gains by the other parameters'
            )
        configuration = parse_configuration(text, f'the observer_configuration of {source}')
        # What is selected may not be among them: the first one then speaks for all.
        if self._p['selected'] not in configuration.gains:
            self._p['selected'] = next(iter(configuration.gains))
        return configuration

    def _on_joint_states(self, message: JointState) -> None:
        if self._estimator is None and self._measured is not None:
            self._see_joints(self._measured, message)
            return
        names = tuple(message.name)
        if names not in self._columns:
            known = set(self._joints) <= set(names)
            self._columns[names] = (
                np.array([names.index(name) for name in self._joints]) if known else None
            )
        columns = self._columns[names]
        if columns is None:
            self._count_unusable(
                'joints',
                f'joint_states has the joints {", ".join(names) or "(none)"} where the model has '
                f'{", ".join(self._joints)}: name them alike or give another model',
            )
            return
        q, v, tau = (
            np.array(values)[columns]
            if len(values) == len(names)
            else np.full(len(columns), np.nan)
            for values in (message.position, message.velocity, message.effort)
        )
        if not np.isfinite(tau).any():
            self._count_unusable(
                'effort',
                'joint_states carries no effort, and without it friction cannot be told from '
                'motion: make the driver publish effort in Nm or N',
            )
        elif self._p['velocity_source'] == 'message' and not np.isfinite(v).any():
            self._count_unusable(
                'velocity',
                'joint_states carries no velocity: make the driver publish it or set parameter '
                'velocity_source to position_difference',
            )
        t_ns = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        q = self._unwrap(t_ns, q)
        if self._correction is not None:
            tau = self._correction.torque(tau)
        estimates = self._estimator.update(t_ns, q, v, tau)
        if estimates is None:
            return
        self._first_ns = self._first_ns or t_ns
        self._last_ns = t_ns
        self._published += 1
        self._has_estimated |= bool(np.isfinite(estimates[self._p['selected']]).any())
        result = JointState(header=message.header, name=self._joints)
        result.position, result.velocity = q.tolist(), v.tolist()
        for name, publisher in self._outputs.items():
            result.effort = estimates[name].tolist()
            publisher.publish(result)
            if name == self._p['selected']:
                self._selected_output.publish(result)

    def _count_unusable(self, what: str, sentence: str) -> None:
        # Another publisher may share the topic, so one such message is no error; only such are.
        self._unusable[what] += 1
        if self._unusable[what] >= PATIENCE and not self._has_estimated:
            self.end(ConfigurationError(sentence))

    def _on_lost(self, event: Any) -> None:
        self._lost += int(event.total_count_change)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._estimator is None:
            response.success, response.message = False, 'waiting for robot_description'
            return response
        self._estimator.reset()
        # As measured again: a period is known for good.
        self._unwrap = RunningUnwrap(len(self._joints), self._unwrap.periods)
        response.success, response.message = True, 'the next joint_states starts the observers'
        return response

    def _diagnose(self) -> None:
        name = self.get_name()
        if self._estimator is None:
            waiting = 'waiting for robot_description: start the driver, or set parameter urdf_path'
            if self._measured is not None:
                waiting = 'waiting for joint_states, to know which joints are measured'
            self._waited += 1
            if self._waited == QUIET:
                self.get_logger().warning(waiting)
            status = make_status(f'{name}: observers', STALE, waiting, {})
            self._report([status])
            return
        counts = self._estimator.counts
        span = (self._last_ns - self._first_ns) * 1e-9
        values = {
            'samples': counts.samples,
            'estimates published': self._published,
            'rate by stamps [Hz]': (self._published - 1) / span if span > 0.0 else math.nan,
            'messages lost by DDS': self._lost,
            'gaps': counts.gaps,
            'repeated stamps': counts.repeated_stamps,
            'time backwards': counts.time_backwards,
            'position or velocity not finite': counts.not_finite,
            'messages of other joints': self._unusable['joints'],
        }
        trouble = self._lost + counts.gaps + counts.time_backwards + counts.repeated_stamps
        message = (
            f'observing {len(self._joints)} joints' if counts.samples else 'no joint_states yet'
        )
        level = STALE if not counts.samples else WARN if trouble else OK
        statuses = [make_status(f'{name}: observers', level, message, values)]
        for joint in self._joints:
            missing = counts.without_effort.get(joint, 0)
            if counts.samples and missing == counts.samples:
                text = 'friction of this joint unavailable: its actuator reports no current'
                statuses.append(make_status(f'{name}: {joint}', ERROR, text, {}))
            else:
                level = WARN if missing else OK
                text = f'{missing} samples without effort' if missing else 'estimating'
                statuses.append(make_status(f'{name}: {joint}', level, text, {}))
        self._report(statuses)

    def _report(self, statuses: list[Any]) -> None:
        self._diagnostics.publish(make_array(self.get_clock().now().to_msg(), statuses))


HELP = NodeHelp(
    'observer_node',
    'Takes joint_states and robot_description and publishes friction_estimate: the friction '
    'torque in effort, positive for positive velocity, at the rate the states come. ~/reset '
    'starts the observers afresh.',
    '--ros-args -p model:=config/exoskeleton',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node; the exit code is 0 after a signal, 2 if the configuration cannot work."""
    return run_node(ObserverNode, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
