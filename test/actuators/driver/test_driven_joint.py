# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where exactly a joint's fault begins: each limit from both sides, in both directions."""

from __future__ import annotations

import math

import pytest

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.driven_joint import DOUBTFUL_CYCLES, DrivenJoint
from sosml_friction.actuators.measurement import Measurement
from sosml_friction.actuators.plausibility import Plausibility
from sosml_friction.actuators.rmd_x.configuration import RmdXConfiguration
from sosml_friction.model.robot import JointLimits

MS = 1_000_000
RATE = 500.0
# 40 periods of 2 ms are 80 ms; an answer after more than 3 of the 6 ms is late.
LIMITS = JointLimits(-1.0, 2.0, 3.0, 8.0)


def joint_of(**changes):
    """Return a joint at 0.5 rad, and what feeds it one position per cycle."""
    values = {
        'can_id': 1, 'current_limit': 6.0, 'current_rate_limit': 500.0, 'kp': 250.0, 'kd': 12.0,
    }  # fmt: skip
    own = RmdXConfiguration('shoulder', 1, 0.0, 1.25, **{**values, **changes})
    configuration = DriverConfiguration((own,), rate=RATE, reply_timeout=0.006)
    actuator = Actuator.kind('rmd_x')(own, LIMITS, RATE, margin=configuration.limit_margin)
    actuator.measurement.q = 0.5
    return DrivenJoint(actuator, configuration)


def feed(joint, v=0.0, cycles=20, start=0, **measured):
    """Let the joint move at ``v`` from 0.5 rad; return the cycles there have been."""
    for k in range(start, start + cycles):
        measurement = joint.actuator.measurement
        measurement.q = 0.5 + v * k / RATE
        measurement.speed = v
        measurement.stamp_ns = 2 * MS * k
        measurement.received_ns = 2 * MS * k + MS
        for key, value in measured.items():
            setattr(measurement, key, value)
        joint.take(2 * MS * k)
    return start + cycles


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_the_speed_fault_begins_at_one_fifth_above_the_limit(sign):
    """The URDF's 3 rad/s: 3.57 is allowed, 3.63 is not, whichever way."""
    slow, fast = joint_of(), joint_of()
    feed(slow, sign * 1.19 * 3.0)
    feed(fast, sign * 1.21 * 3.0)
    assert slow.problem() == ''
    assert fast.problem() == (
        f'joint shoulder moves at {sign * 3.63:.3f} per second, above 1.2 times its limit 3'
    )


def test_a_velocity_that_is_not_known_yet_is_no_fault_and_none_to_damp_with():
    joint = joint_of()
    feed(joint, 3.5, cycles=10)
    assert math.isnan(joint.v)
    assert joint.known_v == 0.0
    feed(joint, 3.5, cycles=1, start=10)
    assert joint.v == pytest.approx(3.5)
    assert joint.known_v == joint.v


