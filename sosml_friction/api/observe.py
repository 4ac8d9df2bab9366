# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Run momentum observers over a recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sosml_friction.api.logs import one_log, velocity_of
from sosml_friction.api.model import Model, content_of
from sosml_friction.api.names import as_names
from sosml_friction.api.result import Result
from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import as_recorded
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.log_analysis import effort_holds
from sosml_friction.identification.number_text import format_number
from sosml_friction.model.effort_correction import EffortCorrection
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.log_conditions import configuration_for
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.labels import observer_label


@dataclass(frozen=True, repr=False)
class Observation(Result):
    """
    Hold the friction that observers estimated.

    ``friction`` by observer (N, n) [Nm or N] on the stamps of ``log``, positive for positive
    velocity, NaN where an observer had just started; ``configuration``: the gains that ran.
    ``log`` has the joints in the order of the model, and its effort is the torque at the joint.
    ``told``: what is wrong with the data, a sentence each, as :func:`sosml_friction.fit` says it.
    """

    log: JointLog
    friction: Mapping[str, FloatArray]
    units: tuple[str, ...]
    configuration: ObserverConfiguration
    told: tuple[str, ...] = ()

    def summary(self) -> str:
        """Return the median of each estimate in either direction, after what is wrong."""
        lines, v = list(self.told), velocity_of(self.log)
        for name, tau_f in self.friction.items():
            for i, joint in enumerate(self.log.names):
                levels = [
                    float(np.median(known)) if len(known) else np.nan
                    for side in (1.0, -1.0)
                    for known in [tau_f[side * v[:, i] > 0.0, i]]
                    for known in [known[np.isfinite(known)]]
                ]
                lines.append(
                    f'{joint}, {observer_label(name)}: median friction {format_number(levels[0])} '
                    f'{self.units[i]} forwards, {format_number(levels[1])} {self.units[i]} '
                    'backwards'
                )
        return '\n'.join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return stamps, joints, gains and estimates, ready for JSON; unknown is None."""
        return to_plain(
            {
                'joints': self.log.names,
                'units': self.units,
                'gains': self.configuration.gains,
                't_ns': self.log.t_ns,
                'friction': self.friction,
                'told': self.told,
            }
        )

    def _brief(self) -> str:
        names = f'{", ".join(self.friction)} of {", ".join(self.log.names)}'
        return f'{names}, {len(self.log)} samples'


def observe(
    log: JointLog,
    model: Model,
    observers: str | Sequence[str] | None = None,
    bandwidth: float | None = None,
    effort_hold: Mapping[str, str] | str | None = None,
) -> Observation:
    """
    Estimate the friction of every joint along a recording.

    What the model knows of the effort's measurement (scale, bias, ...) is undone first. Whatever
    the data are, there are estimates: ``told`` says why they may be none.

    :param log: the motion; its joints include the model's.
    :param observers: which, one or several; first_order and sosml if None.
    :param bandwidth: [rad/s] of all observers; None for gains from the noise, friction and motion
        measured in the log where ``observers`` are named, and the usual bandwidth otherwise.
    :param effort_hold: by joint, where in an interval its effort holds: ``start`` (a command
        that is held; also where nothing is said), ``mean`` (a value measured at its stamp) or
        ``end`` (a mean since the sample before).
    :raises ConfigurationError: if an observer is unknown or has no gains by bandwidth.
    :raises DataError: if a joint is missing, no joint has effort, or the log is too short.
    """
    content = content_of(model)
    robot = as_recorded(content, one_log(log)).make_robot()
    log = log.select(robot.names)
    log.require_effort()
    log = replace(log, tau=EffortCorrection(content).torque(log.tau))
    holds = effort_holds(robot.names, effort_hold or {}, None)
    configuration = configuration_for(log, robot, bandwidth, holds, as_names(observers))
    friction = configuration.make_estimator(robot).batch(log)
    try:
        told = check_data(log, robot, free_rotors=content.unknown_armature)[1].sentences
    except DataError as error:
        told = (str(error),)
    return Observation(log, friction, robot.effort_units, configuration, told)
