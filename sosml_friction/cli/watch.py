# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml watch``."""

import sys
from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_result, remark
from sosml_friction.cli.options import JsonOption, option
from sosml_friction.exceptions import ConfigurationError


@app.command()
def watch(
    namespace: Annotated[str, option('NS', 'Namespace of the robot.')] = '',
    seconds: Annotated[float | None, option('S', 'For how long; default: until Ctrl-C.')] = None,
    json: JsonOption = False,
) -> None:
    """
    Show friction, its error, validity and the phase of the nodes while they run.

    Listens to joint_states, friction_estimate, friction_estimate_error and /diagnostics, and
    commands nothing. Where the output is no terminal, one table is printed at the end.

    Exit code 1 if no node was heard.

    Example: sosml watch --seconds 10
    """
    if seconds is not None and not 0.1 <= seconds <= 1e6:
        raise ConfigurationError(f'--seconds {seconds:g} is no time: give 0.1 to 1e6')
    from importlib.util import find_spec

    if find_spec('rclpy') is None:
        raise ConfigurationError(
            'watching needs rclpy: make install brings it, or source /opt/ros/jazzy/setup.bash'
        )
    from sosml_friction.nodes.watch import run_watch

    heard = run_watch(namespace, seconds, live=False if json else None)
    # A terminal had the table while it was live.
    print_result(json, heard.document(), [] if sys.stdout.isatty() else [heard.table()])
    if not heard.anything:
        remark('no node was heard: is the same ROS_DOMAIN_ID set, and does one run?')
        raise typer.Exit(1)