def late_answer(joint, cycle, late_ms, v):
    """Answer ``late_ms`` after the usual time, with where the joint is by then."""
    measurement = joint.actuator.measurement
    measurement.q = 0.5 + v * (cycle / RATE + 1e-3 * late_ms)
    measurement.stamp_ns = 2 * MS * cycle
    measurement.received_ns = 2 * MS * cycle + MS + round(late_ms * MS)
    joint.take(2 * MS * cycle)
    return cycle + 1 + int(late_ms // 2)


def test_an_answer_that_came_late_has_no_speed():
    """An adapter may have held the question back for 200 ms, or the answer: nobody knows."""
    joint = joint_of()
    cycle = late_answer(joint, feed(joint, 0.7), 200.0, 0.7)
    assert joint.late
    assert math.isnan(joint.v)
    for _ in range(20):
        cycle = feed(joint, 0.7, cycles=1, start=cycle)
        assert joint.problem() == ''
        assert joint.known_v == pytest.approx(0.7)


@pytest.mark.parametrize('late_ms', [2.5, 5.0, 10.0, 21.0])
def test_answers_that_are_late_by_less_make_no_false_speed_fault(late_ms):
    """At the limit of 3 rad/s one position of a later time makes the loop's own slope faster."""
    joint = joint_of()
    cycle, fastest = late_answer(joint, feed(joint, 3.0), late_ms, 3.0), 0.0
    for _ in range(20):
        cycle = feed(joint, 3.0, cycles=1, start=cycle)
        fastest = max(fastest, joint.known_v)
        assert joint.problem() == ''
    assert fastest > 3.1


@pytest.mark.parametrize(
    ('q', 'fault'), [(-1.099, False), (-1.101, True), (2.099, False), (2.101, True)]
)
def test_the_joint_may_be_outside_its_limits_by_the_margin(q, fault):
    joint = joint_of()
    joint.actuator.measurement.q = q
    assert bool(joint.problem()) == fault
    if fault:
        assert '0.1010 outside its limits -1 to 2' in joint.problem()


@pytest.mark.parametrize(
    ('temperature', 'fault'), [(75.0, False), (75.5, True), (math.nan, False)]
)
def test_the_temperature_limit_is_the_last_that_is_allowed(temperature, fault):
    joint = joint_of()
    joint.actuator.measurement.temperature = temperature
    assert bool(joint.problem()) == fault


# ---- effort


def test_the_effort_of_a_cycle_that_gave_no_sample_is_in_that_of_the_next():
    """The impulse is what the motion answers: of 6 ms at 1 Nm and 2 ms at 5 Nm, 2 Nm."""
    joint = joint_of()
    cycle = feed(joint, tau=3.0)
    assert joint.take_effort() == pytest.approx(3.0)
    cycle = feed(joint, cycles=3, start=cycle, tau=1.0)
    cycle = feed(joint, cycles=1, start=cycle, tau=5.0)
    assert joint.take_effort() == pytest.approx(2.0)
    feed(joint, cycles=1, start=cycle, tau=5.0)
    assert joint.take_effort() == pytest.approx(5.0)


def test_the_effort_of_a_silence_is_not_that_of_the_samples_around_it():
    """What is measured first after it is all that is known."""
    joint = joint_of()
    cycle = feed(joint, tau=1.0)
    feed(joint, cycles=1, start=cycle + 500, tau=5.0)
    assert joint.take_effort() == pytest.approx(5.0)
    feed(joint, cycles=1, start=cycle + 501, tau=3.0)
    assert joint.take_effort() == pytest.approx(3.0)


def test_an_effort_that_is_not_measured_is_none_until_it_is():
    joint = joint_of()
    cycle = feed(joint, tau=math.nan)
    assert math.isnan(joint.take_effort())
    feed(joint, cycles=1, start=cycle, tau=1.0)
    assert joint.take_effort() == pytest.approx(1.0)


# ---- following


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_the_tracking_fault_begins_at_the_tracking_limit(sign):
    assert joint_of().tracking_problem(0.5 + sign * 0.199) == ''
    problem = joint_of().tracking_problem(0.5 + sign * 0.201)
    assert 'further than tracking_limit 0.2: something holds or drives it' in problem


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_joint_is_stuck_when_its_reference_went_a_quarter_of_the_tracking_limit(sign):
    """0.05 rad; it stays where it moves less than a hundredth of the limit, 2 mrad."""
    stuck, moving = joint_of(), joint_of()
    for joint in (stuck, moving):
        assert joint.tracking_problem(0.5) == ''
        assert joint.tracking_problem(0.5 + sign * 0.049) == ''
    stuck.actuator.measurement.q += sign * 0.0019
    moving.actuator.measurement.q += sign * 0.0021
    assert 'blocked' in stuck.tracking_problem(0.5 + sign * 0.051)
    assert moving.tracking_problem(0.5 + sign * 0.051) == ''


def test_a_position_that_is_not_a_number_is_not_followed():
    joint = joint_of()
    joint.actuator.measurement.q = math.nan
    assert joint.tracking_problem(0.5)
    assert joint.problem()


# ---- silence


def test_it_may_be_silent_for_forty_periods_and_no_longer():
    joint = joint_of()
    joint.wait(0, 80 * MS - 1, missed=True)
    assert joint.problem() == ''
    joint.wait(0, 80 * MS, missed=True)
    assert 'no answer from 0x241' in joint.problem()
    assert '(no timely answer for 80 ms)' in joint.problem()
    joint.hear()
    assert joint.problem() == ''


def test_silence_counts_from_its_first_cycle():
    joint = joint_of()
    joint.wait(10 * MS, 12 * MS, missed=True)
    joint.wait(50 * MS, 89 * MS, missed=True)
    assert not joint.silent
    joint.wait(88 * MS, 90 * MS, missed=True)
    assert joint.silent


@pytest.mark.parametrize(('latency_ns', 'timely'), [(3 * MS, True), (3 * MS + 1000, False)])
def test_an_answer_after_half_the_wait_may_be_an_old_one(latency_ns, timely):
    joint = joint_of()
    joint.actuator.measurement.received_ns = latency_ns
    joint.take(0)
    assert joint.timely == timely


# ---- a return from a restart


@pytest.mark.parametrize(
    ('ratio', 'moved', 'refused'),
    [
        (math.nan, 0.299, False),
        (math.nan, 0.301, True),
        (math.nan, -0.301, True),
        (36.0, 0.086, False),
        (36.0, 0.088, True),
        (36.0, -0.088, True),
        (2.0, 0.301, True),
    ],
)
def test_half_a_motor_turn_since_it_was_switched_off_is_refused(ratio, moved, refused):
    """0.3 rad where the gear ratio is not known; pi / 36 is 0.0873."""
    joint = joint_of(gear_ratio=ratio)
    feed(joint)
    joint.trust()
    joint.actuator.restarts += 1
    assert 'switched on anew' in joint.event()
    joint.actuator.measurement.q += moved
    joint.come_back('')
    assert ('lost count of its turns' in joint.problem()) == refused
    assert joint.away == refused


def test_who_was_silent_but_never_off_may_be_anywhere():
    joint = joint_of()
    feed(joint)
    joint.trust()
    joint.away = True
    joint.actuator.measurement.q += 1.0
    joint.come_back('')
    assert joint.problem() == ''
    assert not joint.away


# ---- measurements that cannot be true


def test_what_cannot_be_true_is_a_fault_when_it_lasts_for_fifty_milliseconds():
    joint = joint_of()
    k = feed(joint)
    k = feed(joint, cycles=DOUBTFUL_CYCLES - 1, start=k, current=20.0)
    assert DOUBTFUL_CYCLES == 25
    assert joint.problem() == ''
    k = feed(joint, cycles=1, start=k, current=1.0)
    k = feed(joint, cycles=DOUBTFUL_CYCLES - 1, start=k, current=20.0)
    assert joint.problem() == ''
    feed(joint, cycles=1, start=k, current=20.0)
    assert 'reports 20.00 A where its limit is 6 A' in joint.problem()
    joint.enable()
    assert joint.problem() == ''


LIMIT = Plausibility(current=6.0, velocity=3.0, step_slack=0.02)


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize(
    ('inside', 'outside'),
    [
        # 1.5 times 6 A and 0.5 A.
        ({'current': 9.49}, {'current': 9.51}),
        # 0.6 rad/s and three tenths of its own speed.
        ({'speed': 0.0, 'v': 0.599}, {'speed': 0.0, 'v': 0.601}),
        ({'speed': 2.0, 'v': 0.81}, {'speed': 2.0, 'v': 0.79}),
        ({'speed': 2.0, 'v': 3.19}, {'speed': 2.0, 'v': 3.21}),
        # Twice 3 rad/s for 2 ms and 0.02 rad.
        ({'step': 0.0319}, {'step': 0.0321}),
    ],
)
def test_each_bound_of_what_can_be_true_from_both_sides(sign, inside, outside):
    def doubt(current=0.0, speed=math.nan, v=math.nan, step=0.0):
        measured = Measurement(current=sign * current, speed=sign * speed)
        return LIMIT.doubt(measured, sign * v, sign * step, 0.002)

    assert doubt(**inside) == ''
    assert 'wrong' in doubt(**outside)


def test_a_temperature_below_any_is_a_broken_sensor_and_nothing_measured_is_no_doubt():
    assert LIMIT.doubt(Measurement(temperature=-40.0), 0.0, 0.0, 0.002) == ''
    assert 'temperature sensor' in LIMIT.doubt(Measurement(temperature=-41.0), 0.0, 0.0, 0.002)
    assert LIMIT.doubt(Measurement(), math.nan, math.nan, 0.002) == ''


def test_a_type_without_a_limit_of_current_is_judged_by_the_joints_effort():
    joint = joint_of()
    assert joint.actuator.plausibility().current == 6.0
    general = Actuator.plausibility(joint.actuator)
    assert general.current == pytest.approx(8.0 / 1.25)
    assert general.velocity == 3.0
    assert general.step_slack == pytest.approx(0.1 * 0.2)
