# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains proposed for a recording, with what they are expected to do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.bags.recorded_robot import RecordedRobot
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.bag_analysis import recorded_configuration
from sosml_friction.identification.log_analysis import effort_holds
from sosml_friction.observers.log_conditions import LogConditions, measure_conditions
from sosml_friction.observers.momentum_sampler import EFFORT_HOLDS
from sosml_friction.observers.recipe import gains_for_conditions
from sosml_friction.observers.registry import OBSERVERS, check_observers
from sosml_friction.observers.search_space import Gains
from sosml_friction.study.expected_performance import Expectation, expected_performance

FORMAT = 'sosml_friction/tune/1'
#: First words of a parameter file, by which an earlier one is known.
_MARK = '# Gains by sosml tune for observer_node:'
#: What a user may state instead of having it measured.
STATED = ('position_noise', 'velocity_noise', 'friction_jump', 'reversal_time')


@dataclass(frozen=True)
class GainProposal:
    """Hold what was measured or stated, the gains made from it, and what they will do."""

    bag: str
    conditions: LogConditions
    stated: Mapping[str, Mapping[str, float]]
    effort_units: tuple[str, ...]
    gains: Mapping[str, Gains]
    expected: Mapping[str, Expectation]
    effort_hold: tuple[str, ...]

    @property
    def on_line(self) -> tuple[str, ...]:
        """Return those observers that can run in a node."""
        return tuple(name for name in self.gains if OBSERVERS[name].causal)


def parse_stated(name: str, entries: Sequence[str], joints: Sequence[str]) -> dict[str, float]:
    """
    Read ``JOINT=VALUE`` or ``VALUE`` for all joints.

    :raises ConfigurationError: if an entry is neither, or names no joint of the robot.
    """
    option = f'--{name.replace("_", "-")}'
    stated: dict[str, float] = {}
    for entry in entries:
        joint, _, text = entry.rpartition('=')
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not 0.0 < value < np.inf:
            raise ConfigurationError(
                f'{option} {entry} has no positive number: write {option} {joints[0]}=VALUE, or '
                'VALUE for all joints'
            )
        if joint and joint not in joints:
            raise ConfigurationError(
                f'{option} {entry} names no joint of this robot: it has {", ".join(joints)}'
            )
        stated.update(dict.fromkeys([joint] if joint else joints, value))
    return stated


