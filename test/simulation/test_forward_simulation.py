# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The forward simulation against closed forms, the Runge-Kutta plant and inverse dynamics."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.simulated_term import Gear
from sosml_friction.model.terms.kinds.transmission_term import SimulatedGear
from sosml_friction.share import share_directory
from sosml_friction.simulation.forward_drive import RecordedDrive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import Start, simulate
from sosml_friction.simulation.plant import Plant

#: A rotor alone, no gravity about its axis.
ROTOR = """<robot name="rotor"><link name="base"/><link name="rotor"><inertial>
<origin xyz="0 0 0"/><mass value="0.1"/>
<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/></inertial></link>
<joint name="motor" type="revolute"><parent link="base"/><child link="rotor"/>
<axis xyz="0 0 1"/><limit lower="-10" upper="10" effort="1" velocity="100"/></joint></robot>"""


def rotor(body=1e-5, motor=2e-5):
    return Robot(ROTOR.format(body), ['motor'], [motor])


def friction(*laws):
    return JointFriction(
        [
            None
            if law is None
            else make_friction_law(
                'coulomb_viscous', dict(zip(('coulomb', 'viscous', 'bias'), law, strict=True)), 0.0
            )
            for law in laws
        ]
    )


def run(model, torque, q=None, v=None, a=None, period=2e-3, sign=0.0, path=None, followed=()):
    """Return the simulation of one window from a state, torque (N, n) at the samples."""
    n = torque.shape[1]
    count = len(torque)
    zero = np.zeros((1, n))
    state = [zero if x is None else np.array([x], dtype=float) for x in (q, v, a)]
    path = np.repeat(state[0], count, axis=0) if path is None else path
    start = Start(
        *state, zero + sign, path, np.zeros(1, dtype=np.int64), np.arange(count) * period,
        np.full((count, n), np.nan),
    )  # fmt: skip
    drive = RecordedDrive(torque[None])
    effort = np.abs(torque).max(axis=0)
    found = simulate(model, start, drive, period, count, effort, followed=followed)
    return found.q[0], found.v[0]


def test_a_swing_is_that_of_the_runge_kutta_plant_and_the_error_is_of_second_order():
    robot = read_model(share_directory() / 'config/exoskeleton').make_robot()
    q0, v0 = np.array([-0.9, 0.8]), np.array([0.5, -0.3])
    plant = Plant(robot, [], q0, v0)
    for _ in range(4000):
        plant.step(np.zeros(2), 1e-4)
    errors = []
    for period in (4e-3, 2e-3, 1e-3):
        model = ForwardModel(robot, friction(None, None), np.full(2, 1e-3))
        count = round(0.4 / period) + 1
        a0 = robot.acceleration(q0, v0, np.zeros(2))
        q, _ = run(model, np.zeros((count, 2)), q0, v0, a0, period)
        errors.append(np.abs(q[-1] - plant.q).max())
    # Swings by a radian; each halving of the step divides the error by four, or a little less.
    assert errors[1] < 2e-4
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0


