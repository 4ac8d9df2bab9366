# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the data themselves: looked at first, without a model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from sosml_friction.bags.even_stretches import even_stretches
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE, pauses_text
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import LEFT_OUT, NOTE, WARNING
from sosml_friction.identification.joint_checks import ZERO, check_each_joint
from sosml_friction.identification.joint_relations import Slopes
from sosml_friction.identification.swapped_joints import swapped_joints
from sosml_friction.model.robot import Robot
from sosml_friction.observers.signal_noise import signal_noise
from sosml_friction.regression.signals import Signals

#: Shares of samples lost that are named, and that make data useless. Halved and
#: doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
_SOME, _USELESS = 5e-3, 0.2
#: What becomes of samples that are lost.
_HOLES = (
    f'up to {HOLE - 1:g} lost samples in a row are bridged, and as many as half a period of the '
    'band has; more part the recording'
)
#: Velocity that lags by more than this, and than one sampling interval, is named [s].
_LAG = 1.5e-3
#: Effort in steps of more than this share of its standard deviation is called coarse, and nothing
#: else hangs on it: rounding is then a noise of 0.2 / sqrt(12) = 6 % of effort.
_COARSE = 0.2
#: A recorded velocity whose scale is below this share of the slope of position is something else.
_NO_VELOCITY = 0.2
#: A lag is named beyond this many standard errors, one-sided a chance of 3e-5 for each joint, and
#: this share of a sample: half-way between what is held, late by half of one, and the one before.
_ERRORS, _SAMPLES = 4.0, 0.75
#: Findings on a joint that matter here: their kind, and how bad they are if not a warning.
_KINDS = {
    'position_unit': ('position', 'bad'),
    ZERO: ('position', 'warning'),
    'wrap': ('position', 'warning'),
    'leaps': ('position', 'warning'),
    'velocity_unit': ('velocity', 'warning'),
    'rest': ('motion', 'bad'),
    'without_effort': ('effort', 'warning'),
    'constant_effort': ('effort', 'bad'),
    'effort_unit': ('effort', 'bad'),
    'lost_sign': ('effort', 'bad'),
    'exchanged': ('effort', 'bad'),
    'dissipation': ('effort', 'bad'),
    'saturation': ('effort', 'bad'),
}
#: Number of means from which the standard error is taken: errors within each may be correlated. So
#: many know it to 1 / sqrt(2 200) = 5 %.
_STRETCHES = 200


@dataclass(frozen=True)
class Check:
    """
    Hold one finding about the data.

    ``kind``: what it is about, such as dropped_samples, effort or tone; ``severity``: note,
    warning or bad; ``joint``: its name, or '*'; ``sentence`` for a person;
    ``values``: the numbers, SI units in their names. What is bad of one joint leaves out that
    joint, and the others go on.
    """

    kind: str
    severity: str
    joint: str
    sentence: str
    values: dict[str, float] = field(default_factory=dict)


def rest_left_out(shares: Mapping[str, float]) -> Check:
    """Return what share of the rows of each joint says nothing, as it rests there."""
    told = ', '.join(f'{100.0 * x:.0f} % of {name}' for name, x in shares.items() if x > 0.0)
    return Check(
        'rest',
        'warning',
        '*',
        'what joints take at rest is not friction of their last motion, and is left out'
        + (f': {told}' if told else ''),
    )


def check_log(clean: CleanSamples) -> list[Check]:
    """Return what samples, resolution and motion of a recording say, worst first."""
    log = clean.log
    checks = [_time_base(clean)]
    for finding in clean.findings:
        severity = 'note' if finding.level == NOTE else 'warning'
        checks.append(Check(finding.check, severity, finding.joint, finding.sentence))
    for i, name in enumerate(log.names):
        checks.append(_effort(log, i, name))
    order = {'bad': 0, 'warning': 1, 'note': 2}
    return sorted(checks, key=lambda check: order[check.severity])


def _time_base(clean: CleanSamples) -> Check:
    """Return how evenly samples came, and how many did not."""
    step, steps, lost = clean.period_s, clean.steps, clean.lost_share
    # A step of one and a half is a lost sample and no jitter.
    jitter = float(np.std(steps[steps < 1.5 * step]))
    values = {'step_s': step, 'jitter_s': jitter, 'lost_share': lost}
    apart = pauses_text(clean.log.time)
    if lost <= _SOME:
        sentence = f'{1.0 / step:.4g} samples per second, jitter {1e6 * jitter:.3g} us'
        sentence += f'; {apart}' if apart else ''
        return Check('time_base', 'note', '*', sentence, values)
    told = f'{100 * lost:.2g} % of the samples are lost'
    told += f', besides {apart}' if apart else ''
    if lost > _USELESS:
        return Check('dropped_samples', 'bad', '*', f'{told}: record again', values)
    return Check('dropped_samples', 'warning', '*', f'{told}; {_HOLES}', values)


