# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the recording of one joint, before anything is fitted to it."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.data_finding import (
    LEFT_OUT,
    NOTE,
    REFUSED,
    WARNING,
    DataFinding,
)
from sosml_friction.identification.joint_relations import (
    SCALE,
    VELOCITY_UNITS,
    WELL,
    EffortRelation,
    Slopes,
    VelocityRelation,
    Zero,
    effort_relation,
    lost_sign,
    speed_limit,
    velocity_relation,
)
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.identification.position_leaps import position_leaps
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.effort_delay import LARGEST_S
from sosml_friction.model.terms.gravity import HEAVIER
from sosml_friction.observers.signal_noise import signal_noise
from sosml_friction.regression.kernels import runs

#: What a finding is called of effort that is late by a joint alone, and later than fits undo.
BY_JOINT, TOO_LATE = 'effort_lag', 'effort_too_late'
#: Motion in one direction for less than this says nothing [s], and so does less than this share of
#: that in the other direction. Chosen, no measurement.
_LEAST_MOTION_S, _LEAST_SHARE = 0.15, 0.02
#: A joint whose travel is less than this share of the farthest one's rests, and gives way.
#: Friction turns around within about as much. Chosen, no measurement.
_GIVES_WAY = 5e-3
#: Share of saturated samples beyond which the joint is not fitted.
_MOST_SATURATED = 0.2
#: A speed this many times the URDF's limit is no speed of that robot, if its bodies do not tell.
_IMPOSSIBLE = 3.0
#: What a finding is called that position counts from another zero.
ZERO = 'position_zero'
#: A velocity this many times the slope of position is another one.
_OTHER_VELOCITY = 1.2
#: Most of an effort that is left beside the slope of position where it is a velocity: viscous
#: friction alone makes such an effort, and leaves more for Coulomb friction and inertia. Chosen,
#: no measurement.
_IS_VELOCITY = 0.1
#: Least of a velocity that the slope leaves where it is none: as much as half of it, a quarter of
#: its squares. By definition of a minority.
_IS_NONE = 0.5
#: The misfit of a hypothesis that is to refuse a joint is at most this share of that of the data
#: as they are. Chosen, no measurement.
FAR = 1.0 / 3.0
#: The same of an effort that lost its sign. Of 200 pendulums with cogging and a knee, which the
#: check does not know, efforts lifted until they hardly touch 0 had 0.96 at least, and lost signs
#: of a tenth of the samples and more at most 0.31, three quarters of them (as in
#: test_one_sign_by_right_is_never_taken_for_a_lost_one).
_SIGNED = 0.75
#: Masses of a URDF, a payload that it lacks included, are off by less than ``HEAVIER`` as a rule,
#: and by less than this always. Chosen, no measurement: A for Nm is 8 to 12 for a UR10e, V for N
#: 35 for the EMPS axis. Inertia alone has to say the square of it, as a load that is not in the
#: URDF is many times a rotor. So has a limit, which is often a guess. mA for A is 1000.
_OTHER_UNIT = 6.0
#: Share of the samples of an effort that its limit is compared with, and the largest limit that
#: stands for none [Nm or N]: URDFs have to state one, and 0 and 1 are what who knows none writes.
_USUAL, _NO_LIMIT = 0.99, 1.0
#: Scales of gravity and of inertia differ by less than this factor if both are one of the effort.
_ALIKE = 2.0
#: Separate motions in each direction that a turned sign must be seen in.
_FEWEST_RUNS = 3
#: Largest friction of the wrong sign, as a share of the effort's range, that a delay of effort
#: explains.
_FEIGNED = 0.02
#: Chance that a run of equal extreme efforts is none of saturation.
_CHANCE = 1e-3
_FEWEST_EQUAL = 5
#: Positions that leap fewer times do not make a recording another one. Chosen, no measurement.
_FEWEST_LEAPS = 3