def test_effort_of_inverse_dynamics_moves_seven_joints_as_it_should(seven_joints):
    """One of them prismatic; sines, 0.2 s: over longer a chain without control is not stable."""
    period = 1e-3
    t = np.arange(0.0, 0.2, period)[:, None]
    w, phase = np.linspace(2.0, 6.0, 7), np.arange(7.0)
    q = 0.2 * np.sin(w * t + phase)
    v, a = 0.2 * w * np.cos(w * t + phase), -0.2 * w**2 * np.sin(w * t + phase)
    torque = np.array([seven_joints.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    model = ForwardModel(seven_joints, friction(*[None] * 7), np.full(7, 1e-3))
    found, _ = run(model, torque, q[0], v[0], a[0], period)
    # Moves by 0.1 rad; second order in a step of 1 ms.
    assert np.abs(found - q).max() < 2e-5


def test_under_less_than_coulomb_friction_it_sticks_where_dahl_says():
    """A slow ramp to half of Coulomb friction: x = -x_s ln(1 - tau / C), and there it stays."""
    C, x_s = 0.01, 1e-4
    model = ForwardModel(rotor(), friction((C, 1e-3, 0.0)), np.array([x_s]))
    torque = np.minimum(np.arange(3000) * 2e-3 / 2.0, 1.0)[:, None] * 0.5 * C
    q, _ = run(model, torque)
    # What oscillates about it, on friction without micro-damping, is a hundredth.
    assert q[1500:, 0].mean() == pytest.approx(x_s * np.log(2.0), rel=0.02)
    assert np.ptp(q[1500:, 0]) < 0.05 * x_s


def test_a_light_rotor_with_stiff_friction_is_stable_and_slips_at_its_closed_form():
    """3e-5 kg m2 on 3 mNm over 0.1 mrad oscillates at 160 Hz: steps of 1 rad, not of 2 ms."""
    C, B, tau = 3e-3, 1e-4, 4e-3
    model = ForwardModel(rotor(), friction((C, B, 0.0)), np.array([1e-4]))
    assert model.steps(np.zeros(1), np.array([tau]), 2e-3) >= 2
    _, v = run(model, np.full((1500, 1), tau))
    t = 1499 * 2e-3
    assert v[-1, 0] == pytest.approx((tau - C) / B * (1.0 - np.exp(-B * t / 3e-5)), rel=1e-3)


@pytest.mark.parametrize('stiffness', [0.5, 5.0])
def test_two_masses_ring_at_the_frequency_of_the_books(stiffness):
    body, motor = 4e-5, 2e-5
    model = ForwardModel(
        rotor(body, motor), friction(None), np.array([1e-3]),
        [SimulatedGear(Gear(0, stiffness, 0.0, 0.0))],
    )  # fmt: skip
    torque = np.zeros((2000, 1))
    torque[1] = 1e-3
    period = 5e-4
    _, v = run(model, torque, period=period)
    ringing = v[5:, 0] - v[5:, 0].mean()
    power = np.abs(np.fft.rfft(ringing * np.hanning(len(ringing)), 1 << 17))
    found = np.fft.rfftfreq(1 << 17, period)[np.argmax(power)]
    wanted = np.sqrt(stiffness * (1.0 / body + 1.0 / motor)) / (2.0 * np.pi)
    # The rule with steps of one radian is 0.6 % slow.
    assert found == pytest.approx(wanted, rel=0.007)
    # And momentum is that of the pulse: a triangle of two samples.
    assert v[5:, 0].mean() == pytest.approx(1e-3 * period / (body + motor), rel=0.02)


def test_a_gap_lets_the_motor_go_alone_until_it_is_crossed():
    body, motor, gap, tau, period = 4e-5, 2e-5, 0.02, 1e-4, 1e-3
    model = ForwardModel(
        rotor(body, motor), friction(None), np.array([1e-3]),
        [SimulatedGear(Gear(0, 50.0, gap, 0.0))],
    )  # fmt: skip
    # Without a load it starts in the middle: the motor is free for half of the gap.
    q, _ = run(model, np.full((200, 1), tau), period=period)
    crossing = int(np.searchsorted(np.abs(q[:, 0]), 0.4 * gap))
    t = np.arange(crossing) * period
    assert q[:crossing, 0] == pytest.approx(0.5 * tau / motor * t**2, rel=0.02, abs=1e-5)
    free = 0.5 * tau / motor * (199 * period) ** 2
    assert q[-1, 0] < 0.6 * free


def test_a_body_behind_a_gear_starts_as_fast_as_its_motor_whatever_the_noise_of_the_path():
    """
    A gear of 0.2 % damping would ring with the noise of position: 40 windows of free flight.

    At 25 Hz 0.02 mrad are 3 mrad/s, a ringing gear's are several times more.
    """
    body, motor, period, samples = 4e-5, 2e-5, 2e-3, 150
    stiffness = body * (2.0 * np.pi * 25.0) ** 2
    rng = np.random.default_rng(0)
    speed = 0.15
    time = np.arange(4000) * period
    path = (speed * time + rng.normal(0.0, 2e-5, len(time)))[:, None]
    at = np.linspace(400, 3600, 40).astype(np.int64)
    model = ForwardModel(
        rotor(body, motor), friction(None), np.array([1e-3]),
        [SimulatedGear(Gear(0, stiffness, 0.0, 0.002))],
    )  # fmt: skip
    still = np.zeros((len(at), 1))
    start = Start(
        path[at], still + speed, still, still, path, at, time, np.full(path.shape, np.nan)
    )
    drive = RecordedDrive(np.zeros((len(at), samples, 1)))
    found = simulate(model, start, drive, period, samples, np.ones(1))
    mean = (found.q[:, -1, 0] - found.q[:, 0, 0]) / ((samples - 1) * period)
    assert np.sqrt(np.mean((mean - speed) ** 2)) < 5e-3


def test_a_gear_with_a_gap_is_found_on_the_side_where_it_was():
    """
    A swing across a gap of 4 mrad, begun anew in 40 places from the motor's path, repeats itself.

    Half a gap is 2 mrad: in the wrong place the motor would be off by more than that.
    """
    body, motor, period, samples = 4e-3, 2e-3, 2e-3, 150
    gear = SimulatedGear(Gear(0, 50.0, 4e-3, 0.2))
    model = ForwardModel(
        rotor(body, motor), friction((0.0, 0.01, 0.0)), np.array([1e-3]), [gear]
    )  # fmt: skip
    time = np.arange(4000) * period
    torque = (0.06 * np.sin(4.0 * time) + 0.04 * np.sin(9.0 * time))[:, None]
    q, v = run(model, torque, period=period)
    a = np.gradient(v, period, axis=0)
    at = np.linspace(1000, 3800, 40).astype(np.int64)
    start = Start(q[at], v[at], a[at], 0.0 * q[at], q, at, time, np.full(q.shape, np.nan))
    drive = RecordedDrive(torque[at[:, None] + np.arange(samples)])
    found = simulate(model, start, drive, period, samples, np.ones(1))
    error = found.q - q[at[:, None] + np.arange(samples)]
    assert np.sqrt(np.mean(error**2)) < 0.5e-3


def test_a_joint_without_effort_follows_its_recording():
    robot = read_model(share_directory() / 'config/exoskeleton').make_robot()
    period = 2e-3
    t = np.arange(0.0, 0.4, period)
    path = np.column_stack([-0.9 + 0.1 * np.sin(3.0 * t), 0.8 + 0.2 * np.sin(5.0 * t)])
    v = np.gradient(path, period, axis=0)
    a = np.gradient(v, period, axis=0)
    torque = np.array([robot.inverse_dynamics(*x) for x in zip(path, v, a, strict=True)])
    torque[:, 1] = 0.0
    model = ForwardModel(robot, friction(None, None), np.full(2, 1e-3))
    q, _ = run(model, torque, path[0], v[0], a[0], period, path=path, followed=[1])
    assert q[:, 1] == pytest.approx(path[:, 1], abs=1e-12)
    # Numerical derivatives of the path, one-sided at its start.
    assert q[:, 0] == pytest.approx(path[:, 0], abs=1e-3)


def test_what_cannot_be_simulated_is_refused_in_a_sentence():
    with pytest.raises(ConfigurationError, match='positive displacement'):
        ForwardModel(rotor(), friction((1.0, 0.0, 0.0)), np.zeros(1))
    model = ForwardModel(rotor(), friction((1.0, 0.0, 0.0)), np.array([1e-9]))
    with pytest.raises(ConfigurationError, match='too small a displacement'):
        model.steps(np.zeros(1), np.ones(1), 2e-3)
