# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Each misprint of the paper against its correct form, and every number of docs/paper_errata.md.

The equations as printed are only here, in plain numpy; the package has the correct ones. Each
``@size(row, text)`` function computes the numbers of one row of the page; ``text`` is what the
page has to say with them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares
from scipy.signal import lfilter

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.robot import Robot
from sosml_friction.observers.kinds.first_order import FirstOrder
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.kinds.sosml_explicit import SosmlExplicit

REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / 'docs/paper_errata.md'

H = 1e-3
POSTURE = np.deg2rad([-50.0, 65.0])
L1, L2 = 0.30, 0.27
M1, M2 = 2.5, 1.8
ROTOR = np.array([0.012, 0.004])
GRAVITY = 9.81
TILT = np.deg2rad(20.0)
#: The study's friction: C, B, S, v_s of each joint, and the smoothing velocity v_0.
FRICTION = np.array([[0.80, 0.35, 0.50, 0.03], [0.40, 0.20, 0.25, 0.03]])
V0 = 0.005
#: The friction the paper reports for its shoulder: C, B, S, v_s, bias.
REPORTED = (0.26, 2.5e-3, 7.2, 2.5e-3, 0.43)
#: Sliding gains S1, T1 = 1.6 sqrt(S1), and the paper's boundary layer.
S1, T1, EPSILON = 400.0, 32.0, 1e-3
SET_UP = (
    'The robot is `urdf/exoskeleton.urdf` with rotors of {r1:g} and {r2:g} kg m2, sampled at '
    '{rate:.0f} kHz without noise. Friction is smooth over {v0:g} rad/s, with C, B, S, v_s of '
    '{0}, {1}, {2}, {3} (shoulder) and {4}, {5}, {6}, {7} (elbow), in Nm, rad, s. On the reversal '
    'the shoulder swings by 0.35 rad at 0.5 Hz and the elbow is held, in closed loop; on the '
    'motion of both joints the elbow swings as well, at 1 Hz. RMSE is of the last 4 s of 6. '
    'SOSML has S_1 = {s1:g}, T_1 = {t1:g}, T_2 = S_2 = 0 where nothing else is said.'
).format(*FRICTION.ravel(), r1=ROTOR[0], r2=ROTOR[1], rate=1e-3 / H, v0=V0, s1=S1, t1=T1)


def stribeck(w, C, B, S, vs, v0):
    """Equation (17) without bias; v0 = 0 is the sgn law."""
    sign = np.tanh(w / v0) if v0 > 0.0 else np.sign(w)
    return (C + S * np.exp(-np.abs(w) / vs)) * sign + B * w


@dataclass(frozen=True)
class Motion:
    """
    Exact signals at 1 kHz, (N, 2) each, with the friction that was in them.

    ``hold`` is the share of the effort at the end of an interval in its mean: 0 where the effort
    was held from its start.
    """

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    friction: np.ndarray
    p: np.ndarray
    C: np.ndarray
    g: np.ndarray
    hold: float

    @property
    def correct_drift(self) -> np.ndarray:
        """C^T q' - g."""
        return np.einsum('kji,kj->ki', self.C, self.v) - self.g

    def forcing(self, drift: np.ndarray | None = None) -> np.ndarray:
        """Mean of tau + drift over the interval that ends at each sample; row 0 unused."""
        drift = self.correct_drift if drift is None else drift
        u = np.full_like(self.tau, np.nan)
        u[1:] = (1.0 - self.hold) * self.tau[:-1] + self.hold * self.tau[1:]
        u[1:] += 0.5 * (drift[1:] + drift[:-1])
        return u


@dataclass(frozen=True)
class Study:
    """The study's robot; its reversal in closed loop; a prescribed motion of both joints."""

    robot: Robot
    drive: Callable[..., np.ndarray]
    reversal: Motion
    both: Motion

    def observe(self, observer, motion: Motion, drift: np.ndarray | None = None) -> np.ndarray:
        """tau_e at samples 1.. under the forcing tau + drift (correct unless given)."""
        return self.drive(observer, motion.p, motion.forcing(drift), H)


def rmse(error: np.ndarray) -> np.ndarray:
    """Per joint, of the last 4 s: whole periods, long after the start."""
    return np.sqrt(np.mean(error[-4000:] ** 2, axis=0))


def terms(robot: Robot, q, v, tau, friction, hold) -> Motion:
    p = np.array([robot.momentum_terms(*x)[0] for x in zip(q, v, strict=True)])
    C = np.array([robot.coriolis(*x) for x in zip(q, v, strict=True)])
    g = np.array([robot.gravity(x) for x in q])
    return Motion(q, v, tau, friction, p, C, g, hold)


@pytest.fixture(scope='module')
def study(two_joints: Robot, reversal_run: tuple[JointLog, np.ndarray], drive) -> Study:
    log, friction = reversal_run
    N = 6000
    truth = np.stack([stribeck(log.v[:, i], *FRICTION[i], V0) for i in range(2)], axis=1)
    np.testing.assert_allclose(friction, truth, atol=1e-12)
    reversal = terms(two_joints, log.q[:N], log.v[:N], log.tau[:N], friction[:N], 0.0)
    # Both joints, peak speeds 1.1 and 1.8 rad/s: effort from inverse dynamics, no controller.
    t = np.arange(N)[:, None] * H
    w, top = np.array([np.pi, 2.0 * np.pi]), np.array([0.35 * np.pi, 1.8])
    q, v = POSTURE + top / w * np.sin(w * t), top * np.cos(w * t)
    a = -top * w * np.sin(w * t)
    friction = np.stack([stribeck(v[:, i], *FRICTION[i], V0) for i in range(2)], axis=1)
    tau = np.array([two_joints.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)]) + friction
    return Study(two_joints, drive, reversal, terms(two_joints, q, v, tau, friction, 0.5))