@dataclass(frozen=True)
class JointChecks:
    """
    Hold what was measured of one joint; NaN where the recording does not tell.

    ``travel`` [rad or m]: range of motion. ``top_speed`` [rad/s or m/s]: 99 % quantile of the
    speed as a difference over 0.1 s. ``speed_limit`` and ``effort_limit``: the URDF's.
    ``forwards_s`` and ``backwards_s``: time in motion with known effort. ``position_step`` and
    ``effort_step``: resolutions. ``friction_level`` +- ``friction_level_error`` [Nm or N]: half of
    the change of effort, without gravity, when the velocity changes its sign at the median speed;
    negative where friction would drive. ``velocity_factor``: reported velocity over the slope of
    position. The last two are shares of the samples, 0 to 1.
    """

    travel: float
    top_speed: float
    speed_limit: float
    effort_limit: float
    forwards_s: float
    backwards_s: float
    position_step: float
    effort_step: float
    friction_level: float
    friction_level_error: float
    velocity_factor: float
    without_effort: float
    saturated: float


#: What was measured of a joint, its velocity and effort as far as they can be used (N,), and what
#: was found.
Checked = tuple[JointChecks, FloatArray, FloatArray, list[DataFinding]]


def check_each_joint(
    log: JointLog, robot: Robot, slopes: Slopes, free_rotors: Collection[str] = ()
) -> list[Checked]:
    """
    Return what was measured and found of each joint.

    :param log: stamps that rise, every position known, joints in the order of ``robot``.
    :param free_rotors: joints whose armature is not known.
    """
    found = [
        _check_joint(log, robot, i, slopes, name in free_rotors)
        for i, name in enumerate(robot.names)
    ]
    # Behind a joint whose zero is another, gravity is turned as well.
    off = {i for i, each in enumerate(found) if any(f.check == ZERO for f in each[3])}
    for i, each in enumerate(found):
        if off.intersection(robot.carriers(i)):
            each[3][:] = [finding for finding in each[3] if finding.check != ZERO]
    return found


