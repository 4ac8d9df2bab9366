# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.law_fit import jackknife_errors
from sosml_friction.identification.segments import centred_difference
from sosml_friction.model.robot import Robot
from sosml_friction.observers.signal_noise import signal_noise

FloatArray = NDArray[np.float64]

#: What a finding means: the data say nothing against it; a part of them is not used; no fit.
NOTE, LEFT_OUT, REFUSED = 'note', 'left_out', 'refused'

#: Six windows of steady motion, the fewest a law is fitted to, last so long [s].
SHORTEST_S = 2.0
#: A stamp further back than this is of another recording, a nearer one came late [s].
_LATE_S = 0.1
#: Speeds are differences of position over so long [s].
_WINDOW_S = 0.1
#: Motion in one direction for less than this says nothing [s]: a shorter window is not used.
_LEAST_MOTION_S = 0.15
#: Steps longer than this many periods count as a gap.
_GAP_PERIODS = 1.5
#: Share of samples beyond which what is wrong with them is wrong with the recording.
_MOST_REPEATED, _MOST_SATURATED, _LEAST_KEPT = 0.2, 0.2, 0.5
#: A speed this many times the URDF's limit is no speed of that robot.
_IMPOSSIBLE = 1.5
#: A velocity so many times the slope of position is in another unit.
_OTHER_UNIT = 2.0
#: Driving friction, as a share of the effort's range, that a delayed effort can feign.
_FEIGNED = 0.02
#: Chance that a run of equal extreme efforts is none of saturation.
_CHANCE = 1e-3
_FEWEST_EQUAL = 5


@dataclass(frozen=True)
class DataFinding:
    """
    Say one thing about a recording.

    ``check`` names what was looked at, ``joint`` where (``*``: all of it), ``level`` is one of
    ``note``, ``left_out`` (a part of the data is not used) and ``refused`` (the joint is not
    fitted). ``sentence`` says what, where, and what to do, without a full stop.
    """

    check: str
    joint: str
    level: str
    sentence: str