@dataclass(frozen=True)
class Size:
    text: str
    values: Callable[[Study], dict[str, float]]


SIZES: dict[str, Size] = {}


def size(row: str, text: str):
    """Register what computes the numbers of a row, and the words they come in."""

    def keep(values):
        SIZES[row] = Size(text, values)
        return values

    return keep


@pytest.fixture(scope='module')
def sizes(study: Study) -> dict[str, dict[str, float]]:
    return {row: entry.values(study) for row, entry in SIZES.items()}


def implicit_sosml(s1=S1, t1=T1, n=2) -> Sosml:
    gains = {'sliding': s1, 'sliding_root': t1, 'linear': 0.0, 'linear_damping': 0.0}
    return Sosml({name: [value] * n for name, value in gains.items()})


# ---- (1)-(3): inverse kinematics ----


def hand(q: np.ndarray) -> np.ndarray:
    """(1) in the local plane: (x', y')."""
    q1, q12 = q[..., 0], q[..., 0] + q[..., 1]
    x = L1 * np.cos(q1) + L2 * np.cos(q12)
    return np.stack([x, L1 * np.sin(q1) + L2 * np.sin(q12)], axis=-1)


def joint_angles(xy: np.ndarray, elbow: np.ndarray, arctangent) -> np.ndarray:
    """(3) with the elbow's sign given; NaN out of reach."""
    x, y = xy[..., 0], xy[..., 1]
    cosine = (x**2 + y**2 - L1**2 - L2**2) / (2 * L1 * L2)
    within = np.abs(cosine) <= 1.0 + 1e-12
    q2 = elbow * np.arccos(np.where(within, np.clip(cosine, -1.0, 1.0), np.nan))
    q1 = arctangent(y, x) - arctangent(L2 * np.sin(q2), L1 + L2 * np.cos(q2))
    return np.stack([q1, q2], axis=-1)


def of_the_quotient(y, x):
    return np.arctan(y / x)


def posture_grid(robot: Robot) -> np.ndarray:
    """300 x 300 postures in the middle of equal cells between the URDF's limits."""
    shares = (np.arange(300) + 0.5) / 300
    axes = [limit.lower + (limit.upper - limit.lower) * shares for limit in robot.limits]
    return np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 2)


@size(
    '(1)-(3)',
    'in {percent:.0f} % of the postures between the limits of the URDF the hand lands on the '
    'wrong side of the shoulder, up to {farthest:.2f} m away; at (-50, 65) deg the other elbow is '
    '{shoulder:.0f} and {elbow:.0f} deg away; beyond {reach:.2f} m there is no answer',
)
def inverse_kinematics(study):
    q = posture_grid(study.robot)
    xy = hand(q)
    miss = np.linalg.norm(hand(joint_angles(xy, np.sign(q[:, 1]), of_the_quotient)) - xy, axis=1)
    other = joint_angles(hand(POSTURE), -1.0, np.arctan2)
    shoulder, elbow = np.rad2deg(np.abs(other - POSTURE))
    return {
        'percent': 100.0 * np.mean(miss > 1e-6),
        'farthest': miss.max(),
        'shoulder': shoulder,
        'elbow': elbow,
        'reach': L1 + L2,
    }


def test_an_arctangent_of_the_quotient_loses_the_quadrant(study, sizes):
    """It is wrong exactly where x' < 0, by 2 |p|; atan2 is right everywhere."""
    q = posture_grid(study.robot)
    xy = hand(q)
    back = joint_angles(xy, np.sign(q[:, 1]), np.arctan2)
    # acos near the stretched arm turns rounding 1e-16 into its root, 1e-8.
    np.testing.assert_allclose(np.remainder(back - q + np.pi, 2 * np.pi), np.pi, atol=1e-6)
    behind = xy[:, 0] < 0.0
    found = sizes['(1)-(3)']
    assert found['percent'] == 100.0 * behind.mean() > 0.0
    assert found['farthest'] == pytest.approx(2 * np.linalg.norm(xy[behind], axis=1).max())
    # The second arctangent is harmless while the upper arm is the longer link.
    assert np.all(L1 + L2 * np.cos(q[:, 1]) > 0.0)


def test_the_cosine_of_the_elbow_has_two_angles_or_none(sizes):
    p = hand(POSTURE)
    for elbow in (1.0, -1.0):
        np.testing.assert_allclose(hand(joint_angles(p, elbow, np.arctan2)), p, atol=1e-12)
    found = sizes['(1)-(3)']
    # Mirroring the arm about the line to the hand turns the elbow by 2 q2.
    assert found['elbow'] == pytest.approx(130.0, abs=1e-9)
    outside = np.array([found['reach'] + 1e-6, 0.0])
    assert np.isnan(joint_angles(outside, 1.0, np.arctan2)).all()
    assert np.isnan(joint_angles(np.array([L1 - L2 - 1e-6, 0.0]), 1.0, np.arctan2)).all()


# ---- (6)-(8): gravity and friction in the dynamics ----


def rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


@size(
    '(6)',
    '{z:.2f} m/s^2 in z between the operator and the result; {torque:.2f} Nm at the joints of '
    'this arm, whose plane z leaves',
)
def gravity_vector(study):
    operator = rotation_x(TILT) @ [0.0, -GRAVITY, 0.0]
    result = np.array([0.0, -GRAVITY * np.cos(TILT), GRAVITY * np.sin(TILT)])
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    angle = f'{np.pi / 2 - TILT:.16f}'
    assert angle in urdf
    other_way = urdf.replace(angle, f'{np.pi / 2 + TILT:.16f}')
    tipped = Robot(other_way, study.robot.names, [0.0, 0.0])
    return {
        'z': np.abs(operator - result)[2],
        'torque': max(
            np.abs(tipped.gravity(q) - study.robot.gravity(q)).max()
            for q in posture_grid(study.robot)[::997]
        ),
    }


