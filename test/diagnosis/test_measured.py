# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Measured data: what the diagnosis says of the EMPS axis and of a motor's cogging."""

from __future__ import annotations

import re

import numpy as np
import pytest
from full_runs import in_full
from known_robots import recording, slider_model
from scipy.io import loadmat

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.model.model_folder import JointModel, RobotModelFile, read_model
from sosml_friction.model.parameter import Parameter

ROTOR = """<robot name="rotor"><link name="base"/><link name="rotor"><inertial>
<origin xyz="0 0 0"/><mass value="0.1"/>
<inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
<joint name="motor" type="revolute"><parent link="base"/><child link="rotor"/>
<axis xyz="0 0 1"/><limit lower="-10" upper="10" effort="1" velocity="100"/></joint></robot>"""


@pytest.fixture(scope='module')
def emps_nominal():
    """Return the published symmetric model: data/README.md."""
    return slider_model(20.3935, 203.5034, -3.1648)


@pytest.fixture(scope='module')
def emps(emps_log, emps_nominal):
    return diagnose([emps_log], emps_nominal)


def test_emps_names_direction_first_then_the_period_of_the_screw_and_not_stribeck(emps):
    assert emps.verdict == 'named'
    first, second = emps.causes[:2]
    assert first.effect == 'asymmetric_friction'
    # Published: Fv+ 166.706, Fv- 240.424 N s/m, half of whose difference is -36.86.
    value = first.parameters['viscous_asymmetry']
    assert value.value == pytest.approx(-36.86, abs=3.0 * value.std_error)
    assert second.effect == 'cogging'
    # data/README.md: about 1 N at 2.5 mm.
    period = 2.0 * np.pi / second.parameters['frequency'].value
    assert period == pytest.approx(2.5e-3, rel=2e-3)
    size = np.hypot(second.parameters['cosine'].value, second.parameters['sine'].value)
    assert size == pytest.approx(1.0, abs=0.3)
    assert all(cause.effect != 'stribeck' for cause in emps.causes)


def test_emps_gains_on_blocks_held_out_of_the_fit(emps):
    errors = [stage['relative_error_percent']['slider'] for stage in emps.stages]
    # Published, in sample: 4.08 % symmetric, 3.11 % by direction.
    assert errors[0] == pytest.approx(4.08, abs=0.4)
    assert errors[1] <= 3.1
    assert errors[2] < errors[1]
    assert emps.gain.forward_after[0] < 0.5 * emps.gain.forward_before[0]


def test_emps_stribeck_is_impossible_because_friction_rises_with_speed(emps):
    found = next(entry for entry in emps.ranking if entry['effect'] == 'stribeck')
    assert 'fall towards standstill' in found['objection']


def test_the_extended_model_can_be_written_and_read_back(emps, emps_nominal, tmp_path):
    model = extended_model(emps_nominal, emps, {'bag': 'emps'})
    model.write(tmp_path / 'extended')
    again = read_model(tmp_path / 'extended')
    assert [(t.effect, t.joint) for t in again.effects] == [
        (cause.effect, cause.joint) for cause in emps.causes
    ]
    own = again.effects[0].parameters['viscous_asymmetry'].value
    assert own == emps.causes[0].parameters['viscous_asymmetry'].value
    # Refitted friction stays within the tolerance of 3.5 %.
    assert again.joints['slider'].friction.parameters['viscous'].value == pytest.approx(
        203.5, rel=0.0351
    )


@pytest.fixture(scope='module')
def pulses_record(data_directory):
    return loadmat(data_directory / 'emps/DATA_EMPS_PULSES.mat', squeeze_me=True)


def pulses_log(record, command):
    """Return the record with pulses, its effort made of a command [V]."""
    effort = float(record['gtau']) * np.asarray(command)
    return recording(('slider',), record['t'], record['qm'], effort)


def test_on_the_record_with_pulses_the_direction_carries_over_and_the_screw_does_not(
    emps_log, emps_nominal, pulses_record
):
    holdout = pulses_log(pulses_record, pulses_record['vir'])
    found = diagnose([emps_log], emps_nominal, holdout)
    first, second = found.causes[:2]
    assert (first.effect, second.effect) == ('asymmetric_friction', 'cogging')
    assert first.in_model
    assert not second.in_model
    # data/README.md: 0.94 and 0.75 N, 106 and -149 degrees.
    assert second.gain.size.value == pytest.approx(0.75 / 0.94, abs=0.1)
    assert second.gain.phase == pytest.approx(106.0 + 149.0 - 360.0, abs=15.0)
    # 5.62 % symmetric, 4.94 % by direction, 5.06 % with the screw's force, too.
    assert found.gain.relative_after[0] < 5.0
    assert 'Cogging (slider) does not carry over' in found.sentence


