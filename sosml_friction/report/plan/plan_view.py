# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml plan`` says of a ladder."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.experiment_plan import ExperimentPlan, PlanSettings
from sosml_friction.report.common.labels import SYMBOLS
from sosml_friction.report.common.table import terminal_table

FORMAT = 'sosml_friction/plan/1'

#: Friction of a geared joint of some 5 Nm, that of the emulated shoulder: without a better guess.
ASSUMED = {
    'coulomb': 0.8,
    'viscous': 0.35,
    'stribeck': 0.5,
    'stribeck_velocity': 0.03,
    'bias': 0.0,
}


def parse_parameters(option: str, entries: Sequence[str]) -> dict[str, float]:
    """
    Read entries ``NAME=NUMBER`` with names of friction parameters.

    :raises ConfigurationError: if one is something else.
    """
    found = {}
    for entry in entries:
        name, _, text = entry.partition('=')
        try:
            number = float(text)
        except ValueError:
            number = None
        if number is None or name not in SYMBOLS:
            raise ConfigurationError(
                f'{option} {entry} cannot be read: write NAME=NUMBER with {", ".join(SYMBOLS)}'
            )
        found[name] = number
    return found


def plan_document(
    plan: ExperimentPlan, budget_s: float, assumed: Mapping[str, float], settings: PlanSettings
) -> dict[str, Any]:
    """Return the object of ``sosml plan --json``."""
    return {
        'format': FORMAT,
        'speeds': list(plan.speeds),
        'plateau_s': settings.plateau_s,
        'ramp_s': settings.ramp_s,
        'duration_s': plan.duration_s,
        'budget_s': budget_s,
        'noise': settings.noise,
        'correlation_s': settings.correlation_s,
        'level_std': plan.level_std,
        'assumed': dict(assumed),
        'std_errors': dict(plan.std_errors),
        'wanted': dict(plan.wanted),
        'reached': not plan.missed,
        'missed': plan.missed,
        'needed_s': plan.needed_s,
    }


def plan_table(plan: ExperimentPlan, budget_s: float) -> RenderableType:
    """Return the speeds, the standard errors they give beside the wanted ones, and a verdict."""
    columns = {'parameter': 'w', 'best standard error': 'n', 'wanted': 'n', '': 'w'}
    rows = []
    for name, error in plan.std_errors.items():
        wanted = plan.wanted.get(name)
        verdict = '' if wanted is None else 'missed' if name in plan.missed else 'reached'
        rows.append((name, f'{error:.2g}', '' if wanted is None else f'{wanted:.4g}', verdict))
    times = ', '.join(
        f'{speed:.4g}' + (f' ({count} times)' if count > 1 else '')
        for speed, count in Counter(plan.speeds).items()
    )
    head = (
        f'Plateau speeds: {times}\n'
        f'A speed ladder of {plan.duration_s:.0f} s; the mean friction of a plateau is known to '
        f'{plan.level_std:.2g}.'
    )
    missed = ''
    if plan.missed:
        hours = plan.needed_s / 3600.0
        needed = f'{plan.needed_s:.0f} s' if hours <= 1.0 else f'about {hours:.2g} hours'
        best = ', '.join(
            f'{plan.std_errors[name]:.2g} for {name} (wanted {plan.wanted[name]:.4g})'
            for name in plan.missed
        )
        missed = (
            f'Not all can be reached within {budget_s:g} s: the best is {best}. All that is '
            f'wanted takes {needed}.\n'
        )
    caveat = 'Bounds for the assumed friction, which no estimate is below; a fit may be worse.'
    return Group(Text(head), terminal_table(columns, rows), Text(missed + caveat))


def plan_command(plan: ExperimentPlan, settings: PlanSettings) -> str:
    """Return the command that shows the ladder."""
    speeds = ','.join(f'{speed:.4g}' for speed in plan.speeds)
    return (
        f'sosml trajectory speed_ladder --set plateau={settings.plateau_s:g} '
        f'--set ramp={settings.ramp_s:g} --set speeds={speeds}'
    )
