# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml tune`` prints and writes of proposed gains."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from rich.console import Group, RenderableType
from rich.text import Text

from sosml_friction.observers.log_conditions import LogConditions
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.common.output import check_file, write_file
from sosml_friction.report.common.table import terminal_table
from sosml_friction.study.gain_proposal import STATED, GainProposal

FORMAT = 'sosml_friction/tune/1'
#: First words of a parameter file, by which an earlier one is known.
_MARK = '# Gains by sosml tune for observer_node:'
_REMARK = (
    'Noise and settling (to 10 % of the jump after a reversal) are simulated with these '
    'conditions, the friction a Coulomb law: where friction follows no law, the observer that is '
    'told one settles more slowly. The smoother needs the whole recording.'
)


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
    Return ``path`` if gains may be written there: it is absent or holds earlier gains.

    :raises ConfigurationError: if it is something else, or its folder does not exist.
    """
    return check_file(path, '--out', path.suffix.lower(), _MARK.encode())


def write_parameters(path: Path, proposal: GainProposal) -> None:
    """Write the gains of those observers that can run in a node as a ROS 2 parameter file."""
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
    write_file(path, f'{_MARK} {joints}; from {proposal.bag}\n{text}'.encode())


def proposal_view(proposal: GainProposal) -> RenderableType:
    """Return what was measured, and the gains with what they are expected to do, as tables."""
    c = proposal.conditions
    measured, proposed = [], []
    for i, joint in enumerate(c.joints):
        effort = proposal.effort_units[i]
        cells = [
            f'{getattr(c, quantity)[i]:.3g} {unit}'
            + (' (stated)' if joint in proposal.stated.get(quantity, {}) else '')
            for quantity, unit in zip(STATED, (*motion_units(effort), effort, 's'), strict=True)
        ]
        measured.append([joint, *cells])
        for k, (name, gains) in enumerate(proposal.gains.items()):
            noise, settle = proposal.expected[name].noise[i], proposal.expected[name].settle_s[i]
            proposed.append([
                '' if k else joint,
                OBSERVERS[name].label,
                # What is left of rounding is no noise.
                f'{noise if noise > 1e-12 else 0.0:.3g} {effort}',
                f'{1e3 * settle:.0f} ms' if np.isfinite(settle) else 'never',
                ', '.join(f'{gain} {values[i]:.4g}' for gain, values in gains.items()),
            ])  # fmt: skip
    conditions = {'joint': 'w', 'position noise': 'n', 'velocity noise': 'n', 'friction jump': 'n',
                  'reversals every': 'n'}  # fmt: skip
    columns = {'joint': 'w', 'observer': 'w', 'noise': 'n', 'settles in': 'n', 'gains': ''}
    return Group(
        terminal_table(conditions, measured),
        Text(_velocity_text(c)),
        terminal_table(columns, proposed, sections=True),
        Text(_REMARK),
    )


def _velocity_text(c: LogConditions) -> str:
    if c.velocity_span == 0:
        return 'The velocity is not a slope of these positions: its noise was taken for white.'
    lag = 0.5e3 * (c.velocity_span - 1) * c.step
    return (
        f'The velocity is the slope of {c.velocity_span} positions {1e3 * c.step:.3g} ms apart: '
        f'it lags by {lag:.3g} ms.'
    )