@dataclass(frozen=True)
class JointChecks:
    """
    Hold what was measured of one joint; NaN where the recording does not tell.

    ``travel`` [rad or m] is its range, ``top_speed`` [rad/s or m/s] what 99 % of the differences
    over 0.1 s stay below, ``speed_limit`` and ``effort_limit`` the URDF's. ``forwards_s`` and
    ``backwards_s`` is how long it moved with known effort. ``position_step`` and ``effort_step``
    are the resolutions that are seen. ``friction_level`` +- ``friction_level_error`` [Nm or N] is
    half of what effort changes by, beside gravity, when the velocity at the median speed changes
    its sign: negative where friction would drive. ``velocity_factor`` is the reported velocity
    over the slope of position. The last two are shares of the samples, 0 to 1.
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


@dataclass(frozen=True)
class DataChecks:
    """
    Hold what was found in a recording.

    ``samples`` were recorded and ``used`` of them are fitted, over ``duration_s`` at a median
    period of ``period_s``, from which steps differ by ``jitter_s`` (half of the samples by less).
    ``gaps`` are steps of more than 1.5 periods, ``longest_step_s`` the longest. Left out are
    ``repeated_stamps``, ``backward_stamps`` (samples of another pass, or none where they only came
    late and were put in order) and ``incomplete_samples`` (a position is missing).

    ``refused`` says of a joint with effort why it is not fitted.
    """

    samples: int
    used: int
    duration_s: float
    period_s: float
    jitter_s: float
    gaps: int
    longest_step_s: float
    repeated_stamps: int
    backward_stamps: int
    incomplete_samples: int
    joints: Mapping[str, JointChecks] = field(default_factory=dict)
    findings: tuple[DataFinding, ...] = ()

    @property
    def refused(self) -> dict[str, str]:
        """Return by joint why it is not fitted, without a full stop."""
        return {f.joint: f.sentence for f in self.findings if f.level == REFUSED}

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return what a person should be told: everything that is more than a note."""
        return tuple(f.sentence for f in self.findings if f.level != NOTE)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, strings and lists for ``fit.json``; unknown is NaN."""
        document = asdict(self)
        document['joints'] = {name: asdict(joint) for name, joint in self.joints.items()}
        document['findings'] = [asdict(finding) for finding in self.findings]
        return document


def check_data(log: JointLog, robot: Robot, recovery: str = '') -> tuple[JointLog, DataChecks]:
    """
    Return the part of a recording that can be fitted, and what is wrong with all of it.

    The log returned has stamps that rise, a position of every joint in every sample, and NaN for
    effort that saturates and for all effort of a joint that is refused: it is then not fitted, and
    ``refused`` says why. A run without position is left out as if it had never been received.

    :param log: the recording; its joints include the robot's.
    :param robot: its limits and gravity are what the data are held against.
    :param recovery: what a cut-off bag says of itself, empty for a whole one.
    :raises DataError: if no joint can be fitted; one sentence: what, where, and what to do.
    """
    log = log.select(robot.names)
    log.require_effort()
    findings: list[DataFinding] = []
    if recovery:
        findings.append(DataFinding('cut_off', '*', LEFT_OUT, recovery))
    samples = len(log)
    log, backward = _one_pass(log, findings)
    log, repeated = _without_repeats(log, findings)
    log, incomplete = _whole_samples(log, findings)
    steps = np.diff(log.time)
    duration = float(log.time[-1])
    if len(steps) == 0 or duration < SHORTEST_S:
        raise DataError(
            f'the recording has {len(log)} usable samples over {duration:.3g} s: friction needs '
            f'at least {SHORTEST_S:g} s of motion at several speeds in both directions; record a '
            'trajectory (sosml trajectory lists them)'
        )
    period = float(np.median(steps))
    joints = {}
    tau = log.tau.copy()
    for i, name in enumerate(robot.names):
        joints[name], tau[:, i], own = _check_joint(log, robot, i)
        findings += own
    gaps = int(np.sum(steps > _GAP_PERIODS * period))
    if gaps:
        missing = float(np.sum(steps[steps > _GAP_PERIODS * period]))
        findings.append(
            DataFinding(
                'gaps', '*', NOTE,
                f'{gaps} steps are longer than {_GAP_PERIODS:g} periods of {1e3 * period:.3g} ms, '
                f'{missing:.3g} s together, the longest {steps.max():.3g} s',
            )
        )  # fmt: skip
    checks = DataChecks(
        samples,
        len(log),
        duration,
        period,
        float(np.median(np.abs(steps - period))),
        gaps,
        float(steps.max()),
        repeated,
        backward,
        incomplete,
        joints,
        tuple(findings),
    )
    with_effort = [n for n, x in zip(robot.names, log.tau.T, strict=True) if np.isfinite(x).any()]
    if all(name in checks.refused for name in with_effort):
        raise DataError('; '.join(checks.refused[name] for name in with_effort))
    return replace(log, tau=tau), checks


def _one_pass(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    """Return the longest stretch of one clock, late samples in order, and what is not in it."""
    steps = np.diff(log.t_ns) * 1e-9
    late = int(np.sum((steps < 0.0) & (steps >= -_LATE_S)))
    jumps = np.flatnonzero(steps < -_LATE_S) + 1
    left = 0
    if len(jumps):
        pieces = np.split(np.arange(len(log)), jumps)
        longest = max(pieces, key=len)
        left = len(log) - len(longest)
        what = (
            f'the stamps go back {len(jumps)} time{"s" if len(jumps) > 1 else ""}, first by '
            f'{-steps[jumps[0] - 1]:.3g} s at sample {jumps[0]}'
        )
        if len(longest) < _LEAST_KEPT * len(log):
            raise DataError(
                f'{what}, and no stretch between holds half of the {len(log)} samples: stamp '
                'joint_states with one clock that is not set meanwhile, and record one pass '
                'to a bag'
            )
        findings.append(
            DataFinding(
                'backward_stamps', '*', LEFT_OUT,
                f'{what}: the {left} samples outside the longest stretch are left out',
            )
        )  # fmt: skip
        log = log.rows(longest)
    if late:
        findings.append(
            DataFinding(
                'backward_stamps', '*', NOTE,
                f'{late} samples came after later ones and were put in order',
            )
        )  # fmt: skip
        log = log.rows(np.argsort(log.t_ns, kind='stable'))
    return log, left


def _without_repeats(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    again = np.append(False, np.diff(log.t_ns) == 0)
    count = int(again.sum())
    if not count:
        return log, 0
    at = np.flatnonzero(again)
    other = int(np.sum((log.q[at] != log.q[at - 1]).any(axis=1)))
    if other > _MOST_REPEATED * len(log):
        raise DataError(
            f'{count} of {len(log)} samples repeat the stamp of the one before, {other} of them '
            'with another position, so the stamps are not the times of measurement: let the '
            'driver stamp each sample when it is measured'
        )
    findings.append(
        DataFinding(
            'repeated_stamps', '*', LEFT_OUT,
            f'{count} of {len(log)} samples repeat the stamp of the one before and are left out',
        )
    )  # fmt: skip
    return log.rows(~again), count


def _whole_samples(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    known = np.isfinite(log.q)
    for name, column in zip(log.names, known.T, strict=True):
        if not column.any():
            raise DataError(
                f'joint {name} has no position in any of {len(log)} samples: let its driver '
                'report it, all joints in one message'
            )
    # A velocity alone may be missing: the observers start afresh there, on line as well.
    whole = np.asarray(known.all(axis=1))
    count = int((~whole).sum())
    if not count:
        return log, 0
    if not whole.any():
        parts = ', '.join(
            f'{name} in {int(column.sum())}'
            for name, column in zip(log.names, known.T, strict=True)
        )
        raise DataError(
            f'no sample has the positions of all joints ({parts} of '
            f'{len(log)}): publish all joints in one message'
        )
    longest = max(len(run) for run in np.split(whole, np.flatnonzero(np.diff(whole)) + 1)
                  if not run[0])  # fmt: skip
    findings.append(
        DataFinding(
            'incomplete_samples', '*', LEFT_OUT,
            f'{count} of {len(log)} samples lack a position and are left out, '
            f'up to {longest} in a row',
        )
    )  # fmt: skip
    return log.rows(whole), count


def _check_joint(
    log: JointLog, robot: Robot, i: int
) -> tuple[JointChecks, FloatArray, list[DataFinding]]:
    """Return what was measured of joint i, its effort as far as it can be used, and findings."""
    name, unit, limit = robot.names[i], robot.effort_units[i], robot.limits[i]
    time, q, tau = log.time, log.q[:, i], log.tau[:, i].copy()
    way = 'rad' if unit == 'Nm' else 'm'
    period = float(np.median(np.diff(time)))
    half = max(1, round(0.5 * _WINDOW_S / period))
    v = centred_difference(time, q, half) if len(time) > 2 * half else np.full(len(time), np.nan)
    step, noise = signal_noise(q)
    known = np.isfinite(tau)
    has_effort = bool(known.any())
    # One count, or the noise of two positions, is no motion.
    least = (step + 5.0 * np.sqrt(2.0) * noise) / (2 * half * period)
    moving = np.abs(np.nan_to_num(v)) > least
    saturated = _saturated(tau, limit.effort)
    usable = known & moving & ~saturated
    forwards, backwards = (
        float(np.sum(usable & (np.sign(np.nan_to_num(v)) == side))) * period for side in (1, -1)
    )
    speeds = np.abs(v[np.isfinite(v)])
    top = float(np.quantile(speeds, 0.99)) if len(speeds) else np.nan
    level, error = np.nan, np.nan
    if min(forwards, backwards) > _LEAST_MOTION_S:
        level, error = _friction_level(log, robot, i, v, np.where(usable, tau, np.nan), half)
    factor = _velocity_factor(log.v[:, i], v, moving, half)
    effort_steps = np.abs(np.diff(tau[known]))
    found = JointChecks(
        float(np.ptp(q)),
        top,
        limit.velocity,
        limit.effort,
        forwards,
        backwards,
        step,
        float(effort_steps[effort_steps > 0.0].min(initial=np.inf))
        if (effort_steps > 0.0).any()
        else np.nan,
        level,
        error,
        factor,
        float(np.mean(~known)),
        float(np.mean(saturated)),
    )
    refusal = _refusal(name, way, unit, robot, i, q, tau, found)
    findings = []
    if has_effort and refusal:
        check, sentence = refusal
        findings.append(DataFinding(check, name, REFUSED, sentence))
        return found, np.full_like(tau, np.nan), findings
    if has_effort and not known.all():
        findings.append(
            DataFinding(
                'without_effort', name, LEFT_OUT,
                f'joint {name} has no effort in {100.0 * found.without_effort:.2g} % of the '
                'samples, which are left out',
            )
        )  # fmt: skip
    if saturated.any():
        tau[saturated] = np.nan
        findings.append(
            DataFinding(
                'saturation', name, LEFT_OUT,
                f'the effort of joint {name} stays at its extreme in '
                f'{100.0 * found.saturated:.2g} % of the samples, which are left out: it is '
                'limited there, and no measurement',
            )
        )  # fmt: skip
    if 0.0 < limit.velocity < top:
        findings.append(
            DataFinding(
                'speed', name, NOTE,
                f'joint {name} moves at {top:.3g} {way}/s, faster than the {limit.velocity:.3g} '
                'its URDF allows',
            )
        )  # fmt: skip
    return found, tau, findings


def _refusal(
    name: str,
    way: str,
    unit: str,
    robot: Robot,
    i: int,
    q: FloatArray,
    tau: FloatArray,
    found: JointChecks,
) -> tuple[str, str] | None:
    """Return (check, sentence) if the joint cannot be fitted."""
    limit = robot.limits[i]
    wrong_unit = (
        'convert degrees to rad' if way == 'rad' else 'convert millimetres to m'
    ) + ' in the driver or the mapping, or correct the URDF'
    room = limit.upper - limit.lower
    outside = max(limit.lower - float(q.min()), float(q.max()) - limit.upper)
    if 0.0 < room < np.inf and outside > 0.5 * room:
        return 'position_unit', (
            f'joint {name} is at {q.min():.4g} to {q.max():.4g} where its URDF allows '
            f'{limit.lower:.4g} to {limit.upper:.4g} {way}: {wrong_unit}'
        )
    if limit.velocity > 0.0 and found.top_speed > _IMPOSSIBLE * limit.velocity:
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
    if moved <= _LEAST_MOTION_S:
        return 'no_motion', (
            f'joint {name} does not move while its effort is known (its range is '
            f'{found.travel:.3g} {way}): record motion in both directions at several speeds'
        )
    if len(known) and np.ptp(known) == 0.0:
        return 'constant_effort', (
            f'the effort of joint {name} is {known[0]:.4g} {unit} in every sample though it '
            'moves, so it is not measured: let the driver fill it'
        )
    if min(found.forwards_s, found.backwards_s) <= _LEAST_MOTION_S:
        side = 'forwards' if found.forwards_s > found.backwards_s else 'backwards'
        return 'one_direction', (
            f'joint {name} moves in one direction only ({side}, {moved:.3g} s), where friction '
            'cannot be told from gravity: record motion in both directions'
        )
    if np.isfinite(found.velocity_factor) and not (
        1.0 / _OTHER_UNIT < found.velocity_factor < _OTHER_UNIT
    ):
        return 'velocity_unit', (
            f'the velocity of joint {name} is {found.velocity_factor:.3g} times the slope of its '
            f'position: report it in {way}/s with the sign of the position, or leave it out'
        )
    level = found.friction_level
    if level < -3.0 * found.friction_level_error and -level > _FEIGNED * float(np.ptp(known)):
        return 'dissipation', (
            f'the effort of joint {name} is {-2.0 * level:.3g} {unit} smaller when it moves '
            'forwards than backwards, so friction would drive it: turn the sign of its effort, '
            'or of its position, in the driver or the mapping'
        )
    return None


def _saturated(tau: FloatArray, limit: float) -> NDArray[np.bool_]:
    """
    Return where effort is limited, (N,): runs of equal samples at an extreme.

    So many of them in a row that chance, from how often other neighbours are equal, does not make
    them; at the URDF's limit five are enough. Where most neighbours are equal anyway (a coarse or
    noise-free effort) only that limit tells.
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
        edges = np.flatnonzero(np.diff(at)) + 1
        for run in np.split(np.arange(len(tau)), edges):
            if at[run[0]] and len(run) >= fewest:
                result[run] = True
    return result


