# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml plan``."""

from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_result
from sosml_friction.cli.options import JsonOption, option, stated


@app.command()
def plan(
    std_error: Annotated[
        list[str] | None,
        option(
            'NAME=NUMBER',
            'Wanted standard error of coulomb, viscous, stribeck, stribeck_velocity or bias; '
            'repeatable.',
        ),
    ] = None,
    budget: Annotated[float, option('S', 'Longest duration of the ladder.')] = 120.0,
    noise: Annotated[
        float | None, option('NM', 'Standard deviation of a sample of friction; default: 0.05.')
    ] = None,
    correlation: Annotated[
        float | None, option('S', 'Correlation time of that noise; default: 0.005.')
    ] = None,
    assume: Annotated[
        list[str] | None,
        option(
            'NAME=NUMBER',
            'Friction that is expected; default: coulomb=0.8, viscous=0.35, stribeck=0.5, '
            'stribeck_velocity=0.03, bias=0; repeatable.',
        ),
    ] = None,
    plateau: Annotated[float | None, option('S', 'Length of a plateau; default: 1.')] = None,
    ramp: Annotated[float | None, option('S', 'Length of a ramp; default: 0.3.')] = None,
    slowest: Annotated[float | None, option('RAD_S', 'Slowest plateau; default: 0.01.')] = None,
    fastest: Annotated[float | None, option('RAD_S', 'Fastest plateau; default: 0.7.')] = None,
    json: JsonOption = False,
) -> None:
    """
    Choose the plateau speeds of a speed ladder for wanted standard errors.

    Takes the Cramer-Rao bound of the Stribeck law from the noise of a plateau's mean, and prints
    the shortest ladder that reaches the wanted errors, or the best within the time, and what that
    is. For a prismatic joint read N, m/s and so on.

    Exit code 1 if a wanted error cannot be reached within the time.

    Example: sosml plan --std-error coulomb=0.005 --std-error stribeck=0.01 --budget 60
    """
    from sosml_friction.identification.experiment_plan import PlanSettings, plan_experiment
    from sosml_friction.report.plan import plan_view as view

    given = stated(
        noise=noise, correlation_s=correlation, plateau_s=plateau, ramp_s=ramp, slowest=slowest,
        fastest=fastest,
    )  # fmt: skip
    settings = PlanSettings(**given)
    wanted = view.parse_parameters('--std-error', std_error or [])
    assumed = {**view.ASSUMED, **view.parse_parameters('--assume', assume or [])}
    found = plan_experiment(wanted, budget, assumed, settings)
    blocks = [view.plan_table(found, budget), view.plan_command(found, settings)]
    print_result(json, view.plan_document(found, budget, assumed, settings), blocks)
    if found.missed:
        raise typer.Exit(1)