def _effort(log: JointLog, i: int, name: str) -> Check:
    """Return whether a joint has effort, and how finely position and effort are resolved."""
    q, tau = log.q[:, i], log.tau[:, i]
    if not np.isfinite(tau).any():
        return Check('effort', 'bad', name, f'{name} has no effort: let its driver report one')
    size = float(np.nanstd(tau))
    quantum_q, noise_q = signal_noise(q)
    quantum, noise = signal_noise(tau)
    values = {
        'position_quantum': quantum_q,
        'position_noise': noise_q,
        'effort_quantum': quantum,
        'effort_noise': noise,
    }
    if quantum > _COARSE * max(size, 1e-300) and noise < quantum:
        sentence = (
            f'the effort of {name} has steps of {quantum:.3g}, a {size / quantum:.1f}th of its '
            'size: small causes are out of reach'
        )
        return Check('quantisation', 'warning', name, sentence, values)
    sentence = (
        f'{name}: position in steps of {quantum_q:.3g} with noise {noise_q:.2g}, effort in '
        f'steps of {quantum:.3g} with noise {noise:.2g}'
    )
    return Check('quantisation', 'note', name, sentence, values)


def check_joints(log: JointLog, robot: Robot) -> list[Check]:
    """
    Return what the relations between the columns of a recording say of each joint.

    What the fit says of them, but for what is a cause to the diagnosis, or no obstacle to it.
    """
    slopes = Slopes.of(log)
    checks = []
    if swapped := swapped_joints(log, robot, slopes):
        checks.append(Check('effort', 'bad', '*', swapped))
    for found, _, _, findings in check_each_joint(log, robot, slopes):
        for finding in findings:
            if finding.check == 'saturation' and finding.level == LEFT_OUT:
                # Holes at every peak would leave no stretch that is long enough.
                checks.append(_limited(finding.joint, found.saturated))
            elif finding.check in _KINDS:
                kind, severity = _KINDS[finding.check]
                if finding.level == WARNING:
                    severity = 'warning'
                # Wrong angles of one joint are wrong bodies of all.
                joint = '*' if finding.check == 'position_unit' else finding.joint
                checks.append(Check(kind, severity, joint, finding.sentence))
    return checks


def _limited(name: str, share: float) -> Check:
    """Return that the effort of a joint is no measurement for some of the time."""
    sentence = (
        f'the effort of {name} stays at its extreme in {100.0 * share:.2g} % of the samples: it '
        'is limited there and no measurement, which a cause may stand for; move more slowly, with '
        'less load, or raise the limit'
    )
    return Check('effort', 'warning', name, sentence, {'limited_share': share})


def without_bad(log: JointLog, checks: Sequence[Check]) -> JointLog:
    """Return a recording without the effort of the joints of which something is bad."""
    bad = {check.joint for check in checks if check.severity == 'bad'}
    if bad.isdisjoint(log.names):
        return log
    return replace(log, tau=np.where([name in bad for name in log.names], np.nan, log.tau))


def velocity_lag(log: JointLog, signals: Signals, i: int) -> Check | None:
    """
    Return how late the recorded velocity of a joint is beside the slope of its position.

    v_recorded(t) = v(t - lag) = v - lag v' + lag^2 v'' / 2, by least squares on v of the smoothed
    position, its steady acceleration and the slope of that; lag is minus the coefficient of v'
    over that of v. None where no velocity was recorded. It is no fault of the model: the diagnosis
    takes its velocity from position.
    """
    band = signals.band
    parts = even_stretches(log, band.cutoff)
    stretch = next((own for own in parts if len(own) == len(signals.q)), None)
    if stretch is None or not np.isfinite(stretch.v[:, i]).all():
        return None
    recorded = band.apply(stretch.v[:, i])
    v, a = band.apply(signals.v[:, i]), band.apply(signals.a[:, i])
    jerk = np.gradient(a, band.output_step)
    X = np.column_stack([v, a, jerk])
    size = np.linalg.norm(X, axis=0)
    if not (size > 0.0).all():
        return None
    beta, *_ = np.linalg.lstsq(X / size, recorded, rcond=None)
    coefficients = beta / size
    if abs(coefficients[0]) < _NO_VELOCITY:
        return None
    residual = recorded - X @ coefficients
    groups = uniform_filter1d(residual, max(1, len(residual) // _STRETCHES))
    spread = float(np.std(groups)) * np.sqrt(_STRETCHES)
    error = spread / float(size[1]) / abs(coefficients[0])
    lag = -float(coefficients[1] / coefficients[0])
    name = log.names[i]
    values = {'lag_s': lag, 'lag_std_error_s': error, 'scale': float(coefficients[0])}
    if lag > max(_LAG, _SAMPLES * band.step) and lag > _ERRORS * error:
        sentence = (
            f'the recorded velocity of {name} is {1e3 * lag:.1f} ms late; the diagnosis uses the '
            'slope of position instead'
        )
        return Check('velocity_lag', 'warning', name, sentence, values)
    sentence = f'the recorded velocity of {name} lags by {1e3 * lag:.2f} ms'
    return Check('velocity_lag', 'note', name, sentence, values)