def test_the_printed_gravity_vector_is_the_inverse_rotation(sizes):
    """The result printed is R_x(-20), which (2) calls world to local; R_x(+20) has -z."""
    result = np.array([0.0, -GRAVITY * np.cos(TILT), GRAVITY * np.sin(TILT)])
    np.testing.assert_allclose(rotation_x(-TILT) @ [0.0, -GRAVITY, 0.0], result, atol=1e-15)
    operator = rotation_x(TILT) @ [0.0, -GRAVITY, 0.0]
    np.testing.assert_allclose(operator * [1, 1, -1], result, atol=1e-15)
    assert sizes['(6)']['z'] == pytest.approx(2 * GRAVITY * np.sin(TILT), abs=1e-12)
    # Rounding of two Pinocchio models.
    assert sizes['(6)']['torque'] < 1e-12


def potential(q: np.ndarray, printed: bool) -> float:
    """(7) as printed with cos, or with sin: the height of (1)."""
    f = np.cos if printed else np.sin
    q1, q12 = q[0], q[0] + q[1]
    arms = M1 * L1 / 2 * f(q1) + M2 * (L1 * f(q1) + L2 / 2 * f(q12))
    return float(GRAVITY * arms * np.cos(TILT))


def kinetic(q: np.ndarray, v: np.ndarray) -> float:
    """(5)."""
    v12, q12 = v.sum(), q.sum()
    x = -L1 * v[0] * np.sin(q[0]) - L2 / 2 * v12 * np.sin(q12)
    y = L1 * v[0] * np.cos(q[0]) + L2 / 2 * v12 * np.cos(q12)
    first = (M1 * L1**2 / 12 + M1 * (L1 / 2) ** 2) * v[0] ** 2
    return float(0.5 * (first + M2 * L2**2 / 12 * v12**2 + M2 * (x**2 + y**2)))


def gravity_of_7(q: np.ndarray, printed: bool) -> np.ndarray:
    step = 1e-3 * np.eye(2)
    # Fourth order: its error is step^4 / 30 of the fifth derivative, 3e-13 Nm.
    return np.array(
        [
            8 * (potential(q + e, printed) - potential(q - e, printed))
            - (potential(q + 2 * e, printed) - potential(q - 2 * e, printed))
            for e in step
        ]
    ) / (12e-3)


@size(
    '(7)',
    'at (-50, 65) deg G changes by ({shoulder:+.2f}, {elbow:+.2f}) Nm, {shoulder_ratio:.1f} and '
    '{elbow_ratio:.1f} times the Coulomb friction there, and the friction estimate by as much '
    'the other way',
)
def potential_energy(study):
    change = gravity_of_7(POSTURE, True) - study.robot.gravity(POSTURE)
    ratio = np.abs(change) / FRICTION[:, 0]
    return {
        'shoulder': change[0],
        'elbow': change[1],
        'shoulder_ratio': ratio[0],
        'elbow_ratio': ratio[1],
    }


def test_potential_energy_needs_the_sine(study, sizes):
    """With sin, (5) and (7) make the energy of the URDF, whose axes are those of (1)."""
    here = study.robot.energy(POSTURE, np.zeros(2)) - potential(POSTURE, False)
    rng = np.random.default_rng(0)
    for q in posture_grid(study.robot)[::997]:
        v = rng.normal(size=2)
        ours = kinetic(q, v) + 0.5 * ROTOR @ v**2 + potential(q, False)
        assert study.robot.energy(q, v) == pytest.approx(here + ours, abs=1e-12)
        np.testing.assert_allclose(study.robot.gravity(q), gravity_of_7(q, False), atol=1e-10)
    g1, g2 = GRAVITY * np.cos(TILT) * np.array([M1 * L1 / 2 + M2 * L1, M2 * L2 / 2])
    second = -g2 * (np.sin(POSTURE.sum()) + np.cos(POSTURE.sum()))
    first = -g1 * (np.sin(POSTURE[0]) + np.cos(POSTURE[0])) + second
    change = [sizes['(7)'][joint] for joint in ('shoulder', 'elbow')]
    np.testing.assert_allclose(change, [first, second], atol=1e-10)


def test_a_gravity_error_goes_straight_into_the_friction_estimate(study):
    """Of any observer: tau_e moves by G_printed - G, tau_f by the opposite."""
    m = study.reversal
    printed = np.array([gravity_of_7(q, True) for q in m.q])
    right = study.observe(implicit_sosml(), m)
    wrong = study.observe(implicit_sosml(), m, m.correct_drift + m.g - printed)
    moved = (wrong - right)[-4000:].mean(axis=0)
    # Means over two periods: what is left is the estimate's own lag, well below 1 mNm.
    np.testing.assert_allclose(moved, (printed - m.g)[-4000:].mean(axis=0), atol=1e-3)


@size(
    '(8)',
    'tau_e taken for friction without the minus sign: RMSE {without:.2f} Nm on the reversal, '
    'twice the friction itself ({friction:.2f} Nm rms); with it {right:.0f} mNm',
)
def sign_of_friction(study):
    m = study.reversal
    tau_e = study.observe(implicit_sosml(), m)
    tau_f = m.friction[1:]
    return {
        'without': rmse(tau_e - tau_f)[0],
        'friction': rmse(tau_f)[0],
        'right': 1e3 * rmse(-tau_e - tau_f)[0],
    }


def test_the_disturbance_is_minus_the_friction(study, sizes):
    m, found = study.reversal, sizes['(8)']
    # (8) without friction cannot hold: its torque is short of the actuator's by the friction.
    a = np.gradient(m.v, H, axis=0)
    short = m.tau - np.array(
        [study.robot.inverse_dynamics(*x) for x in zip(m.q, m.v, a, strict=True)]
    )
    steady = np.abs(m.v[:, 0]) > 0.8
    steady[:2000] = False
    # Central difference and the held torque leave 10 mNm where friction varies slowly.
    np.testing.assert_allclose(short[steady, 0], m.friction[steady, 0], atol=0.02)
    assert found['right'] < 12.0
    # |2 x + e|, e of the size of the right estimate's error.
    assert found['without'] == pytest.approx(2 * found['friction'], abs=1e-3 * found['right'])


