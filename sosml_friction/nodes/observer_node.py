# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
observer_node: joint_states in, friction_estimate out, at whatever rate they come.

Everything follows from the messages and their stamps, so a replayed bag gives the same numbers at
any speed. A position that wraps is made continuous. ``friction_estimate`` is the friction torque
tau_f in ``effort``, positive for positive velocity; NaN in it marks what is not known: a fresh
start (first sample, after a gap, after ``~/reset``), or a sample that cannot be true
(:class:`~sosml_friction.observers.plausibility.Plausibility`). ``friction_estimate_error`` has its
standard error in ``effort``, sample by sample, NaN also while the estimate settles. The
diagnostics judge the last second (:class:`~sosml_friction.nodes.observer_health.ObserverHealth`).

Of the effects that a diagnosed model lists, those of the effort's measurement are undone before
the observers (:class:`~sosml_friction.model.effort_correction.EffortCorrection`); the others are
what the joint spends beside its rigid body, and so part of tau_f.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_state_form import JointStateForm, plain
from sosml_friction.bags.message_definitions import JOINT_STATE
from sosml_friction.bags.running_unwrap import RunningUnwrap
from sosml_friction.bags.serialization import deserialize
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError
from sosml_friction.model.effort_correction import EffortCorrection
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.nodes.diagnostics import (
    ERROR,
    OK,
    STALE,
    WARN,
    full_name,
    make_array,
    make_status,
)
from sosml_friction.nodes.fresh_start import tell_start
from sosml_friction.nodes.joint_states_topic import JointStatesTopic
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.observer_health import ObserverHealth, Said
from sosml_friction.nodes.observer_parameters import configuration_of, parameters
from sosml_friction.nodes.parameters import declare
from sosml_friction.nodes.program_node import ProgramNode
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.nodes.run import run_node
from sosml_friction.nodes.stated_model import MeasuredJoints, StatedModel
from sosml_friction.observers import registry
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.watched_estimator import WatchedEstimator
from sosml_friction.text_file import read_text