def _check_joint(
    log: JointLog, robot: Robot, i: int, slopes: Slopes, free_rotor: bool = False
) -> Checked:
    name, limit = robot.names[i], robot.limits[i]
    way = 'rad' if robot.effort_units[i] == 'Nm' else 'm'
    q, tau = log.q[:, i], log.tau[:, i].copy()
    known = np.isfinite(tau)
    period, half, v = slopes.period, slopes.half, slopes.v[:, i]
    step, noise = signal_noise(q)
    # One count, or the noise of two positions, is no motion.
    least = (step + 5.0 * np.sqrt(2.0) * noise) / (2 * half * period)
    moving = np.abs(np.nan_to_num(v)) > least
    saturated = _saturated(tau, limit.effort)
    usable = known & moving & ~saturated
    forwards, backwards = (
        float(np.sum(usable & (np.sign(np.nan_to_num(v)) == side))) * period for side in (1, -1)
    )
    level = error = np.nan
    if min(forwards, backwards) > _LEAST_MOTION_S:
        level, error = _friction_level(log, robot, i, slopes, np.where(usable, tau, np.nan))
    velocity = velocity_relation(log.v[:, i], slopes, i, moving)
    found = JointChecks(
        travel=float(np.ptp(q)),
        top_speed=_top_speed(v),
        speed_limit=limit.velocity,
        effort_limit=limit.effort,
        forwards_s=forwards,
        backwards_s=backwards,
        position_step=step,
        effort_step=_smallest_step(tau[known]),
        friction_level=level,
        friction_level_error=error,
        velocity_factor=np.nan if velocity is None else velocity.factor,
        without_effort=float(np.mean(~known)),
        saturated=float(np.mean(saturated)),
    )
    own_v = log.v[:, i]
    findings = []
    if name in log.wraps:
        what = (
            f'the position of joint {name} wraps by {log.wraps[name]:.5g} {way}: it was made '
            'continuous'
        )
        findings.append(DataFinding('wrap', name, WARNING, what))
    if (leaps := position_leaps(log.time, q, step, noise)) >= _FEWEST_LEAPS:
        what = (
            f'the position of joint {name} leaps {leaps} times, farther in one sample than in '
            'those before and after it: rows are missing, and the stamps do not say so; record '
            'the stamp of each sample: speeds that are none look like a wrong effort'
        )
        findings.append(DataFinding('leaps', name, WARNING, what))
    if not known.any():
        return found, own_v, tau, findings
    if rest := _rest(log, robot, i, forwards + backwards):
        # What it reports is what the others load it with, and no friction of a motion.
        findings.append(DataFinding('rest', name, LEFT_OUT, rest))
        return found, own_v, np.full_like(tau, np.nan), findings
    effort = effort_relation(log, robot, i, slopes, usable, free_rotor)
    refusal = _refusal(robot, i, q, tau, found, effort, _fewest_runs(v, usable))
    if not refusal and (misfits := lost_sign(log, robot, i, slopes, usable)):
        refusal = _without_sign(name, *misfits)
    if not refusal and velocity is not None:
        refusal = _exchanged(log, i, slopes, usable, velocity)
    if refusal:
        check, sentence = refusal
        findings.append(DataFinding(check, name, REFUSED, sentence))
        return found, own_v, np.full_like(tau, np.nan), findings
    if effort is not None:
        findings += _told(robot, i, effort, _drives(found))
    if velocity is not None:
        own_v, told = _velocity(log, robot, i, velocity)
        findings += told
    if not known.all():
        what = (
            f'joint {name} has no effort in {100.0 * found.without_effort:.2g} % of the '
            'samples, which are left out'
        )
        findings.append(DataFinding('without_effort', name, LEFT_OUT, what))
    if saturated.any():
        tau[saturated] = np.nan
        what = (
            f'the effort of joint {name} stays at its extreme in {100.0 * found.saturated:.2g} % '
            'of the samples, which are left out: it is limited there, and no measurement'
        )
        findings.append(DataFinding('saturation', name, LEFT_OUT, what))
    if reached := speed_limit(log, robot, i, slopes, usable):
        top, at = reached
        tau[at] = np.nan
        what = (
            f'joint {name} goes no faster than {top:.3g} {way}/s in either direction, and its '
            f'effort drops and scatters there ({100.0 * np.mean(at):.2g} % of the samples, which '
            'are left out): its drive is at the limit of its speed'
        )
        findings.append(DataFinding('speed_limit', name, LEFT_OUT, what))
    if limit.upper - limit.lower > 0.0 and (q.min() < limit.lower or q.max() > limit.upper):
        what = (
            f'joint {name} is at {q.min():.4g} to {q.max():.4g}, and its URDF allows '
            f'{limit.lower:.4g} to {limit.upper:.4g} {way}'
        )
        findings.append(DataFinding('limits', name, NOTE, what))
    if 0.0 < limit.velocity < found.top_speed:
        what = (
            f'joint {name} moves at {found.top_speed:.3g} {way}/s, faster than the '
            f'{limit.velocity:.3g} its URDF allows'
        )
        findings.append(DataFinding('speed', name, NOTE, what))
    return found, own_v, tau, findings


def _top_speed(v: FloatArray) -> float:
    """Return the 99 % quantile of the speed, NaN where none is known."""
    speeds = np.abs(v[np.isfinite(v)])
    return float(np.quantile(speeds, 0.99, overwrite_input=True)) if len(speeds) else np.nan


def _smallest_step(x: FloatArray) -> float:
    """Return the smallest change of a signal, NaN where it does not change."""
    steps = np.abs(np.diff(x))
    smallest = float(np.min(steps, where=steps > 0.0, initial=np.inf))
    return smallest if np.isfinite(smallest) else np.nan


def _rest(log: JointLog, robot: Robot, i: int, moved_s: float) -> str | None:
    """Return that a joint rests, or hardly gives way, while others move; None if it moves."""
    unit = robot.effort_units[i]
    travels = np.ptp(log.q, axis=0)
    alike = [k for k in range(robot.n) if robot.effort_units[k] == unit]
    most = max(alike, key=lambda k: travels[k])
    name, way = robot.names[i], 'rad' if unit == 'Nm' else 'm'
    if moved_s > _LEAST_MOTION_S and travels[i] >= _GIVES_WAY * travels[most]:
        return None
    text = f'joint {name} does not move while its effort is known (its range is {travels[i]:.3g}'
    text += f' {way}' if most == i else f' {way}, that of {robot.names[most]} {travels[most]:.3g}'
    return f'{text}), and is left out as resting: record motion in both directions of it'