# ---- (10), (17): friction laws ----

LADDER = np.geomspace(0.01, 0.7, 30)
FAST_LADDER = np.linspace(0.05, 0.7, 14)


def fit(model, start, lower, y):
    """Least squares within bounds; parameters and the largest residual."""
    found = least_squares(
        lambda x: model(x) - y, start, bounds=(lower, 10.0), xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    return found.x, np.abs(found.fun).max()


@size(
    '(10)',
    "the shoulder's friction at {speeds} speeds of {slowest:g} to {fastest:g} rad/s, fitted with "
    'S >= C: breakaway {forced:.2f} Nm for {true:.2f}, lambda {vs:.3f} rad/s for {vs_true:.3f}, '
    'residual up to {residual:.0f} mNm; fitted with alpha = 2 for 1 at {slowest2:g} to '
    '{fastest2:g} rad/s: S {S2:.2f} Nm for {S:.2f}, and a residual of {residual2:.1f} mNm at most',
)
def additive_stribeck(study):
    w, (C, B, S, vs) = LADDER, FRICTION[0]
    # x[2] = S - C, so that its bound at 0 is S >= C.
    x, residual = fit(
        lambda x: x[0] + x[1] * w + (x[0] + x[2]) * np.exp(-w / x[3]),
        [0.7, 0.3, 0.1, 0.03],
        [0.0, 0.0, 0.0, 1e-4],
        stribeck(w, C, B, S, vs, 0.0),
    )
    w = FAST_LADDER
    x2, residual2 = fit(
        lambda x: x[0] + x[1] * w + x[2] * np.exp(-((w / x[3]) ** 2)),
        [0.8, 0.35, 0.5, 0.05],
        [0.0, 0.0, 0.0, 1e-4],
        stribeck(w, C, B, S, vs, 0.0),
    )
    return {
        'true': C + S,
        'speeds': len(LADDER),
        'slowest': LADDER[0],
        'fastest': LADDER[-1],
        'forced': 2 * x[0] + x[2],
        'vs': x[3],
        'vs_true': vs,
        'residual': 1e3 * residual,
        'slowest2': w[0],
        'fastest2': w[-1],
        'S': S,
        'S2': x2[2],
        'residual2': 1e3 * residual2,
    }


def test_an_additive_stribeck_amplitude_may_be_below_coulomb(sizes):
    """Free, the fit is exact; with S >= C the bound is active and breakaway is at least 2 C."""
    w, truth = LADDER, FRICTION[0]
    y = stribeck(w, *truth, 0.0)
    x, residual = fit(
        lambda x: x[0] + x[1] * w + x[2] * np.exp(-w / x[3]),
        [0.7, 0.3, 0.6, 0.05],
        [0.0, 0.0, 0.0, 1e-4],
        y,
    )
    np.testing.assert_allclose(x, truth, rtol=1e-6)
    assert residual < 1e-9
    found = sizes['(10)']
    assert found['residual'] > 50.0
    assert found['forced'] > 2 * truth[0] > found['true']
    # The static level F_s of C + (F_s - C) exp(...) does obey F_s >= C: what (10) has in mind.
    np.testing.assert_allclose(
        truth[0] + truth[1] * w + (found['true'] - truth[0]) * np.exp(-w / truth[3]), y, atol=1e-15
    )
    # lambda = 0 is no law: 0/0 at rest.
    with np.errstate(invalid='ignore'):
        assert np.isnan(stribeck(np.float64(0.0), 0.8, 0.35, 0.5, np.float64(0.0), V0))


def test_the_exponent_alpha_is_not_separable_from_amplitude_and_velocity(sizes):
    """Two very different laws differ by less than 2 mNm at every speed from 0.05 rad/s on."""
    found = sizes['(10)']
    assert found['residual2'] < 2.0
    assert found['S2'] < 0.4 * FRICTION[0, 2]


@size(
    '(17)',
    'the sgn law fitted to friction that is smooth over {v0:g} rad/s: S wrong by {from_2:+.0f} '
    'mNm of {S:.0f} with speeds from 2 v_0 on, {from_4:+.1f} from 4 v_0 on; an offset of 0.10 Nm '
    'in gravity comes out as bias {bias:.3f} Nm',
)
def sign_law(study):
    truth = FRICTION[0]

    def fitted(lowest, offset):
        w = np.geomspace(lowest, 0.7, 30)
        w = np.concatenate([-w[::-1], w])
        return fit(
            lambda x: stribeck(w, *x[:4], 0.0) + x[4],
            [*truth, 0.0],
            [0.0, 0.0, 0.0, 1e-4, -1.0],
            stribeck(w, *truth, V0) + offset,
        )[0]

    return {
        'v0': V0,
        'S': 1e3 * truth[2],
        'from_2': 1e3 * (fitted(2 * V0, 0.0)[2] - truth[2]),
        'from_4': 1e3 * (fitted(4 * V0, 0.0)[2] - truth[2]),
        'bias': fitted(2 * V0, 0.10)[4],
    }


def test_the_sign_law_bends_the_knee_of_a_smooth_friction(sizes):
    """At 2 v_0 friction is 3.6 % below sgn's, at 4 v_0 0.07 %: the fit takes it from S."""
    found = sizes['(17)']
    assert found['from_2'] < -20.0
    assert -0.1 * abs(found['from_2']) < found['from_4'] < 0.0
    # Speeds come in pairs of both signs: the odd law and the constant are orthogonal.
    assert found['bias'] == pytest.approx(0.10, abs=1e-9)


# ---- (11)-(12): first-order observer ----


@size(
    '(11)',
    'both joints at up to 1.1 and 1.8 rad/s, FO with c_0 = {c0:g} 1/s, elbow: RMSE {right:.0f} '
    "mNm, {none:.0f} without the Coriolis term (up to {peak:.2f} Nm), {wrong:.0f} with C q'",
)
def coriolis_in_fo(study):
    m, c0 = study.both, 300.0
    right = m.correct_drift

    def elbow(drift):
        tau_e = study.observe(FirstOrder({'cutoff': [c0, c0]}), m, drift)
        return 1e3 * rmse(tau_e + m.friction[1:])[1]

    return {
        'c0': c0,
        'right': elbow(right),
        'none': elbow(-m.g),
        'wrong': elbow(np.einsum('kij,kj->ki', m.C, m.v) - m.g),
        'peak': np.abs(right + m.g)[:, 1].max(),
    }


def test_the_coriolis_term_of_11_is_a_matrix_until_it_meets_the_velocity(study, sizes):
    C, g = study.both.C[0], study.both.g[0]
    # numpy (and MATLAB) broadcast it without a word; tau is then not a torque per joint.
    assert (C - g).shape == (2, 2)
    found, m = sizes['(11)'], study.both
    # What is left out is filtered like the disturbance; with C q' its negative comes on top.
    v1, v2 = m.v.T
    h = M2 * L1 * L2 / 2 * np.sin(m.q[:, 1])
    np.testing.assert_allclose((m.correct_drift + m.g)[:, 1], -h * v1 * (v1 + v2), atol=1e-12)
    np.testing.assert_allclose((m.correct_drift + m.g)[:, 0], 0.0, atol=1e-12)
    a = np.exp(-found['c0'] * H)
    fo = study.observe(FirstOrder({'cutoff': [found['c0']] * 2}), m)
    left_out = 0.5 * (-h * v1 * (v1 + v2))
    leak = lfilter([1 - a], [1, -a], left_out[1:] + left_out[:-1])
    error = fo[:, 1] + m.friction[1:, 1] + leak
    assert found['none'] == pytest.approx(1e3 * rmse(error[:, None])[0], rel=1e-9)
    assert found['right'] < found['none'] < found['wrong']


def fo_of_12(p, u, c0, ratio):
    """(11)-(12) with k0 = ratio c0, exact for forcing and p' constant over an interval."""
    a = np.exp(-c0 * H)
    return lfilter([1 - a], [1, -a], ratio * np.diff(p, axis=0) / H - u[1:], axis=0)


@size(
    '(12)',
    'shoulder on the reversal, c_0 = {c0:g} 1/s: RMSE {k10:.0f} mNm with k_0 = c_0, {k12:.0f} '
    'with 1.2 c_0, {k20:.0f} with 2 c_0',
)
def two_gains(study):
    m, c0 = study.reversal, 40.0
    u, tau_e = m.forcing(), -m.friction[1:]
    k10, k12, k20 = (
        1e3 * rmse(fo_of_12(m.p, u, c0, ratio) - tau_e)[0] for ratio in (1.0, 1.2, 2.0)
    )
    return {'c0': c0, 'k10': k10, 'k12': k12, 'k20': k20}


def test_a_second_gain_of_fo_leaks_the_momentum_rate(study, sizes):
    """tau_e = c0/(s+c0) tau_e + (k0 - c0)/c0 c0/(s+c0) p', against the literal state z."""
    m, c0 = study.reversal, sizes['(12)']['c0']
    u, dp, a = m.forcing(), np.diff(m.p, axis=0) / H, np.exp(-c0 * H)
    fo = study.observe(FirstOrder({'cutoff': [c0, c0]}), m)
    for ratio, key in ((1.0, 'k10'), (1.2, 'k12'), (2.0, 'k20')):
        k0, z, literal = ratio * c0, ratio * c0 * m.p[0], np.empty_like(fo)
        for k in range(len(fo)):
            # z' = -c0 z + c0 (k0 p + u) with p linear over the interval, solved exactly.
            p, slope = m.p[k], dp[k]
            bend = k0 * slope * (H - (1 - a) / c0)
            z = a * z + (1 - a) * (k0 * p + u[k + 1]) + bend
            literal[k] = k0 * m.p[k + 1] - z
        leak = (ratio - 1.0) * lfilter([1 - a], [1, -a], dp, axis=0)
        # Rounding of 6000 steps.
        np.testing.assert_allclose(literal, fo + leak, atol=1e-9)
        assert sizes['(12)'][key] == pytest.approx(
            1e3 * rmse(fo + leak + m.friction[1:])[0], rel=1e-9
        )


@pytest.mark.parametrize('ratio', [0.5, 1.0, 2.0])
def test_a_constant_disturbance_hides_the_wrong_gain(ratio):
    """At a constant speed p' = 0 and any k0 gives the disturbance: a plateau shows nothing."""
    p, u = np.full((2000, 1), 0.3), np.full((2000, 1), 1.5)
    # 80 time constants.
    assert fo_of_12(p, u, 40.0, ratio)[-1, 0] == pytest.approx(-1.5, abs=1e-12)


# ---- (14)-(16): sliding observer ----


def explicit_sosml(t2, n=2) -> SosmlExplicit:
    gains = {
        'sliding': S1,
        'sliding_root': T1,
        'linear': 0.0,
        'linear_damping': t2,
        'boundary': EPSILON,
    }
    return SosmlExplicit({name: [value] * n for name, value in gains.items()})


def swing(drive, t2):
    """Of the last second of 4 s under a disturbance of 1 Nm that is constant from the start."""
    estimate = drive(explicit_sosml(t2, 1), H * np.arange(4000), np.zeros(4000), H)
    return np.ptp(estimate[-1000:])


@size(
    '(14)+(15) damping',
    'explicit, eps = {eps:g}: under a constant 1 Nm the estimate swings '
    'by {swing:.2f} Nm for ever; damping ratio {zeta:.2f} at T_2 = {light:g} 1/s; no swing needs '
    'T_2 > {needed:.0f} 1/s; RMSE on the reversal {explicit:.0f} mNm, {damped:.0f} with T_2 = '
    '{heavy:g}, {implicit:.0f} implicit',
)
def boundary_layer(study):
    m, stiffness, light, heavy = study.reversal, S1 / EPSILON, 40.0, 500.0

    def error(observer):
        return 1e3 * rmse(study.observe(observer, m) + m.friction[1:])[0]

    return {
        'eps': EPSILON,
        'swing': swing(study.drive, 0.0),
        'zeta': light / (2 * np.sqrt(stiffness)),
        'light': light,
        'needed': H * stiffness,
        'explicit': error(explicit_sosml(0.0)),
        'damped': error(explicit_sosml(heavy)),
        'heavy': heavy,
        'implicit': error(implicit_sosml()),
    }


def euler_matrix(t2, stiffness, h):
    """(e, sigma - tau_e) over one explicit step inside the boundary layer, T1 without slope."""
    return np.array([[1.0 - h * t2, h], [-h * stiffness, 1.0]])


@pytest.mark.parametrize('s2', [0.0, 5000.0])
def test_inside_the_boundary_layer_only_t2_damps(s2):
    """Slope of sqrt|e| s_eps(e) at 0 is 0; zeta and the bound on T2 against eigenvalues."""
    e = 1e-12
    assert np.sqrt(e) * np.clip(e / EPSILON, -1, 1) / e < 1e-2
    stiffness = S1 / EPSILON + s2
    for t2 in (0.0, 40.0, 700.0):
        roots = np.roots([1.0, t2, stiffness])
        assert -roots[0].real / abs(roots[0]) == pytest.approx(
            t2 / (2 * np.sqrt(stiffness)), abs=1e-12
        )
    needed, most = H * stiffness, 2.0 / H + H * stiffness / 2.0
    for t2, stable in (
        (0.0, False),
        (0.99 * needed, False),
        (1.01 * needed, True),
        (0.99 * most, True),
        (1.01 * most, False),
    ):
        radius = np.abs(np.linalg.eigvals(euler_matrix(t2, stiffness, H))).max()
        assert (radius < 1.0) == stable


def test_the_explicit_observer_cycles_below_the_bound_and_the_implicit_one_never(study, sizes):
    found = sizes['(14)+(15) damping']
    assert found['swing'] > 0.1
    # Just above the bound each step takes off h (T2 - h k) / 2 only: 100 1/s above, 3 s are ample.
    assert swing(study.drive, 0.75 * found['needed']) > 1e-3
    assert swing(study.drive, found['needed'] + 100.0) < 1e-9
    p = H * np.arange(4000)
    tail = study.drive(implicit_sosml(n=1), p, np.zeros(4000), H)[-1000:]
    # Rounding of p over h.
    np.testing.assert_allclose(tail, 1.0, atol=1e-10)
    assert found['implicit'] < 12.0 < found['damped'] < found['explicit']


def literal_15(u, s1, t1, s2, t2, epsilon):
    """(15) as printed, d(p~)/dt on the left: p~ is a state of its own, p is not an argument."""
    e, sigma, estimate = 0.0, 0.0, np.empty(len(u) - 1)
    for k in range(1, len(u)):
        sign = np.clip(e / epsilon, -1.0, 1.0)
        rate = u[k] + sigma - t1 * np.sqrt(abs(e)) * sign - t2 * e
        e, sigma = e + H * rate, sigma - H * (s1 * sign + s2 * e)
        estimate[k - 1] = sigma
    return estimate


@size(
    '(15) left side',
    "shoulder on the reversal, T_2 = {t2:g} 1/s: RMSE {error:.2f} Nm, the rms of p' "
    '({inertial:.2f} Nm), for a friction of {friction:.2f} Nm rms',
)
def left_side(study):
    m = study.reversal
    t2 = 500.0
    estimate = literal_15(m.forcing()[:, 0], S1, T1, 0.0, t2, EPSILON)
    return {
        't2': t2,
        'error': rmse(estimate[:, None] + m.friction[1:, :1])[0],
        'inertial': rmse(np.diff(m.p[:, :1], axis=0) / H)[0],
        'friction': rmse(m.friction[1:, :1])[0],
    }


def test_with_p_tilde_on_the_left_the_observer_never_sees_the_momentum(study, sizes):
    """It converges to -(tau + C^T q' - g) = tau_e - p': wrong by the inertial torque."""
    # Constant inputs: the fixed point, to rounding after 100 time constants.
    u = np.full(5000, 3.0)
    estimate = literal_15(u, S1, T1, 0.0, 500.0, EPSILON)
    assert estimate[-1] == pytest.approx(-3.0, abs=1e-9)
    # The reversal: tau_e - p' up to the observer's lag, which is that of the correct form.
    m, found = study.reversal, sizes['(15) left side']
    u = m.forcing()[:, 0]
    estimate = literal_15(u, S1, T1, 0.0, 500.0, EPSILON)
    lag = rmse((estimate + u[1:])[:, None])[0]
    assert lag < 0.1 * found['error']
    assert found['error'] == pytest.approx(found['inertial'], abs=lag)


@size(
    '(15) Coriolis',
    'at (-50, 65) deg and (1.1, 1.8) rad/s the forcing is wrong by ({shoulder:+.2f}, '
    '{elbow:+.2f}) Nm; both joints at up to those speeds, implicit SOSML: RMSE {right_1:.0f} -> '
    '{wrong_1:.0f} mNm (shoulder), {right_2:.0f} -> {wrong_2:.0f} (elbow)',
)
def coriolis_transposed(study):
    v, m = np.array([1.1, 1.8]), study.both
    C = study.robot.coriolis(POSTURE, v)
    shoulder, elbow = C @ v - C.T @ v
    wrong_drift = np.einsum('kij,kj->ki', m.C, m.v) - m.g
    right, wrong = (
        1e3 * rmse(study.observe(implicit_sosml(), m, drift) + m.friction[1:])
        for drift in (None, wrong_drift)
    )
    return {
        'shoulder': shoulder,
        'elbow': elbow,
        'right_1': right[0],
        'wrong_1': wrong[0],
        'right_2': right[1],
        'wrong_2': wrong[1],
    }


def test_the_momentum_rate_needs_the_transpose_of_the_coriolis_matrix(study, sizes):
    """p' = tau + C^T q' - g - tau_f, by differences of p along an exact motion."""
    m = study.both
    net = m.tau - m.friction
    dp = (m.p[2:] - m.p[:-2]) / (2 * H)
    right = net + m.correct_drift
    wrong = net + np.einsum('kij,kj->ki', m.C, m.v) - m.g
    # Central difference: h^2 / 6 of the third derivative of p, (4 pi)^3 .4 Nm s / s^3 at most.
    np.testing.assert_allclose(dp, right[1:-1], atol=2e-4)
    assert np.abs(dp - wrong[1:-1]).max() > 0.4
    # With h = -m2 l1 c2 sin(q2): C^T q' - C q' = h (-(2 v1 + v2) v2, (2 v1 + v2) v1).
    h, found = -M2 * L1 * L2 / 2 * np.sin(POSTURE[1]), sizes['(15) Coriolis']
    assert found['shoulder'] == pytest.approx(h * (2 * 1.1 + 1.8) * 1.8, abs=1e-12)
    assert found['elbow'] == pytest.approx(-h * (2 * 1.1 + 1.8) * 1.1, abs=1e-12)
    assert found['wrong_1'] > 4 * found['right_1']
    assert found['wrong_2'] > 4 * found['right_2']


@size(
    '(16)',
    'smooth friction (over {v0:g} rad/s) on a reversal of 0.35 rad, 0.5 Hz, needs S_1 > '
    '{needed:.0f} Nm/s, sgn friction has no bound; a jump of {jump:.1f} Nm at S_1 = {s1:g} Nm/s '
    'takes {reached:.0f} ms to reach (D / S_1 = {least:.0f} ms)',
)
def slope_of_friction(study):
    C, B, S, _ = FRICTION[0]
    jump, s1 = 2 * (C + S), 20.0
    n, at = 2000, 1000
    d = np.where(np.arange(n) < at, -jump / 2, jump / 2)
    observer = implicit_sosml(s1, 1.6 * np.sqrt(s1), 1)
    estimate = study.drive(observer, H * np.cumsum(d), np.zeros(n), H)
    # Row k of the estimate is at the end of interval k + 1; interval `at` is the first after.
    rows = np.flatnonzero(estimate[at - 1 :] >= jump / 2 - 1e-9)
    return {
        'v0': V0,
        'needed': ((C + S) / V0 + B) * 0.35 * np.pi**2,
        'jump': jump,
        's1': s1,
        'reached': 1e3 * H * (rows[0] + 1),
        'least': 1e3 * jump / s1,
    }


def test_no_gain_bounds_the_slope_of_sign_friction(study, sizes):
    """The slope at a reversal is (C + S) / v_0 times the acceleration: as v_0 -> 0, any value."""
    found = sizes['(16)']
    t = np.linspace(0.499, 0.501, 20_001)
    for v0, scale in ((V0, 1.0), (V0 / 10, 10.0)):
        torque = stribeck(0.35 * np.pi * np.cos(np.pi * t), *FRICTION[0], v0)
        slope = np.abs(np.gradient(torque, t)).max()
        # Grid of 0.1 us; B adds the same to both and is 0.1 %.
        assert slope == pytest.approx(scale * found['needed'], rel=2e-3)


def test_a_jump_of_friction_takes_the_sliding_observer_its_size_over_s1(study, sizes):
    """|sigma'| <= S1 where S2 = 0; reached on the way there, within one sample."""
    found = sizes['(16)']
    assert found['least'] - 1e-6 <= found['reached'] <= found['least'] + 1e3 * H + 1e-6


# ---- the reported parameters ----


def reported_torque(w):
    C, B, S, vs, bias = REPORTED
    return stribeck(w, C, B, S, vs, 0.0) + bias


@size(
    'reported C, B, bias',
    "the joint is driven at -q' between {low:.2g} and {high:.0f} rad/s, by up to {most:.2f} Nm",
)
def not_dissipative(study):
    _, B, S, vs, _ = REPORTED
    # tau_f(-w) is greatest where its slope is 0, with one root on either side.
    top = vs * np.log(S / (vs * B))
    return {
        'low': brentq(lambda w: reported_torque(-w), 1e-9, top),
        'high': brentq(lambda w: reported_torque(-w), top, 1e3),
        'most': reported_torque(-top),
    }


def test_the_reported_friction_drives_the_joint(sizes):
    """tau_f q' < 0, over nearly the whole range of speeds in one direction, in none without it."""
    found = sizes['reported C, B, bias']
    C, B, S, vs, bias = REPORTED
    # Without the other's term, which is 1e-4 of the sum at most: closed forms of the two roots.
    assert found['low'] == pytest.approx(vs * np.log(S / (bias - C)), rel=1e-3)
    assert found['high'] == pytest.approx((bias - C) / B, rel=1e-9)
    named = dict(
        zip(('coulomb', 'viscous', 'stribeck', 'stribeck_velocity'), REPORTED[:4], strict=True)
    )
    law = make_friction_law('stribeck', {**named, 'bias': bias}, 1e-6)
    odd = make_friction_law('stribeck', {**named, 'bias': 0.0}, 1e-6)
    w = -np.geomspace(1e-3, 200.0, 500)
    power = law.torque(w) * w
    driven = (-w > found['low']) & (-w < found['high'])
    np.testing.assert_array_equal(power < 0.0, driven)
    assert np.all(odd.torque(w) * w > 0.0)
    assert np.all(law.torque(-w) * -w > 0.0)


@size(
    'reported S, v_s',
    'the Stribeck term is {at_12:.0f} mNm at 12.5 mrad/s, {at_20:.1f} mNm at 20, {at_50:.0f} nNm '
    'at 50; time within v_s per reversal {ms_1:.2f} ms (0.35 rad, 0.5 Hz), {ms_2:.0f} ms (0.06 '
    'rad, 0.4 Hz); one step of a 16-bit encoder in 1 ms is {step:.3f} rad/s = {steps:.0f} v_s; '
    'above 20 mrad/s S = 0 changes the torque by {zero:.1f} mNm at most and S = {ten:.0f} Nm, v_s '
    '= {vs_ten:.2f} mrad/s by {ten_change:.1f}',
)
def not_identifiable(study):
    _, _, S, vs, _ = REPORTED

    def term(w):
        return 1e3 * S * np.exp(-w / vs)

    edge, ten = 0.02, 10 * S
    vs_ten = edge / np.log(1e3 * ten / term(edge))
    w = np.linspace(edge, 0.2, 20_001)
    step = 2 * np.pi / 2**16 / 1e-3

    def inside(amplitude, frequency):
        """Time of |A w cos(w t)| < v_s around one zero."""
        omega = 2 * np.pi * frequency
        return 1e3 * 2 / omega * np.arcsin(vs / (amplitude * omega))

    return {
        'at_12': term(0.0125),
        'at_20': term(0.02),
        'at_50': 1e6 * term(0.05),
        'ms_1': inside(0.35, 0.5),
        'ms_2': inside(0.06, 0.4),
        'step': step,
        'steps': step / vs,
        'zero': term(w).max(),
        'ten': ten,
        'vs_ten': 1e3 * vs_ten,
        'ten_change': np.abs(1e3 * ten * np.exp(-w / vs_ten) - term(w)).max(),
    }


def test_the_reported_stribeck_term_is_below_what_the_sensors_resolve(sizes):
    found = sizes['reported S, v_s']
    C, B, _, vs, bias = REPORTED
    for speed, key, unit in ((0.0125, 'at_12', 1e3), (0.02, 'at_20', 1e3), (0.05, 'at_50', 1e9)):
        # What is left of the law when the other terms are taken off; cancellation 1e-15 Nm.
        rest = unit * (reported_torque(speed) - bias - C - B * speed)
        assert found[key] == pytest.approx(rest, abs=1e-15 * unit)
    # A sampled clock agrees with the closed form of the time spent below v_s.
    for amplitude, frequency, key in ((0.35, 0.5, 'ms_1'), (0.06, 0.4, 'ms_2')):
        omega = 2 * np.pi * frequency
        t = np.arange(0.0, np.pi / omega, 1e-6)
        below = np.abs(amplitude * omega * np.cos(omega * t)) < vs
        assert 1e-3 * below.sum() == pytest.approx(found[key], abs=2e-3)
    assert found['steps'] > 10.0


def test_amplitude_and_velocity_of_the_reported_knee_trade_off_exactly(sizes):
    """S' exp(-w0/v') = S exp(-w0/v): any S' >= 2.4 mNm has a v' for speeds above w0."""
    found = sizes['reported S, v_s']
    assert found['ten_change'] < found['zero'] == found['at_20']
    assert found['zero'] < 3.0
    meets = 1e3 * found['ten'] * np.exp(-20.0 / found['vs_ten'])
    assert meets == pytest.approx(found['at_20'], rel=1e-9)


# ---- the page ----


@pytest.fixture(scope='module')
def page() -> str:
    return PAGE.read_text(encoding='utf-8')


@pytest.fixture(scope='module')
def rows(page: str) -> dict[str, tuple[str, str, list[str]]]:
    """Row -> anchor of its proof, its size, its tests."""
    found = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip('|').split('|')]
        link = re.fullmatch(r'\[(.+)\]\(#(.+)\)', cells[0])
        if line.startswith('|') and link:
            _, _, size_text, tests = cells
            found[link[1]] = (link[2], size_text, re.findall(r'`(\w+)`', tests))
    return found


