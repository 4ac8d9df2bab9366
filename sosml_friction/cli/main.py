# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The tool ``sosml``: what is done off line.

Exit codes: 0 done; 1 ran, but the answer is "no"; 2 bad input or wrong usage, one sentence on
stderr; 130 after Ctrl-C. With ``--json`` stdout carries exactly one JSON object; progress and
remarks always go to stderr.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from sosml_friction.cli.can import app as can_app
from sosml_friction.cli.diagnose import diagnose
from sosml_friction.cli.options import (
    BagArgument,
    BagsArgument,
    EffortHoldOption,
    JsonOption,
    ModelOption,
    NamespaceOption,
    UrdfOption,
    folder_option,
    joint_values_option,
    names_option,
    out_option,
)
from sosml_friction.cli.simulate import simulate
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError
from sosml_friction.share import share_directory

# Modules that load NumPy, Pinocchio or Matplotlib are imported in the command that needs them, so
# that --help and a misspelt option answer at once.

_INTERRUPTED = 130
_MOST_PROCESSES = 1024
#: What the tool was called with, for the provenance of what it writes.
_arguments: list[str] = []
_IMPORT_FORMAT = 'sosml_friction/import/1'

app = typer.Typer(
    name='sosml',
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help='Friction of robot joints without a torque sensor: plan a trajectory, fit friction to a '
    'recording, import data, look into a bag, or see a demonstration.',
)

app.add_typer(can_app)

_OBSERVER_NAMES = (
    'quasi_static, first_order, first_order_prefiltered, linear_second_order, sosml, '
    'sosml_explicit, kalman, kalman_adaptive, kalman_scheduled, kalman_imm, kalman_stribeck, '
    'smoother'
)