def _refusal(
    robot: Robot,
    i: int,
    q: FloatArray,
    tau: FloatArray,
    found: JointChecks,
    effort: EffortRelation | None,
    fewest_runs: int,
) -> tuple[str, str] | None:
    """Return (check, sentence) if the joint cannot be fitted."""
    name, unit, limit = robot.names[i], robot.effort_units[i], robot.limits[i]
    way, other, per_unit = ('rad', 'degrees', 180.0 / np.pi) if unit == 'Nm' else ('m', 'mm', 1e3)
    convert = 'degrees to rad' if unit == 'Nm' else 'millimetres to m'
    wrong_unit = (
        f'convert {convert} in the driver or the mapping, divide what is of a motor by the ratio '
        'of its gear, or correct the URDF'
    )
    if (
        effort is not None
        and effort.unit is not None
        and effort.unit_misfit < WELL * effort.by_bodies
    ):
        return 'position_unit', (
            f'the position of joint {name} is in {effort.unit}: read so, gravity and inertia of '
            f'its URDF leave {_percent(effort.unit_misfit)} of its effort unexplained, and '
            f'{_percent(min(effort.free, effort.alone))} as it is: state its own unit, or a '
            f'scale, in the mapping or the options, or convert it to {way} in the driver'
        )
    fits = effort is not None and effort.fits
    room = limit.upper - limit.lower
    outside = max(limit.lower - float(q.min()), float(q.max()) - limit.upper)
    if 0.0 < room < np.inf and outside > 0.5 * room and not fits:
        # What goes no further than the joint can is off by its zero, not by its unit.
        inside = found.travel > room
        inside &= limit.lower - room < float(q.min()) / per_unit
        inside &= float(q.max()) / per_unit < limit.upper + room
        so = f' (read as {other} it would be inside)' if inside else ''
        correct = wrong_unit if inside else 'correct its zero or the URDF'
        if not inside and np.array_equal(q, np.rint(q)):
            correct = (
                'these are whole numbers, as counts of an encoder are: state them as counts, and '
                'how many are a turn, in the mapping, or correct its zero or the URDF'
            )
        return 'position_unit', (
            f'joint {name} is at {q.min():.4g} to {q.max():.4g} where its URDF allows '
            f'{limit.lower:.4g} to {limit.upper:.4g} {way}{so}: {correct}'
        )
    if 0.0 < _IMPOSSIBLE * limit.velocity < found.top_speed and not fits:
        return 'position_unit', (
            f'joint {name} moves at {found.top_speed:.3g} where its URDF allows '
            f'{limit.velocity:.3g} {way}/s: {wrong_unit}'
        )
    if found.saturated > _MOST_SATURATED:
        extreme = float(np.nanmax(np.abs(tau)))
        return 'saturation', (
            f'the effort of joint {name} stays at its extreme of {extreme:.4g} {unit} in '
            f'{100.0 * found.saturated:.0f} % of the samples, where it is limited and no '
            'measurement: move more slowly, with less load, or raise the limit'
        )
    known = tau[np.isfinite(tau)]
    moved = found.forwards_s + found.backwards_s
    if len(known) and np.ptp(known) == 0.0:
        return 'constant_effort', (
            f'the effort of joint {name} is {known[0]:.4g} {unit} in every sample though it '
            'moves, so it is not measured: let the driver fill it'
        )
    if min(found.forwards_s, found.backwards_s) <= max(_LEAST_MOTION_S, _LEAST_SHARE * moved):
        side = 'forwards' if found.forwards_s > found.backwards_s else 'backwards'
        return 'one_direction', (
            f'joint {name} moves in one direction only ({side}, {moved:.3g} s), where friction '
            'cannot be told from gravity: record motion in both directions'
        )
    level = found.friction_level
    drives = _drives(found) and -level > _FEIGNED * float(np.ptp(known))
    turned = effort is None or not effort.tells or effort.scale < 0.0
    if drives and turned and fewest_runs >= _FEWEST_RUNS:
        bodies = ''
        if effort is not None and effort.tells:
            bodies = f', and {effort.scale:.3g} times what its bodies need'
        return 'dissipation', (
            f'the effort of joint {name} is {-2.0 * level:.3g} {unit} smaller when it moves '
            f'forwards than backwards, so friction would drive it{bodies}: turn the sign of its '
            'effort, or of its position, in the driver or the mapping, unless something else '
            'moves the joint, as a hand does: then record it moved by its own motor'
        )
    if effort is not None and effort.tells and _is_unit(effort, robot.armature[i] > 0.0):
        own = f'{_scale(effort.scale, effort.error)} times what the bodies of its URDF need'
        if np.isfinite(effort.gravity):
            own = (
                f'{_scale(effort.scale, effort.error)} times what the gravity and '
                f'{effort.inertia / effort.gravity * effort.scale:.4g} times what the inertia of '
                'its URDF need'
            )
        return 'effort_unit', (
            f'the effort of joint {name} is {own}: it is not in {unit}; give its scale (a torque '
            'constant for A) in the mapping, or correct the masses'
        )
    usual = float(np.quantile(np.abs(known), _USUAL)) if len(known) else 0.0
    if limit.effort > _NO_LIMIT and _OTHER_UNIT**2 * limit.effort < usual and not fits:
        return 'effort_unit', (
            f'the effort of joint {name} is up to {usual:.4g} where its URDF allows '
            f'{limit.effort:.4g} {unit}: it is not in {unit}, or that limit is none; give its '
            'scale (a torque constant for A) in the mapping, or correct the limit'
        )
    return None


