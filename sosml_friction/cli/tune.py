# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml tune``."""

from pathlib import Path
from typing import Annotated

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, print_result, progress
from sosml_friction.cli.tables import takes_tables


@app.command()
@takes_tables
def tune(
    bag: Path,
    observers: Annotated[
        str | None,
        options.option(
            'NAME,...',
            f'Observers to propose gains for; default: all of {options.OBSERVER_NAMES}.',
        ),
    ] = None,
    position_noise: Annotated[
        list[str] | None,
        options.option(
            '[JOINT=]VALUE',
            'Noise of a position [rad or m], with resolution / sqrt(12); default: measured.',
        ),
    ] = None,
    velocity_noise: Annotated[
        list[str] | None,
        options.option('[JOINT=]VALUE', 'Noise of a velocity [rad/s or m/s]; default: measured.'),
    ] = None,
    friction_jump: Annotated[
        list[str] | None,
        options.option(
            '[JOINT=]VALUE',
            'How much friction changes at a reversal, twice its level [Nm or N]; default: '
            'measured.',
        ),
    ] = None,
    reversal_time: Annotated[
        list[str] | None,
        options.option('[JOINT=]VALUE', 'Time between reversals [s]; default: measured.'),
    ] = None,
    effort_hold: options.EffortHoldOption = None,
    model: options.ModelOption = None,
    armature: options.ArmatureOption = None,
    urdf: options.UrdfOption = None,
    mjcf: options.MjcfOption = None,
    namespace: options.NamespaceOption = None,
    out: Annotated[
        Path | None, options.option('FILE.yaml', 'Parameter file to write, for observer_node.')
    ] = None,
    json: options.JsonOption = False,
) -> None:
    """
    Propose gains for the observers from the noise, the friction and the motion in a bag.

    Measures the noise of positions and velocities, by how much friction jumps at a reversal and
    how often the joint turns round; each of the four can be stated instead. Prints the gains that
    follow, with the noise and the settling time they are expected to have, and writes them as a
    parameter file that observer_node takes with --params-file.

    Example: sosml tune recording --friction-jump shoulder=2.0 --out gains.yaml
    """
    from sosml_friction.bags.recorded_robot import read_recorded_robot
    from sosml_friction.bags.source import bag_name
    from sosml_friction.report.plan import gain_view as view
    from sosml_friction.study import gain_proposal as gains

    if out is not None:
        view.check_parameter_file(out)
    given = zip(
        gains.STATED, (position_noise, velocity_noise, friction_jump, reversal_time), strict=True
    )
    with progress(f'reading {bag}') as step:
        source = options.stated_model(bag, model, armature, urdf, namespace, mjcf)
        recorded = read_recorded_robot(bag, source, urdf, namespace)
        joints = recorded.robot.names
        known = {name: gains.parse_stated(name, values or [], joints) for name, values in given}
        step('measuring noise, trying gains')
        holds = gains.parse_effort_hold(effort_hold or [], joints)
        chosen = as_names(observers)
        proposal = gains.propose_gains(recorded, bag_name(bag), known, chosen, holds)
    if out is not None:
        view.write_parameters(out, proposal)
    blocks = [view.proposal_view(proposal)]
    if out is not None:
        runs = 'these observers' if observers else 'first_order and sosml'
        blocks.append(
            f'Gains are in {out}: observer_node --ros-args --params-file {out} runs {runs}; '
            '-p observers:=[...] -p selected:=... choose others.'
        )
    output = None if out is None else str(out)
    print_result(json, view.proposal_document(proposal), blocks, output=output)