#: Unusable messages, without a usable one, after which the node ends with a sentence. Chosen, no
#: measurement.
PATIENCE = 50
#: Time without a robot_description after which the node warns that it waits [s]. Chosen, no
#: measurement.
QUIET = 5
_LEVELS = {'ok': OK, 'warn': WARN, 'error': ERROR, 'stale': STALE}

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
        self._early: list[bytes] = []
        self._correction: EffortCorrection | None = None
        if self._stated.model is not None:
            self._correct(self._stated.model)
        self._refuse_observers()
        self._watch: WatchedEstimator | None = None
        self._topic: JointStatesTopic | None = None
        self._health = ObserverHealth(())
        #: By the length of a message; and all lists of names that were heard.
        self._forms: dict[int, JointStateForm] = {}
        #: By the names of a message: how those of joints that are held are read, if it has any.
        self._held_forms: dict[tuple[str, ...], JointStateForm] = {}
        self._names: set[tuple[str, ...]] = set()
        self._unusable = {'joints': 0, 'effort': 0, 'velocity': 0}
        self._has_estimated = False
        self._last_ns: int | None = None
        self._waited = 0
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._timer = self.create_timer(
            1.0, self._diagnose, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self.create_service(Trigger, '~/reset', self._on_reset)
        if self._p['urdf_path']:
            urdf = read_text(self._p['urdf_path'], 'parameter urdf_path: URDF')
            if self._stated.model is not None:
                # What is stated counts, even beside a model whose rigid body was identified.
                self._stated.model = replace(self._stated.model, urdf=urdf)
            self._take(urdf)
        else:
            self.create_subscription(String, 'robot_description', self._on_description, LATCHED)

    def _refuse_observers(self) -> None:
        registry.refuse_offline(self._p['observers'])
        unknown = [name for name in self._p['observers'] if name not in registry.OBSERVERS]
        if unknown or self._p['selected'] not in self._p['observers']:
            raise ConfigurationError(
                f'observers {self._p["observers"]} with {self._p["selected"]!r} selected: choose '
                f'from {", ".join(registry.on_line_names())} and select one that runs'
            )

    def _on_description(self, message: String) -> None:
        if self._watch is not None or self._measured is not None:
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
        if model is not None and robot is not None and not model.unseen:
            # Which joints there are is known: what does not fit them is refused now.
            self._passive(robot)
            configuration_of(self._p, robot)
        self._measured = MeasuredJoints(urdf, PATIENCE)
        self._urdf = urdf
        self._subscribe()
        self.get_logger().info('waiting for joint_states, to know which joints are measured')

    def _see_joints(self, measured: MeasuredJoints, cdr: bytes) -> None:
        """Keep a message until it is known which joints there are, and begin with all of them."""
        self._early.append(cdr)
        message = deserialize(cdr, JOINT_STATE)
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
        # What was set while the node waited counts.
        self._p |= declare(self, [spec for spec in parameters() if not spec.read_only])
        self._refuse_observers()
        passive = self._passive(robot)
        configuration = configuration_of(self._p, robot)
        registry.refuse_offline(configuration.gains)
        # What is selected may not be among those of a bag: the first one then speaks for all.
        if self._p['selected'] not in configuration.gains:
            self._p['selected'] = next(iter(configuration.gains))
        self._watch = WatchedEstimator(
            configuration.make_estimator(robot),
            self._p['selected'],
            self._p['limit_excess'],
            passive,
            follows_rate=not (self._p['maximum_gap'] or self._p['configuration']),
            correct=None if self._correction is None else self._correction.torque,
        )
        self._unwrap = RunningUnwrap(robot.n)
        self._joints = list(robot.names)
        self._health = ObserverHealth(robot.names)
        self._outputs = {
            name: self.create_publisher(JointState, f'friction_estimate/{name}', JOINT_STATES)
            for name in configuration.gains
        }
        self._selected_output = self.create_publisher(
            JointState, 'friction_estimate', JOINT_STATES
        )
        self._error_output = self.create_publisher(
            JointState, 'friction_estimate_error', JOINT_STATES
        )
        self._configuration_output = self.create_publisher(
            String, 'observer_configuration', LATCHED
        )
        self._run(configuration)
        self.add_on_set_parameters_callback(self._on_parameters)
        if self._measured is None:
            self._subscribe()
        self.get_logger().info(f'observing {", ".join(self._joints)}')

    def _passive(self, robot: Robot) -> list[str]:
        passive = [name for name in self._p['passive_joints'] if name]
        if unknown := sorted(set(passive) - set(robot.names)):
            raise ConfigurationError(
                f'passive_joints names {", ".join(unknown)}, which is not observed: choose from '
                f'{", ".join(robot.names)}'
            )
        return passive

    def _run(self, configuration: ObserverConfiguration) -> None:
        """Tell everybody which gains run now."""
        self._configuration = configuration
        self._configuration_output.publish(String(data=configuration.to_yaml()))
        if not any(configuration.gains.get('sosml', {}).get('sliding', [1.0])):
            self.get_logger().info(
                'the sliding gains of sosml are 0, and it is the linear observer of second order: '
                'set parameter velocity_noise, and they follow from it',
                once=True,
            )

    def _subscribe(self) -> None:
        # Only now: whoever waits for this subscription knows that every message will be estimated.
        self._topic = JointStatesTopic(
            self, self._p['reliability'], self._on_joint_states, self._on_lost
        )

    def _on_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        """Take other gains or another selected observer, all of them or none."""
        assert self._watch is not None
        gains = {name: dict(values) for name, values in self._configuration.gains.items()}
        selected, changed = self._watch.selected, set()
        for change in changes:
            name, _, gain = change.name.partition('.')
            if change.name == 'selected':
                selected = change.value
            elif gain and name in gains:
                gains[name][gain] = list(change.value)
                changed.add(name)
            elif gain and name in registry.OBSERVERS:
                return SetParametersResult(
                    reason=f'observer {name} does not run: name it in parameter observers'
                )
        if selected not in gains:
            return SetParametersResult(
                reason=f'observer {selected} does not run: select one of {", ".join(gains)}'
            )
        try:
            observers = [registry.make_observer(name, gains[name]) for name in changed]
        except SosmlFrictionError as error:
            return SetParametersResult(reason=str(error))
        if any(observer.n != len(self._joints) for observer in observers):
            return SetParametersResult(
                reason=f'give one value for each of the joints {", ".join(self._joints)}'
            )
        for observer in observers:
            self._watch.replace(observer)
        if selected != self._watch.selected:
            # It settles anew, and so does its error.
            self._watch.select(selected)
        if observers:
            self._run(replace(self._configuration, gains=gains))
        return SetParametersResult(successful=True)

    def _on_joint_states(self, cdr: bytes) -> None:
        watch = self._watch
        if watch is None:
            if self._measured is not None:
                self._see_joints(self._measured, cdr)
            return
        now_s = time.monotonic()
        form = self._forms.get(len(cdr))
        if form is None or not form.fits(cdr):
            cdr = plain(cdr)
            form = self._form(cdr)
        self._see_held(watch, form, cdr)
        if not form.is_known:
            self._health.others(now_s, form.names)
            self._count_unusable(
                'joints',
                f'joint_states has the joints {", ".join(form.names) or "(none)"} where the model '
                f'has {", ".join(self._joints)}: name them alike or give another model',
            )
            return
        if form.is_twice:
            self._health.event(now_s, 'twice')
        t_ns, (q, v, tau) = form.read(cdr)
        if not self._has_estimated:
            self._count_lacking(v, tau)
        q = self._unwrap(t_ns, q)
        taken = watch.update(t_ns, q, v, tau, form.source)
        self._last_ns = t_ns
        if taken is None:
            self._health.heard(now_s, t_ns)
            self._health.event(now_s, 'repeated')
            return
        selected = taken.estimates[watch.selected]
        if not self._has_estimated:
            self._has_estimated = bool(np.isfinite(selected).any())
        self._health.estimated(now_s, t_ns, selected, taken.causes, taken.remarks, taken.repeats)
        for event in taken.events:
            self._health.event(now_s, event)
        if watch.estimator.maximum_gap_s != self._configuration.maximum_gap_s:
            gap_s = watch.estimator.maximum_gap_s
            self.get_logger().info(f'a gap in joint_states is now more than {gap_s:.3g} s')
            self._run(replace(self._configuration, maximum_gap_s=gap_s))

        def message(effort: FloatArray) -> bytes:
            return form.write(cdr, position, velocity, effort.tobytes())

        position, velocity = q.tobytes(), v.tobytes()
        for name, publisher in self._outputs.items():
            if publisher.get_subscription_count():
                publisher.publish(message(taken.estimates[name]))
        # Nobody who comes later gets it, and it costs the most: only where somebody listens.
        if self._selected_output.get_subscription_count():
            self._selected_output.publish(message(selected))
        if self._error_output.get_subscription_count():
            self._error_output.publish(message(taken.error))

    def _see_held(self, watch: WatchedEstimator, form: JointStateForm, cdr: bytes) -> None:
        """Take where held joints are: a gripper may tell in a message of its own."""
        names = [name for name in watch.held.names if name in form.names]
        if not names:
            return
        own = self._held_forms.get(form.names)
        if own is None or not own.fits(cdr):
            own = self._held_forms[form.names] = JointStateForm(cdr, names)
        watch.held.see(dict(zip(names, own.read(cdr)[1][0].tolist(), strict=True)))

    def _form(self, cdr: bytes) -> JointStateForm:
        """Return the form of a message, one of those that came last or a new one."""
        form = self._forms.get(len(cdr))
        if form is None or not form.fits(cdr):
            form = self._forms[len(cdr)] = JointStateForm(cdr, self._joints)
            self._names.add(form.names)
        return form

    def _count_lacking(self, v: FloatArray, tau: FloatArray) -> None:
        assert self._watch is not None
        if not np.isfinite(tau).any():
            self._count_unusable(
                'effort',
                'joint_states carries no effort, and without it friction cannot be told from '
                'motion: make the driver publish effort in Nm or N',
            )
        elif self._watch.estimator.velocity_source == 'message' and not np.isfinite(v).any():
            self._count_unusable(
                'velocity',
                'joint_states carries no velocity: make the driver publish it or set parameter '
                'velocity_source to position_difference',
            )

    def _count_unusable(self, what: str, sentence: str) -> None:
        # Another publisher may share the topic, so one such message is no error; only such are.
        self._unusable[what] += 1
        if self._unusable[what] >= PATIENCE and not self._has_estimated:
            self.end(ConfigurationError(sentence))

    def _on_lost(self, count: int) -> None:
        self._health.event(time.monotonic(), 'lost', count)

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._watch is None:
            response.success, response.message = False, 'waiting for robot_description'
            return response
        self._watch.reset()
        # As measured again: a period is known for good.
        self._unwrap = RunningUnwrap(len(self._joints), self._unwrap.periods)
        response.success, response.message = True, tell_start(self._last_ns)
        return response

    def _diagnose(self) -> None:
        publishers, remark = ([], '') if self._topic is None else self._topic.look()
        if self._watch is None:
            waiting = 'waiting for robot_description: start the driver, or set parameter urdf_path'
            if self._measured is not None:
                waiting = 'waiting for joint_states, to know which joints are measured'
            waiting = remark or waiting
            self._waited += 1
            if self._waited == QUIET:
                self.get_logger().warning(waiting)
            self._report([Said('observers', 'stale', waiting, {})])
            return
        # An arm and its gripper may share the topic: each names its own joints.
        self._watch.several = len(publishers) > len(self._names) > 0
        if self._watch.several:
            remark = remark or (
                f'joint_states has {len(publishers)} publishers ({", ".join(publishers)}): if '
                'more than one sends these joints, stop the others'
            )
        self._health.topic_remark = remark
        said = self._health.judge(time.monotonic(), self._configuration.maximum_gap_s)
        wraps = ', '.join(
            f'{name} by {period:.6g}'
            for name, period in zip(self._joints, self._unwrap.periods, strict=True)
            if np.isfinite(period)
        )
        more = {'publishers': len(publishers), 'positions that wrap': wraps or 'none'}
        said[0] = replace(said[0], values={**said[0].values, **more})
        self._report(said)

    def _report(self, said: Sequence[Said]) -> None:
        name = full_name(self)
        statuses = [
            make_status(f'{name}: {s.component}', _LEVELS[s.level], s.message, s.values)
            for s in said
        ]
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