def _without_sign(name: str, signed: float, as_it_is: float) -> tuple[str, str] | None:
    """Return (check, sentence) if an effort of one sign fits its motion with two only."""
    if signed > _SIGNED * as_it_is:
        return None
    return 'lost_sign', (
        f'the effort of joint {name} never changes its sign, and its motion says that it did: '
        f'with the signs that friction, gravity and inertia need they leave {_percent(signed)} of '
        f'it unexplained, and {_percent(as_it_is)} as it is; log the torque, or the current that '
        'makes it, with its sign, and not its size or rms'
    )


def _drives(found: JointChecks) -> bool:
    """Tell whether effort is smaller forwards than backwards, by three standard errors."""
    return found.friction_level < -3.0 * found.friction_level_error


def _is_unit(effort: EffortRelation, rotor: bool) -> bool:
    """
    Tell whether gravity and inertia both say that the effort is in another unit.

    Where there is no gravity inertia does alone, if the rotor's is in it, and by more than a load
    that the model lacks is.

    :param rotor: whether the model has one: behind a gear it is many times its link.
    """
    parts = np.array([effort.gravity, effort.inertia]) / effort.scale
    alike = bool((parts > 1.0 / _ALIKE).all() and (parts < _ALIKE).all())
    most = _OTHER_UNIT
    if np.isnan(effort.gravity) and np.isfinite(effort.inertia):
        alike, most = rotor, _OTHER_UNIT**2
    far = not 1.0 / most < effort.scale < most
    return alike and far and effort.scale > 0.0 and effort.free < FAR * effort.alone


def _is_turned(zero: Zero, alone: float) -> bool:
    """Tell whether gravity of the URDF's masses explains the effort from another zero alone."""
    masses = 1.0 / SCALE < zero.scale < SCALE
    return masses and zero.misfit < FAR * min(zero.upright, alone)