def _velocity_factor(
    reported: FloatArray, v: FloatArray, moving: NDArray[np.bool_], half: int
) -> float:
    """Return reported velocity over slope of position, each over a window, NaN if not told."""
    both = moving & np.isfinite(reported) & np.isfinite(v)
    if both.sum() < 2 * half:
        return np.nan
    # Noise of a differenced position is far above it: the mean over the window is not.
    mean = np.convolve(np.nan_to_num(reported), np.full(2 * half, 0.5 / half), mode='same')
    return float(mean[both] @ v[both] / (v[both] @ v[both]))


def _friction_level(
    log: JointLog, robot: Robot, i: int, v: FloatArray, tau: FloatArray, half: int
) -> tuple[float, float]:
    """
    Return the part of effort that is odd in velocity, at the median speed, and its error.

    Least squares of tau on the sign of velocity, its size beyond the median speed, acceleration,
    the model's gravity and a constant: an error of gravity or inertia then hardly counts as
    friction. The error is the jackknife over stretches of 1 s.
    """
    a = centred_difference(log.time, v, half)
    rows = np.flatnonzero(np.isfinite(a) & np.isfinite(v) & np.isfinite(tau))[:: max(1, half // 2)]
    groups = np.unique(log.time[rows].astype(np.int64), return_inverse=True)[1]
    if len(rows) < 20 or groups.max() < 3:
        return np.nan, np.nan
    sign = np.sign(v[rows])
    median = float(np.median(np.abs(v[rows])))
    g = np.array([robot.gravity(q)[i] for q in log.q[rows]])
    columns = [sign, v[rows] - sign * median, a[rows], g, np.ones(len(rows))]
    # One that does not vary is another's constant.
    X = np.column_stack([c for k, c in enumerate(columns) if k in (0, 4) or np.ptp(c) > 1e-9])
    norms = np.linalg.norm(X, axis=0)
    theta = np.linalg.lstsq(X / norms, tau[rows], rcond=1e-9)[0]
    errors = jackknife_errors(X / norms, tau[rows] - X / norms @ theta, groups)
    return float(theta[0] / norms[0]), float(errors[0] / norms[0])