def test_the_page_says_the_numbers_that_are_computed(page, rows, sizes):
    """With -s: every row as it must be on the page."""
    said = {row: SIZES[row].text.format(**values) for row, values in sizes.items()}
    print()
    for row, text in said.items():
        print(f'{row}: {text}')
    assert {row: size_text for row, (_, size_text, _) in rows.items()} == said
    print(SET_UP)
    assert SET_UP in ' '.join(page.split())


def test_each_row_of_the_page_names_its_tests_and_each_test_has_a_row(rows):
    named = [name for _, _, tests in rows.values() for name in tests]
    assert all(tests for _, _, tests in rows.values())
    about_the_page = {name for name in globals() if re.match(r'test_(the_page|each_row)_', name)}
    assert len(about_the_page) == 3
    assert sorted(named) == sorted(
        name for name in globals() if name.startswith('test_') and name not in about_the_page
    )


def test_the_page_has_print_correction_and_proof_of_each_row(page, rows):
    sections = dict(re.findall(r'^## (.+)\n((?:(?!## ).*\n)*)', page, re.MULTILINE))
    anchors = {
        re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-'): text
        for heading, text in sections.items()
    }
    for row, (anchor, _, _) in rows.items():
        parts = re.findall(r'^- \*\*(\w+)\*\*: (\S)', anchors[anchor], re.MULTILINE)
        assert [name for name, _ in parts] == ['Printed', 'Correct', 'Proof'], row