def _told(robot: Robot, i: int, effort: EffortRelation, drives: bool) -> list[DataFinding]:
    """
    Return what the effort beside the bodies says without refusing the joint.

    :param drives: whether friction would drive the joint.
    """
    name, unit = robot.names[i], robot.effort_units[i]
    found = []
    scale = effort.scale
    far = not 1.0 / SCALE < scale < SCALE and effort.free < FAR * effort.as_it_is
    if effort.zero is not None and _is_turned(effort.zero, effort.alone):
        what = (
            f'position 0 of joint {name} seems to be {effort.zero.at:.3g} rad from that of its '
            f'URDF: by gravity so turned {_percent(effort.zero.misfit)} of its effort are left '
            f'unexplained, and {_percent(effort.as_it_is)} as it is; add as much to the position '
            '(offset in the mapping), or correct the URDF'
        )
        found.append(DataFinding(ZERO, name, WARNING, what))
    elif effort.tells and (far or not 1.0 / HEAVIER < scale < HEAVIER):
        what = (
            f'the effort of joint {name} is {_scale(scale, effort.error)} times what the bodies '
            f'of its URDF need to move as they did: by that scale {_percent(effort.free)} of it '
            f'are left unexplained, by 1 {_percent(effort.as_it_is)}. '
        )
        if scale < 0.0 and drives:
            what += 'Friction drives it, too: turn the sign of its effort in the mapping'
        elif scale < 0.0:
            what += 'Its axis or gravity in the URDF has the other sign'
        else:
            own = ''
            if effort.unit is not None and 1.0 / SCALE < effort.unit_scale < SCALE:
                own = f'its position is in {effort.unit}, or '
            elif np.isnan(effort.gravity):
                # A weight would say where its joint is.
                own = f'its position is not in {"rad" if unit == "Nm" else "m"}, '
            what += f'Either {own}its effort is not in {unit}, or the masses are others'
        found.append(DataFinding('effort_unit', name, WARNING, what))
    if effort.late_s:
        what = (
            f'the effort of joint {name} is {1e3 * effort.late_s:.3g} ms late: so '
            f'shifted, {_percent(effort.late_misfit)} of it are left unexplained and '
            f'{_percent(effort.free)} as it is'
        )
        check = BY_JOINT
        if effort.late_s > LARGEST_S:
            check = TOO_LATE
            what += (
                f'. No fit undoes more than {1e3 * LARGEST_S:.0f} ms: what is left of it is in '
                'the law; see the clocks of both, or shift it in the table'
            )
        found.append(DataFinding(check, name, WARNING, what))
    return found


def _exchanged(
    log: JointLog, i: int, slopes: Slopes, usable: BoolArray, velocity: VelocityRelation
) -> tuple[str, str] | None:
    """Return why effort is the velocity and the reverse, None where it is not."""
    if velocity.misfit < _IS_NONE:
        return None
    # A velocity without its sign is one.
    signed = np.abs(log.v[:, i]) * np.sign(np.nan_to_num(slopes.v[:, i]))
    effort, speed = (velocity_relation(x, slopes, i, usable) for x in (log.tau[:, i], signed))
    if effort is None or effort.misfit > _IS_VELOCITY:
        return None
    if speed is not None and speed.misfit < _IS_NONE:
        return None
    return (
        'exchanged',
        f'the effort of joint {log.names[i]} is the slope of its position but for '
        f'{_percent(effort.misfit)}, and its velocity is not, which leaves '
        f'{_percent(velocity.misfit)}: exchange the columns of both',
    )


def _velocity(
    log: JointLog, robot: Robot, i: int, velocity: VelocityRelation
) -> tuple[FloatArray, list[DataFinding]]:
    """Return the velocity that can be used (N,), and what is said of the reported one."""
    name, own = robot.names[i], log.v[:, i]
    alike = 1.0 / _OTHER_VELOCITY < velocity.factor < _OTHER_VELOCITY
    if alike or abs(velocity.factor - 1.0) < 3.0 * velocity.error:
        if not velocity.late_s:
            return own, []
        when = 'late' if velocity.late_s > 0.0 else 'early'
        what = (
            f'the velocity of joint {name} is {1e3 * abs(velocity.late_s):.3g} ms {when} beside '
            'the slope of its position'
        )
        # A slope over a window is late by half of it; what is fitted uses positions.
        return own, [DataFinding('velocity_lag', name, NOTE, what)]
    unit = velocity.unit(VELOCITY_UNITS[robot.effort_units[i]])
    what = (
        f'the velocity of joint {name} is {_scale(velocity.factor, velocity.error)} times the '
        f'slope of its position{f", {unit}" if unit else ""}, which leaves '
        f'{_percent(velocity.misfit)} of it unexplained: the slope is used instead'
    )
    if unit is None and velocity.factor > 0.0:
        what += (
            '. If the velocity is right and the position has another scale, viscous friction is '
            f'{1.0 / velocity.factor:.3g} times what is said here'
        )
    return _slope(log, i), [DataFinding('velocity_unit', name, LEFT_OUT, what)]