def parse_effort_hold(entries: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Read ``JOINT=HOLD`` or ``HOLD`` for all joints.

    :raises ConfigurationError: if an entry is neither, or names no joint of the robot.
    """
    stated: dict[str, str] = {}
    for entry in entries:
        joint, _, hold = entry.rpartition('=')
        if hold not in EFFORT_HOLDS or (joint and joint not in joints):
            raise ConfigurationError(
                f'--effort-hold {entry} is not known: write {" or ".join(EFFORT_HOLDS)}, for all '
                f'joints or as JOINT=HOLD for one of {", ".join(joints)}'
            )
        stated.update(dict.fromkeys([joint] if joint else joints, hold))
    return stated


def propose_gains(
    recorded: RecordedRobot,
    name: str,
    stated: Mapping[str, Mapping[str, float]],
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | None = None,
) -> GainProposal:
    """
    Measure noise, friction and motion in a recording and make gains from them.

    :param name: how to call the recording.
    :param stated: values by quantity (:data:`STATED`) and joint that replace measured ones.
    :param observers: which to propose gains for; all if None.
    :param effort_hold: by joint, where in an interval its effort holds; others as in the bag.
    :raises ConfigurationError: if an observer is unknown.
    :raises DataError: if something was neither stated nor can be measured.
    """
    check_observers(observers or ())
    robot = recorded.robot
    ran = recorded_configuration(recorded.bag, name)
    holds = effort_holds(robot.names, effort_hold or {}, ran)
    measured = measure_conditions(recorded.log, robot, holds)
    for quantity, values in stated.items():
        column = getattr(measured, quantity).copy()
        for joint, value in values.items():
            column[robot.names.index(joint)] = value
        measured = replace(measured, **{quantity: column})
    try:
        recipe = gains_for_conditions(measured.conditions(robot))
    except DataError as error:
        options = ', '.join(f'--{quantity.replace("_", "-")}' for quantity in STATED)
        raise DataError(f'{error}: state it as JOINT=VALUE with one of {options}') from error
    gains = {key: recipe[key] for key in (observers or OBSERVERS)}
    # A joint that hardly moved is tried at a speed at which its encoder sees it move.
    slowest = 50.0 * measured.position_noise / np.maximum(measured.reversal_time, 0.1)
    tried = replace(measured, top_speed=np.maximum(measured.top_speed, slowest))
    expected = expected_performance(gains, robot.inertia(measured.posture), tried)
    return GainProposal(name, measured, stated, robot.effort_units, gains, expected, holds)


def proposal_document(proposal: GainProposal) -> dict[str, Any]:
    """Return the object of ``sosml tune --json`` (``docs/schema/tune.schema.json``)."""
    c = proposal.conditions
    joints = {}
    for i, joint in enumerate(c.joints):
        observers = {
            name: {
                'gains': {gain: values[i] for gain, values in gains.items()},
                'noise': proposal.expected[name].noise[i],
                'settle_s': proposal.expected[name].settle_s[i],
                'on_line': OBSERVERS[name].causal,
            }
            for name, gains in proposal.gains.items()
        }
        joints[joint] = {
            'unit': proposal.effort_units[i],
            'conditions': {
                quantity: {
                    'value': getattr(c, quantity)[i],
                    'stated': joint in proposal.stated.get(quantity, {}),
                }
                for quantity in STATED
            },
            'top_speed': c.top_speed[i],
            'observers': observers,
        }
    return {
        'format': FORMAT,
        'bag': proposal.bag,
        'step_s': c.step,
        'velocity_span': c.velocity_span,
        'joints': joints,
    }


def check_parameter_file(path: Path) -> Path:
    """
    Return ``path`` if gains may be written there: it is absent or holds gains of an earlier run.

    :raises ConfigurationError: if it is something else, or its folder does not exist.
    """
    if not path.parent.is_dir():
        raise ConfigurationError(f'{path.parent} is no folder: choose another place with --out')
    try:
        if path.exists() and not path.read_text(encoding='utf-8').startswith(_MARK):
            raise ConfigurationError(
                f'{path} exists and was not written by sosml tune, so it is not overwritten: '
                'choose another place with --out'
            )
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(
            f'{path} cannot be read: choose another place with --out'
        ) from error
    return path


def write_parameters(path: Path, proposal: GainProposal) -> None:
    """
    Write the gains of those observers that can run in a node as a ROS 2 parameter file.

    :raises ConfigurationError: if that is not possible.
    """
    parameters: dict[str, Any] = {'effort_hold': list(proposal.effort_hold)}
    # Who asked for few wants those run; who asked for all wants gains to choose from.
    if len(proposal.gains) < len(OBSERVERS) and proposal.on_line:
        selected = 'sosml' if 'sosml' in proposal.on_line else proposal.on_line[0]
        parameters |= {'observers': list(proposal.on_line), 'selected': selected}
    parameters |= {
        name: {
            gain: [float(f'{value:.6g}') for value in values]
            for gain, values in proposal.gains[name].items()
        }
        for name in proposal.on_line
    }
    text: str = yaml.safe_dump(
        {'/**/observer_node': {'ros__parameters': parameters}},
        sort_keys=False,
        default_flow_style=None,
    )
    joints = ', '.join(proposal.conditions.joints)
    beside = path.with_name(f'.{path.name}.part')
    try:
        beside.write_text(f'{_MARK} {joints}; from {proposal.bag}\n{text}', encoding='utf-8')
        beside.replace(path)
    except OSError as error:
        raise ConfigurationError(
            f'{path} cannot be written: {error.strerror}: choose another place with --out'
        ) from error


def proposal_view(proposal: GainProposal) -> RenderableType:
    """Return what was measured, and the gains with what they are expected to do, as tables."""
    c = proposal.conditions
    measured = Table('joint', box=box.SIMPLE, pad_edge=False)
    for heading in ('position noise', 'velocity noise', 'friction jump', 'reversals every'):
        measured.add_column(heading, justify='right')
    for i, joint in enumerate(c.joints):
        effort = proposal.effort_units[i]
        length = 'rad' if effort == 'Nm' else 'm'
        units = (length, f'{length}/s', effort, 's')
        cells = [
            f'{getattr(c, quantity)[i]:.3g} {unit}'
            + (' (stated)' if joint in proposal.stated.get(quantity, {}) else '')
            for quantity, unit in zip(STATED, units, strict=True)
        ]
        measured.add_row(joint, *cells)
    proposed = Table('joint', 'observer', box=box.SIMPLE, pad_edge=False)
    proposed.add_column('noise', justify='right')
    proposed.add_column('settles in', justify='right')
    proposed.add_column('gains', overflow='fold')
    for i, joint in enumerate(c.joints):
        for k, (name, gains) in enumerate(proposal.gains.items()):
            expected = proposal.expected[name]
            noise, settle = expected.noise[i], expected.settle_s[i]
            proposed.add_row(
                joint if k == 0 else '',
                OBSERVERS[name].label,
                # What is left of rounding is no noise.
                f'{noise if noise > 1e-12 else 0.0:.3g} {proposal.effort_units[i]}',
                f'{1e3 * settle:.0f} ms' if np.isfinite(settle) else 'never',
                ', '.join(f'{gain} {values[i]:.4g}' for gain, values in gains.items()),
                end_section=k == len(proposal.gains) - 1,
            )
    return Group(measured, Text(_velocity_text(c)), proposed, Text(_REMARK))


_REMARK = (
    'Noise and settling (to 10 % of the jump after a reversal) are simulated with these '
    'conditions, the friction a Coulomb law: where friction follows no law, the observer that is '
    'told one settles more slowly. The smoother needs the whole recording.'
)


def _velocity_text(c: LogConditions) -> str:
    if c.velocity_span == 0:
        return 'The velocity is not a slope of these positions: its noise was taken for white.'
    lag = 0.5e3 * (c.velocity_span - 1) * c.step
    return (
        f'The velocity is the slope of {c.velocity_span} positions {1e3 * c.step:.3g} ms apart: '
        f'it lags by {lag:.3g} ms.'
    )