def test_the_record_with_pulses_is_diagnosed_with_them(emps_nominal, pulses_record):
    found = diagnose([pulses_log(pulses_record, pulses_record['vir'])], emps_nominal)
    assert found.verdict == 'named'
    assert [cause.effect for cause in found.causes] == ['asymmetric_friction']
    (delay,) = found.tolerated
    assert delay.effect == 'effort_delay'
    # What is recorded is the command: the force comes 0.46 ms later in the record without pulses,
    # which is within half a sample, and later where it is faster. That of a command is no cause.
    assert -1.0e-3 < delay.parameters['delay'].value < -0.46e-3


def test_pulses_that_the_effort_lacks_are_pushes(emps_nominal, pulses_record):
    """Beside what the record without pulses has: friction by direction, and its screw's force."""
    command = pulses_record['vir'] - 1.014 * pulses_record['pulses_N']
    found = diagnose([pulses_log(pulses_record, command)], emps_nominal)
    cause, *others = found.causes
    assert cause.effect == 'external_contact'
    assert {other.effect for other in others} <= {'asymmetric_friction', 'cogging'}
    on = np.count_nonzero(np.diff((pulses_record['pulses_N'] > 0).astype(int)) > 0)
    assert cause.parameters['episodes'].value == on
    size = 1.014 * float(pulses_record['gtau']) * float(pulses_record['pulses_N'].max())
    assert cause.parameters['level'].value == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize('armature', [3e-5, in_full(2.5e-4)])
def test_odrive_cogging_is_named_with_its_harmonics_for_any_armature(data_directory, armature):
    time, counts, current = np.load(data_directory / 'odrive_cogging/slow2_nocomp_0.npy')
    q = counts[:, None] / 8192.0 * 2.0 * np.pi
    # data/README.md: 0.4 A is about 3 mNm.
    tau = 7.5e-3 * current[:, None]
    log = recording(('motor',), time, q, tau)
    model = RobotModelFile('rotor', {'motor': JointModel(Parameter(armature, 'kg m2'))}, ROTOR)
    found = diagnose([log], model)
    assert found.verdict == 'named'
    assert [cause.effect for cause in found.causes] == ['cogging']
    frequencies = [inner['frequency'] for inner, _ in found.causes[0].terms]
    # Beside an inertia that is eight times too large the second is not beyond slow noise.
    assert len(frequencies) >= (1 if armature > 1e-4 else 2)
    # Of those data/README.md lists, which are 96 % of the current, and then smaller ones, as 112,
    # sixteen times 7; one turn tells a frequency to a fraction of a cycle.
    for frequency in frequencies[:3]:
        assert min(abs(frequency - k) for k in (7, 14, 28, 12, 36, 48, 60, 84)) < 0.3
    assert frequencies[0] == pytest.approx(7.0, abs=0.2)
    errors = [stage['relative_error_percent']['motor'] for stage in found.stages]
    assert errors[-1] < 0.45 * errors[0]
    # The sentence has all of them.
    said = [float(number) for number in re.findall(r'(\d+\.\d+) ± ', found.sentence)]
    assert all(np.isclose(said, frequency, rtol=1e-3).any() for frequency in frequencies)
    told = [check for check in found.checks if check.kind == 'inertia']
    # data/README.md: this motion does not tell 2.5e-4 kg m2.
    assert told or armature < 1e-4


def test_the_ripple_of_a_servo_is_named_and_carries_over_to_its_second_run(data_directory):
    """data/README.md: 10 periods per output turn."""
    runs = []
    for number in (1, 2):
        record = np.load(data_directory / f'damiao/motor_05_run_{number:02d}.npz')
        # The free range is a turn of the protocol, +-12.5 rad.
        q = np.unwrap(record['position'], period=25.0)
        runs.append(recording(('motor',), record['time'], q, record['torque_feedback']))
    urdf = ROTOR.replace('lower="-10" upper="10"', 'lower="-1000" upper="1000"')
    model = RobotModelFile('servo', {'motor': JointModel(Parameter(1.07e-3, 'kg m2'))}, urdf)
    found = diagnose(runs[:1], model, runs[1])
    (cogging,) = (cause for cause in found.causes if cause.effect == 'cogging')
    assert cogging.parameters['frequency'].value == pytest.approx(10.0, abs=0.1)
    assert cogging.gain.carries_over
    assert found.gain.inverse_after[0] < 0.95 * found.gain.inverse_before[0]