def _slope(log: JointLog, i: int) -> FloatArray:
    """Return the backward difference of a position (N,), the first once more."""
    slope = np.diff(log.q[:, i]) / np.diff(log.time)
    return np.append(slope[:1], slope)


def _scale(value: float, error: float) -> str:
    """Return a factor with its error where that is known."""
    return plus_minus(value, 2.0 * error)


def _percent(share: float) -> str:
    """Return a share in percent."""
    return f'{100.0 * share:.2g} %' if share < 1.0 else f'{100.0 * share:.0f} %'


def _fewest_runs(v: FloatArray, usable: BoolArray) -> int:
    """Return how many separate motions there are in the direction that has fewer."""
    way = np.where(usable, np.sign(np.nan_to_num(v)), 0.0)
    way = way[way != 0.0]
    if not len(way):
        return 0
    firsts = way[np.append(True, np.diff(way) != 0.0)]
    return int(min(np.sum(firsts > 0.0), np.sum(firsts < 0.0)))


def _saturated(tau: FloatArray, limit: float) -> BoolArray:
    """
    Return where effort is limited, (N,): runs of equal samples at an extreme.

    At the URDF's limit five in a row are enough. Elsewhere a run must be longer than chance makes
    it, judged by how often neighbours away from the extremes are equal. Where most of them are (a
    coarse or noise-free effort), only the URDF's limit tells.
    """
    result = np.zeros(len(tau), dtype=bool)
    known = tau[np.isfinite(tau)]
    if len(known) < _FEWEST_EQUAL or np.ptp(known) == 0.0:
        return result
    equal = np.append(False, tau[1:] == tau[:-1])
    for extreme in (known.min(), known.max()):
        at = tau == extreme
        inner = np.isfinite(tau) & (tau != known.min()) & (tau != known.max())
        share = float(np.mean(equal[inner])) if inner.any() else 1.0
        at_limit = 0.0 < limit < np.inf and abs(extreme) >= 0.98 * limit
        if share > 0.5 and not at_limit:
            continue
        fewest = _FEWEST_EQUAL
        if share > 0.0 and not at_limit:
            fewest = max(fewest, 1 + int(np.ceil(np.log(_CHANCE / len(tau)) / np.log(share))))
        for begin, end in runs(at):
            if end - begin >= fewest:
                result[begin:end] = True
    return result


def _friction_level(
    log: JointLog, robot: Robot, i: int, slopes: Slopes, tau: FloatArray
) -> tuple[float, float]:
    """
    Return the part of effort that is odd in velocity, at the median speed, and its error.

    Least squares of tau on the sign of velocity, its size beyond the median speed, acceleration,
    the model's gravity and a constant: an error of gravity or inertia then hardly counts as
    friction. The error is the jackknife over stretches of 1 s.
    """
    v, a, half = slopes.v[:, i], slopes.a[:, i], slopes.half
    rows = np.flatnonzero(np.isfinite(a) & np.isfinite(v) & np.isfinite(tau))[:: max(1, half // 2)]
    groups = np.unique(log.time[rows].astype(np.int64), return_inverse=True)[1]
    if len(rows) < 20 or groups.max() < 3:
        return np.nan, np.nan
    sign = np.sign(v[rows])
    median = float(np.median(np.abs(v[rows])))
    g = robot.statics(log.q[rows])[1][:, i]
    columns = [sign, v[rows] - sign * median, a[rows], g, np.ones(len(rows))]
    # A column that does not vary is the constant once more.
    X = np.column_stack([c for k, c in enumerate(columns) if k in (0, 4) or np.ptp(c) > 1e-9])
    norms = np.linalg.norm(X, axis=0)
    theta = np.linalg.lstsq(X / norms, tau[rows], rcond=1e-9)[0]
    errors = jackknife_errors(X / norms, tau[rows] - X / norms @ theta, groups)
    return float(theta[0] / norms[0]), float(errors[0] / norms[0])