@app.callback(invoke_without_command=True)
def _sosml(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(2)


@app.command()
def fit(
    bags: BagsArgument,
    model: ModelOption = None,
    urdf: UrdfOption = None,
    method: Annotated[
        str,
        typer.Option(
            metavar='auto|segments|samples|weak|output_error',
            help='auto: a regression on position and effort without an observer (weak form), '
            'which becomes the model, and beside it the estimate of each observer, by segments '
            '(levels of steady windows) where plateaus reach down to a fifth of the top speed, '
            'else by samples (all in motion); weak: the same. segments, samples: the observers '
            'alone. output_error adds a simulation fitted to the motion, under the recorded '
            'controller or by the measured effort.',
        ),
    ] = 'auto',
    law: Annotated[
        str,
        typer.Option(
            metavar='auto|coulomb_viscous|stribeck',
            help='Law to fit; auto adds the Stribeck term where the data show it.',
        ),
    ] = 'auto',
    symmetric: Annotated[
        bool,
        typer.Option(
            '--symmetric/--asymmetric', help='Whether friction is the same in both directions.'
        ),
    ] = True,
    alpha: Annotated[
        float,
        typer.Option(metavar='1|2', help='Exponent of the speed in the Stribeck term.'),
    ] = 1.0,
    zero_band: Annotated[
        float | None,
        typer.Option(metavar='SPEED', help='Slower is standstill [rad/s or m/s]; default: 0.001.'),
    ] = None,
    window: Annotated[
        float | None,
        typer.Option(metavar='S', help='Over what steadiness of speed is judged; default: 0.05.'),
    ] = None,
    trim: Annotated[
        float | None,
        typer.Option(
            metavar='S',
            help='Least that is cut off the beginning of a steady window; default: 0.15.',
        ),
    ] = None,
    role: Annotated[
        list[str] | None,
        typer.Option(
            metavar='BAG=ROLE',
            help="Which of the paper's trajectories a bag is: T1 (speed ladder), T2 (symmetric "
            'reversals), T3 (slow ladder) or other; repeatable. Default: as recorded, else by '
            'its motion.',
        ),
    ] = None,
    own_bias: Annotated[
        bool | None,
        typer.Option(
            '--own-bias/--common-bias',
            help='Whether each bag has a bias of its own in the joint fit; default: where the '
            'bags differ in it.',
        ),
    ] = None,
    refit_inertia: Annotated[
        bool,
        typer.Option(
            '--refit-inertia',
            help='Fit inertia too, by the inverse model and by the weak form. It is reported; the '
            'model keeps its own. Where the bag holds its controller, the closed loop is '
            'simulated with what was found.',
        ),
    ] = False,
    bandwidth: Annotated[
        float | None,
        typer.Option(
            metavar='RAD_S', help="Bandwidth of the observers; default: the bag's own gains."
        ),
    ] = None,
    observers: Annotated[
        str | None,
        names_option(
            'Observers to run, with gains as sosml tune proposes them; SOSML, else the first '
            f'one, makes the model. Default: those of the bag. Known: {_OBSERVER_NAMES}.'
        ),
    ] = None,
    effort_hold: EffortHoldOption = None,
    namespace: NamespaceOption = None,
    out: Annotated[Path | None, out_option('<name of the first bag>_fit')] = None,
    truth: Annotated[
        Path | None,
        folder_option('Model folder whose friction is known to be the truth.'),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Fit the friction of every joint of one or several recordings.

    Fits the law of friction to position and effort (weak form) and to what the observers say,
    prints the parameters with their standard errors, and writes a model folder (robot.urdf,
    model.yaml) with report.html, fit.json and segments.csv. An earlier fit in the same place is
    replaced, anything else is not touched.

    Several bags of the same robot are fitted each alone, then together: by the paper's rule (C and
    B from T1 and T3, S and v_s from T2, the bias from T3) and by one fit to all of them, and it is
    said which to prefer and in what the bags disagree.

    Exit code 1 if a joint that reports effort could not be fitted.

    Example: sosml fit t1 t2 t3 --role t2=T2 --out shoulder_fit
    """
    from sosml_friction.bags.source import bag_name
    from sosml_friction.identification.bag_analysis import analyse_bag
    from sosml_friction.identification.friction_fit import FitSettings
    from sosml_friction.identification.law.law_form import LawForm
    from sosml_friction.identification.segments import SegmentSettings
    from sosml_friction.identification.several.bags_analysis import analyse_bags
    from sosml_friction.model.model_folder import read_model
    from sosml_friction.observers.configuration import OBSERVERS
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import parameter_table, print_table
    from sosml_friction.report.fit.consolidation_view import bags_answers, bags_table
    from sosml_friction.report.fit.findings import answers, caveats
    from sosml_friction.report.fit.inverse_view import inverse_table
    from sosml_friction.report.fit.joint_view import joint_views
    from sosml_friction.report.fit.results import (
        bags_document,
        check_destination,
        fit_document,
        write_bags_results,
        write_results,
    )
    from sosml_friction.report.simulation.text import simulation_lines
    from sosml_friction.study.gain_proposal import parse_effort_hold

    several = len(bags) > 1
    if not several and (role or own_bias is not None):
        raise ConfigurationError(
            f'{"--role" if role else "--own-bias"} says how several bags are put together, and '
            'one is given: give the others too, or leave it out'
        )
    given = {'zero_band': zero_band, 'window_s': window, 'trim_s': trim}
    settings = FitSettings(
        method=method,
        segments=SegmentSettings(**{k: v for k, v in given.items() if v is not None}),
        refit_inertia=refit_inertia,
        form=LawForm(law, symmetric, alpha),
    )
    folder = check_destination(out or Path(f'{bag_name(bags[0])}_fit'))
    known = None if truth is None else read_model(truth)
    with progress(f'reading and fitting {bags[0]}') as step:
        names = _joint_names(bags[0], namespace) if effort_hold else ()
        holds = parse_effort_hold(effort_hold or [], names)
        chosen = _names(observers)
        if several:
            together = analyse_bags(
                bags, model, urdf, settings, bandwidth, namespace, chosen, holds, role or (),
                own_bias, _command_line(), step,
            )  # fmt: skip
            analyses = list(together.bags.values())
            document = bags_document(together, known)
            step('drawing the report')
            write_bags_results(folder, together, known, None, lambda what: step(f'drawing {what}'))
            table, found, open_ends = bags_table(together, known), bags_answers(together), []
            failed = list(together.consolidation.unavailable)
            failed += [
                name
                for name, joint in together.model.joints.items()
                if joint.friction is None and name in together.consolidation.joints
            ]
        else:
            analysis = analyse_bag(
                bags[0], model, urdf, settings, bandwidth, namespace, chosen, holds, step,
                command=_command_line(),
            )  # fmt: skip
            analyses = [analysis]
            document = fit_document(analysis, known)
            step('drawing the report')
            write_results(folder, analysis, known, None, lambda joint: step(f'drawing {joint}'))
            table, views = parameter_table(analysis, known), joint_views(analysis, known)
            found, open_ends = answers(views), caveats(views)
            failed = [j for j in analysis.fit.unavailable if j not in analysis.fit.joints]
            failed += list(analysis.unmodelled)
    if json:
        typer.echo(to_json({**document, 'output': str(folder)}))
    else:
        for sentence in found:
            typer.echo(sentence)
        print_table(table)
        for sentence in open_ends:
            typer.echo(sentence)
        for bag, one in zip(bags, analyses, strict=True):
            if one.inverse is not None:
                if several:
                    typer.echo(f'{bag}:')
                print_table(inverse_table(one, one.inverse))
            for line in simulation_lines(one):
                typer.echo(line)
        typer.echo(f'Model, report.html, fit.json and segments.csv are in {folder}')
    if not json and not effort_hold:
        silent = [str(bag) for bag in bags if not _says_effort_hold(bag, namespace)]
        if silent:
            who = 'The bag does' if not several else f'Of the bags, {", ".join(silent)} do'
            typer.echo(
                f'{who} not say where in an interval effort holds, so it was taken for a\n'
                'command (start). A measured current holds until its sample (--effort-hold end), '
                'and\na period of delay reads as viscous friction.'
            )
    for bag, one in zip(bags, analyses, strict=True):
        _remark_on(bag, one, several)
    carrying = dict.fromkeys(
        name for one in analyses for name in one.configuration.gains if OBSERVERS[name].carries_law
    )
    if carrying:
        _remark(
            f'{", ".join(carrying)} has a friction law inside: a law fitted to its estimate is '
            'that one again, and no evidence'
        )
    refused = any(one.data_checks is not None and one.data_checks.refused for one in analyses)
    if refused or any(_has_effort(one, joint) for one in analyses for joint in failed):
        raise typer.Exit(1)


@app.command('import')
def import_(
    file: Annotated[
        Path, typer.Argument(metavar='FILE', help='Recording: .mat, .csv, .npz or .npy.')
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(
            '--map',
            metavar='MAPPING.yaml',
            help='Which variable is what, in which unit; default: the shipped mapping that is '
            'named in the file name.',
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar='BAG', help='Bag to make; default: the name of the file, in this folder.'
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Turn a recording of another format into a bag.

    An existing bag is not overwritten. The URDF and model that the mapping names go into the bag,
    so that sosml fit needs nothing else.

    Example: sosml import DATA_EMPS.mat --map config/import/emps.yaml --out emps
    """
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.importer import import_recording
    from sosml_friction.report.common.bag_information import bag_information
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress

    if mapping is None:
        mapping = _shipped_mapping(file)
        _remark(f'using the shipped mapping {mapping}')
    with progress(f'importing {file}') as step:
        path = import_recording(file, mapping, out if out is not None else Path(file.stem))
        step('reading the bag back')
        information = bag_information(Bag.open(path))
    motion = information['joint_states']
    if json:
        document = {
            'format': _IMPORT_FORMAT,
            'file': str(file),
            'mapping': str(mapping),
            'bag': str(path),
            'duration_s': information['duration_s'],
            'joint_states': motion,
            'descriptions': information['descriptions'],
        }
        typer.echo(to_json(document))
        return
    typer.echo(
        f'{path}: {motion["samples"]} samples over {information["duration_s"]:.2f} s of '
        + '; '.join(f'{joint} ({", ".join(what)})' for joint, what in motion['measured'].items())
    )


@app.command()
def info(
    bag: BagArgument,
    namespace: NamespaceOption = None,
    json: JsonOption = False,
) -> None:
    """
    Say what a bag holds and whether its motion is complete.

    Topics and messages, joints and what was measured of them, gaps, repeated and backward stamps,
    and how much of a cut-off recording could be read.

    Example: sosml info recording --json
    """
    from sosml_friction.bags.bag import Bag
    from sosml_friction.report.common.bag_information import bag_information
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import information_table, print_table

    with progress(f'reading {bag}'):
        information = bag_information(Bag.open(bag, namespace))
    if json:
        typer.echo(to_json(information))
        return
    for line in _information_lines(information):
        typer.echo(line)
    print_table(information_table(information))


@app.command()
def tune(
    bag: BagArgument,
    observers: Annotated[
        str | None,
        names_option(f'Observers to propose gains for; default: all of {_OBSERVER_NAMES}.'),
    ] = None,
    position_noise: Annotated[
        list[str] | None,
        joint_values_option(
            'Noise of a position [rad or m], with resolution / sqrt(12); default: measured.'
        ),
    ] = None,
    velocity_noise: Annotated[
        list[str] | None,
        joint_values_option('Noise of a velocity [rad/s or m/s]; default: measured.'),
    ] = None,
    friction_jump: Annotated[
        list[str] | None,
        joint_values_option(
            'How much friction changes at a reversal, twice its level [Nm or N]; default: '
            'measured.'
        ),
    ] = None,
    reversal_time: Annotated[
        list[str] | None,
        joint_values_option('Time between reversals [s]; default: measured.'),
    ] = None,
    effort_hold: EffortHoldOption = None,
    model: ModelOption = None,
    urdf: UrdfOption = None,
    namespace: NamespaceOption = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar='FILE.yaml', help='Parameter file to write, for observer_node.'),
    ] = None,
    json: JsonOption = False,
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
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.study.gain_proposal import (
        check_parameter_file,
        parse_effort_hold,
        parse_stated,
        proposal_document,
        proposal_view,
        propose_gains,
        write_parameters,
    )

    if out is not None:
        check_parameter_file(out)
    given = {
        'position_noise': position_noise,
        'velocity_noise': velocity_noise,
        'friction_jump': friction_jump,
        'reversal_time': reversal_time,
    }
    with progress(f'reading {bag}') as step:
        recorded = read_recorded_robot(bag, model, urdf, namespace)
        stated = {
            name: parse_stated(name, values or [], recorded.robot.names)
            for name, values in given.items()
        }
        step('measuring noise, trying gains')
        holds = parse_effort_hold(effort_hold or [], recorded.robot.names)
        proposal = propose_gains(recorded, bag_name(bag), stated, _names(observers), holds)
    if out is not None:
        write_parameters(out, proposal)
    if json:
        document = proposal_document(proposal)
        typer.echo(to_json({**document, 'output': None if out is None else str(out)}))
        return
    print_table(proposal_view(proposal))
    if out is not None:
        runs = 'these observers' if observers else 'first_order and sosml'
        typer.echo(
            f'Gains are in {out}: observer_node --ros-args --params-file {out} runs {runs}; '
            '-p observers:=[...] -p selected:=... choose others.'
        )


@app.command()
def trajectory(
    name: Annotated[
        str,
        typer.Argument(
            metavar='NAME',
            help='speed_ladder (or T1), symmetric_reversals (T2), slow_ladder (T3), slow_s_shape, '
            'reversal, multisine or rich.',
        ),
    ],
    model: Annotated[Path | None, folder_option('Model folder; default: the exoskeleton.')] = None,
    urdf: Annotated[
        Path | None, typer.Option(metavar='FILE', help="URDF file; default: the model's.")
    ] = None,
    stated: Annotated[
        list[str] | None,
        typer.Option(
            '--set',
            metavar='KEY=VALUE',
            help='An option of the trajectory, a list with commas; repeatable. All have centre, '
            'start, scale, effort_margin and acceleration_limit; docs/parameters.md has the rest.',
        ),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar='FILE.png', help='Picture to draw.')] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar='FILE.csv', help='Samples every 10 ms, if it is within all limits.'),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Show an identification trajectory and whether a robot can do it.

    Prints how long it lasts and what it asks of each joint, beside the limits of the URDF: the
    effort is that of the rigid body, with an allowance for friction. Options that are not set are
    those of identifier_node in the parameter file beside the model folder (DIR.yaml), or defaults.

    Exit code 1 if it is beyond a limit.

    Example: sosml trajectory multisine --set amplitude=0.2 --plot multisine.png
    """
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.plan.planned_trajectory import (
        check_file,
        plan_trajectory,
        trajectory_csv,
        trajectory_document,
        trajectory_table,
        write_file,
    )

    if plot is not None:
        check_file(plot, '--plot', '.png', b'\x89PNG')
    if out is not None:
        check_file(out, '--out', '.csv', b'time [s],')
    planned = plan_trajectory(name, model, urdf, stated or [])
    if plot is not None:
        from sosml_friction.report.common.drawing import to_png
        from sosml_friction.report.plan.trajectory_figure import trajectory_figure

        write_file(plot, to_png(trajectory_figure(planned)))
    written = out if out is not None and not planned.beyond else None
    if written is not None:
        write_file(written, trajectory_csv(planned).encode())
    if json:
        paths = {
            key: None if p is None else str(p) for key, p in (('plot', plot), ('output', written))
        }
        typer.echo(to_json({**trajectory_document(planned), **paths}))
    else:
        print_table(trajectory_table(planned))
    if planned.beyond:
        if out is not None:
            _remark(f'{out} is not written: the trajectory is beyond a limit')
        raise typer.Exit(1)


@app.command()
def plan(
    std_error: Annotated[
        list[str] | None,
        typer.Option(
            metavar='NAME=NUMBER',
            help='Wanted standard error of coulomb, viscous, stribeck, stribeck_velocity or bias; '
            'repeatable.',
        ),
    ] = None,
    budget: Annotated[
        float, typer.Option(metavar='S', help='Longest duration of the ladder.')
    ] = 120.0,
    noise: Annotated[
        float | None,
        typer.Option(
            metavar='NM', help='Standard deviation of a sample of friction; default: 0.05.'
        ),
    ] = None,
    correlation: Annotated[
        float | None,
        typer.Option(metavar='S', help='Correlation time of that noise; default: 0.005.'),
    ] = None,
    assume: Annotated[
        list[str] | None,
        typer.Option(
            metavar='NAME=NUMBER',
            help='Friction that is expected; default: coulomb=0.8, viscous=0.35, stribeck=0.5, '
            'stribeck_velocity=0.03, bias=0; repeatable.',
        ),
    ] = None,
    plateau: Annotated[
        float | None, typer.Option(metavar='S', help='Length of a plateau; default: 1.')
    ] = None,
    ramp: Annotated[
        float | None, typer.Option(metavar='S', help='Length of a ramp; default: 0.3.')
    ] = None,
    slowest: Annotated[
        float | None, typer.Option(metavar='RAD_S', help='Slowest plateau; default: 0.01.')
    ] = None,
    fastest: Annotated[
        float | None, typer.Option(metavar='RAD_S', help='Fastest plateau; default: 0.7.')
    ] = None,
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
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.plan.plan_view import (
        ASSUMED,
        parse_parameters,
        plan_command,
        plan_document,
        plan_table,
    )

    given: dict[str, Any] = {
        'noise': noise,
        'correlation_s': correlation,
        'plateau_s': plateau,
        'ramp_s': ramp,
        'slowest': slowest,
        'fastest': fastest,
    }
    settings = PlanSettings(**{key: value for key, value in given.items() if value is not None})
    wanted = parse_parameters('--std-error', std_error or [])
    assumed = {**ASSUMED, **parse_parameters('--assume', assume or [])}
    found = plan_experiment(wanted, budget, assumed, settings)
    if json:
        typer.echo(to_json(plan_document(found, budget, assumed, settings)))
    else:
        print_table(plan_table(found, budget))
        typer.echo(plan_command(found, settings))
    if found.missed:
        raise typer.Exit(1)


@app.command()
def study(
    out: Annotated[Path, folder_option('Where to write the report.')] = Path('study_output'),
    seeds: Annotated[
        int | None,
        typer.Option(metavar='N', help='Noise seeds that are scored, 1 to 100; default: 5.'),
    ] = None,
    tuning_seeds: Annotated[
        int | None,
        typer.Option(metavar='N', help='Other noise seeds, to tune on, 1 to 100; default: 2.'),
    ] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            metavar='N', help='Gain sets tried in each tuning, 4 to 100000; default: 300.'
        ),
    ] = None,
    observers: Annotated[
        str | None,
        names_option('Observers of the study; default: all.'),
    ] = None,
    motions: Annotated[str | None, names_option('slow, reversal; default: both.')] = None,
    conditions: Annotated[
        str | None,
        names_option('nominal, noise, mismatch; default: all.'),
    ] = None,
    bits: Annotated[
        int, typer.Option(metavar='N', help='Resolution of the encoders per turn, 8 to 24.')
    ] = 16,
    processes: Annotated[
        int | None,
        typer.Option(metavar='N', help='Processes to share the work; default: one per core.'),
    ] = None,
    quick: Annotated[
        bool,
        typer.Option(
            '--quick',
            help='A first look: 24 evaluations, 2 scoring seeds, 1 tuning seed, plant steps of '
            '200 us instead of 50 us, where nothing else is said.',
        ),
    ] = False,
    json: JsonOption = False,
) -> None:
    """
    Compare the observers in simulation, as the paper does, with all tuned equally well.

    Slow S-shape and reversal; exact signals, encoder noise, wrong model. Every observer is tuned
    with the same number of evaluations, on other noise than it is scored on: once for each motion
    and condition, and once for both noisy motions together. Writes study.html, study.json and the
    figures. An earlier study in the same place is replaced, anything else is not touched.

    Takes some minutes on two cores; the result does not depend on how many there are.

    Example: sosml study --quick --observers first_order,sosml,kalman --out study_output
    """
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.study.document import study_document
    from sosml_friction.report.study.results import check_study_destination, write_study
    from sosml_friction.report.study.tables import study_tables
    from sosml_friction.study.run import QUICK, StudySettings, run_study

    given: dict[str, Any] = {
        'seeds': seeds,
        'tuning_seeds': tuning_seeds,
        'evaluations': evaluations,
        'observers': _names(observers),
        'motions': _names(motions),
        'conditions': _names(conditions),
    }
    chosen = {name: value for name, value in given.items() if value is not None}
    settings = StudySettings(**{**(QUICK if quick else {}), **chosen}, bits=bits)
    if processes is not None and not 1 <= processes <= _MOST_PROCESSES:
        raise ConfigurationError(
            f'the number of processes is {processes}: use 1 to {_MOST_PROCESSES}'
        )
    folder = check_study_destination(out)
    with progress('starting') as step:
        result = run_study(settings, processes, step)
        step('fitting friction laws')
        document = study_document(result)
        write_study(folder, result, document, lambda name: step(f'drawing {name}'))
    if json:
        typer.echo(to_json({**document, 'output': str(folder)}))
    else:
        print_table(study_tables(result))
        typer.echo(f'study.html, study.json and the figures are in {folder}')


app.command()(diagnose)
app.command()(simulate)


@app.command()
def demo(
    out: Annotated[Path, folder_option('Where to write the recording and the report.')] = Path(
        'demo_output'
    ),
    seed: Annotated[int, typer.Option(help='Seed of the noise in the emulator.')] = 0,
    json: JsonOption = False,
) -> None:
    """
    Identify an emulated exoskeleton, from CAN frames to the report.

    Starts the emulator, the driver, the observers and the identifier as processes of their own,
    and compares what they find with the friction that is in the emulator.

    Example: sosml demo --out demo_output
    """
    from sosml_friction.nodes.demo import run_demo

    code = run_demo(output=out, seed=seed, json=json)
    if code:
        raise typer.Exit(code)


def main(arguments: Sequence[str] | None = None) -> int:
    """
    Run the tool and return its exit code.

    :param arguments: the command line without the name of the program; sys.argv's if None.
    """
    _arguments[:] = sys.argv[1:] if arguments is None else arguments
    try:
        # Not standalone: usage errors come back, to be told in one sentence like all others.
        result = app(args=arguments, prog_name='sosml', standalone_mode=False)
    except SosmlFrictionError as error:
        return _refuse(str(error))
    except OSError as error:
        return _refuse(f'{error.filename or "a file"} cannot be used: {error.strerror}')
    except (KeyboardInterrupt, typer.Abort):
        result = _INTERRUPTED
    except _UsageError as error:
        command = error.ctx.command_path if error.ctx else 'sosml'
        return _refuse(f'{_sentence(error.format_message())} (see {command} --help)')
    # Newer versions of Typer answer Ctrl-C with the code, older ones with Abort.
    if result == _INTERRUPTED:
        _remark('interrupted')
    return result if isinstance(result, int) else 0


# Typer bundles its own copy of click since 0.20 and needs click itself before: both end here.
_UsageError: Any = typer.BadParameter.__base__


def _sentence(text: str) -> str:
    text = ' '.join(text.split()).rstrip('.')
    return text[:1].lower() + text[1:]


def _refuse(text: str) -> int:
    print(f'sosml: {" ".join(text.split())}', file=sys.stderr)
    return 2


def _remark(text: str) -> None:
    print(f'sosml: {text}', file=sys.stderr)


def _names(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(name.strip() for name in text.split(','))


def _says_effort_hold(bag: Path, namespace: str | None) -> bool:
    from sosml_friction.bags.bag import Bag

    return Bag.open(bag, namespace).text('observer_configuration') is not None


def _joint_names(bag: Path, namespace: str | None) -> tuple[str, ...]:
    from sosml_friction.bags.bag import Bag

    return Bag.open(bag, namespace).joint_log().names


def _remark_on(bag: Path, analysis: Any, several: bool) -> None:
    """Tell on stderr what is wrong with a recording."""
    begin = f'{bag}: ' if several else ''
    if analysis.model.provenance.get('recovered'):
        _remark(f'{bag} is cut off or damaged: only its readable part was used')
    if analysis.data_checks is not None:
        for sentence in analysis.data_checks.sentences:
            _remark(f'{begin}{sentence}')
    if not several:
        for joint, reason in analysis.unmodelled.items():
            _remark(f'{joint} has no friction in the model: {reason}')


def _command_line() -> str:
    return shlex.join(['sosml', *_arguments])


def _has_effort(analysis: Any, joint: str) -> bool:
    import numpy as np

    return bool(np.isfinite(analysis.log.select([joint]).tau).any())


def _shipped_mapping(file: Path) -> Path:
    """
    Return the mapping in config/import whose name is a word of the file's name.

    :raises ConfigurationError: if none or several are; the sentence lists those that exist.
    """
    shipped = sorted((share_directory() / 'config' / 'import').glob('*.yaml'))
    words = {file.stem.lower(), *re.split(r'[^a-z0-9]+', file.stem.lower())}
    found = [path for path in shipped if path.stem.lower() in words]
    if len(found) != 1:
        names = ', '.join(path.stem for path in shipped) or 'none'
        raise ConfigurationError(
            f'the name {file.name} says not which mapping to use: give one with --map (shipped '
            f'are {names}, in {share_directory() / "config" / "import"})'
        )
    return found[0]


def _information_lines(information: dict[str, Any]) -> Iterator[str]:
    yield (
        f'{information["path"]}: {information["messages"]} messages over '
        f'{information["duration_s"]:.2f} s'
    )
    if information['recovered']:
        yield f'Damaged: {information["recovery"]}'
    held = [name for name, there in information['descriptions'].items() if there]
    lacking = [name for name, there in information['descriptions'].items() if not there]
    yield f'Holds {", ".join(held) or "no description"}' + (
        f'; not {", ".join(lacking)}' if lacking else ''
    )
    if information['tags']:
        yield 'Conditions: ' + ', '.join(f'{k}={v}' for k, v in information['tags'].items())
    motion = information['joint_states']
    if motion is None:
        yield f'No motion: {information["joint_states_problem"]}'
        return
    for joint, what in motion['measured'].items():
        yield f'Joint {joint}: {", ".join(what) or "nothing measured"}'
    yield (
        f'joint_states: {motion["samples"]} samples at {motion["rate_hz"]:.4g} Hz, '
        f'{motion["gaps"]} gaps (longest step {motion["longest_step_s"]:.4g} s), '
        f'{motion["repeated_stamps"]} repeated and {motion["backward_stamps"]} backward stamps'
    )


if __name__ == '__main__':
    sys.exit(main())
