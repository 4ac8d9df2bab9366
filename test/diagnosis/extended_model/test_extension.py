# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The extended model: what is found is in one place, and the robot needs the effort of it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from known_robots import arm_model
from scipy.spatial.transform import Rotation

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.consistent_inertias import is_possible
from sosml_friction.model.model_folder import (
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.regression.nominal import make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

NAMES = ('shoulder', 'elbow')
EVIDENCE = dict.fromkeys(('delta_bic', 'cv_gain', 'cv_gain_se'), np.float64(1.0))


@pytest.fixture(scope='module')
def model():
    return arm_model()


@pytest.fixture(scope='module')
def signals(model):
    """Return what the diagnosis sees of twelve seconds of motion."""
    t = np.arange(0.0, 12.0, 5e-3)
    q = np.column_stack([-0.8 + 0.5 * np.sin(1.1 * t), 0.9 + 0.6 * np.sin(1.7 * t + 0.5)])
    tau = np.random.default_rng(0).normal(0.0, 0.02, q.shape)
    log = JointLog(NAMES, np.rint(t * 1e9).astype(np.int64), q, np.full_like(q, np.nan), tau)
    return prepare([log], model, model.make_robot(), DiagnosisSettings(band=15.0))[0]


def diagnosed(signals, causes=(), refit=None):
    """Return a diagnosis as far as an extension needs it."""
    laboratory = SimpleNamespace(robot=signals.robot, signals=[signals])
    return Diagnosis(
        'named', tuple(causes), (), NAMES, ('Nm', 'Nm'), '', '', refit=refit or {},
        laboratory=laboratory,
    )  # fmt: skip


def cause_of(signals, effect, joint, amplitudes, inner=None):
    found = make_library()[effect]
    i = 0 if joint == '*' else NAMES.index(joint)
    errors = np.full(len(amplitudes), 1e-3)
    parameters = found.reported(Fitted(signals, i, inner or {}, np.array(amplitudes), errors))
    terms = ((inner or {}, np.array(amplitudes)),)
    return Cause(effect, joint, parameters, EVIDENCE, terms=terms)


def columns_times(signals, effect, joint, amplitudes, inner=None):
    i = 0 if joint == '*' else NAMES.index(joint)
    return make_library()[effect].columns(signals, i, inner or {}) @ np.array(amplitudes)


def effort(robot, signals, rows):
    return np.array(
        [robot.inverse_dynamics(signals.q[k], signals.v[k], signals.a[k]) for k in rows]
    )


def round_trip(model, diagnosis, folder):
    extended_model(model, diagnosis, {'bag': 'none'}).write(folder)
    return read_model(folder)


@pytest.mark.parametrize(
    ('effect', 'joint', 'amplitudes', 'inner'),
    [
        ('gravity', 'shoulder', (0.03, -0.05), None),
        ('gravity', 'elbow', (-0.02, 0.01), None),
        ('inertia', 'shoulder', (-0.02,), None),
        ('inertia', 'elbow', (0.01,), None),
        ('payload', '*', (0.3,), {'x': 0.2, 'y': 0.05, 'z': -0.1}),
    ],
)
def test_the_new_robot_needs_the_old_effort_plus_the_columns(
    model, signals, tmp_path, effect, joint, amplitudes, inner
):
    cause = cause_of(signals, effect, joint, amplitudes, inner)
    again = round_trip(model, diagnosed(signals, [cause]), tmp_path / 'new')
    assert again.effects == ()
    assert again.is_rigid_body_identified
    assert again.provenance['rigid_body']['written'] == [f'{effect}@{joint}']
    assert again.provenance['causes'][0]['evidence']['cv_gain'] == 1.0
    rows = np.arange(0, len(signals.q), 50)
    expected = effort(model.make_robot(), signals, rows)
    expected += columns_times(signals, effect, joint, amplitudes, inner)[rows]
    # Rounding, of sums of numbers of size 10.
    assert effort(again.make_robot(), signals, rows) == pytest.approx(expected, abs=1e-9)
    assert all(is_possible(body) for body in again.make_robot().inertial_parameters())


def test_refitted_base_parameters_are_in_the_urdf_and_the_law(model, signals, tmp_path):
    nominal = make_nominal(signals, 0.035)
    x = np.random.default_rng(1).uniform(-1.0, 1.0, len(nominal.names)) * nominal.bound
    refit = dict(zip(nominal.names, x.tolist(), strict=True))
    again = round_trip(model, diagnosed(signals, refit=refit), tmp_path / 'new')
    assert again.provenance['rigid_body'] == {'written': ['refit'], 'refused': {}}
    rows = np.arange(0, len(signals.q), 50)
    expected = effort(model.make_robot(), signals, rows)
    rigid = np.array(['body' in name or 'armature' in name for name in nominal.names])
    expected += (nominal.columns(signals) @ np.where(rigid, x, 0.0))[rows]
    assert effort(again.make_robot(), signals, rows) == pytest.approx(expected, abs=1e-9)
    for name in NAMES:
        friction = again.joints[name].friction.parameters
        assert friction['coulomb'].value == 0.5 + refit[f'{name} coulomb']
        assert friction['viscous'].value == 0.2 + refit[f'{name} viscous']


def test_a_tilted_base_is_turned_and_its_columns_are_the_first_order(model, signals, tmp_path):
    phi = (0.04, -0.03)
    cause = cause_of(signals, 'gravity_tilt', '*', phi)
    again = round_trip(model, diagnosed(signals, [cause]), tmp_path / 'new')
    assert again.effects == ()
    old, new = model.make_robot(), again.make_robot()
    felt = Rotation.from_rotvec([*phi, 0.0]).inv().apply(old.gravity_acceleration)
    rows = np.arange(0, len(signals.q), 50)
    exact = np.array([old.gravity_under(q, felt) for q in signals.q[rows]])
    assert np.array([new.gravity(q) for q in signals.q[rows]]) == pytest.approx(exact, abs=1e-9)
    linear = effort(old, signals, rows)
    linear += columns_times(signals, 'gravity_tilt', '*', phi)[rows]
    # |phi|^2 / 2 of 11 Nm of gravity, and what lines between coarse rows leave.
    assert effort(new, signals, rows) == pytest.approx(linear, abs=0.5 * 0.05**2 * 11.0 + 1e-3)


def test_a_change_that_no_body_can_have_stays_a_term_with_the_reason(model, signals, tmp_path):
    """The elbow's rotor is 0.004 kg m2, and no body makes up for it."""
    causes = [
        cause_of(signals, 'inertia', 'elbow', (-0.006,)),
        cause_of(signals, 'gravity', 'elbow', (0.02, 0.0)),
    ]
    again = round_trip(model, diagnosed(signals, causes), tmp_path / 'new')
    assert [(t.effect, t.joint) for t in again.effects] == [('inertia', 'elbow')]
    rigid = again.provenance['rigid_body']
    assert rigid['written'] == ['gravity@elbow']
    assert 'positive mass' in rigid['refused']['inertia@elbow']


def test_coulomb_and_viscous_are_in_the_law_and_others_are_terms(model, signals, tmp_path):
    causes = [
        cause_of(signals, 'coulomb', 'shoulder', (0.2,)),
        cause_of(signals, 'viscous', 'elbow', (-0.05,)),
        cause_of(signals, 'spring', 'elbow', (0.4, 0.1)),
        Cause('velocity_lag', '*', {'lag_s': Parameter(np.float64(0.01), 's')}, EVIDENCE),
    ]
    again = round_trip(model, diagnosed(signals, causes), tmp_path / 'new')
    shoulder, elbow = (again.joints[name].friction.parameters for name in NAMES)
    assert (shoulder['coulomb'].value, shoulder['coulomb'].std_error) == (0.7, 1e-3)
    assert elbow['viscous'].value == pytest.approx(0.15)
    assert [(t.effect, t.joint) for t in again.effects] == [('spring', 'elbow')]
    assert [c['effect'] for c in again.provenance['causes']] == [
        'coulomb', 'viscous', 'spring', 'velocity_lag',
    ]  # fmt: skip


def test_what_data_show_without_numbers_that_predict_is_not_in_the_model(model, signals, tmp_path):
    """Impacts tell that there is a gap; how large, they tell too roughly to simulate it."""
    gap = {'gap': Parameter(1e-3, 'rad'), 'load_changes': Parameter(9.0, '1')}
    causes = [
        cause_of(signals, 'spring', 'elbow', (0.4, 0.1)),
        Cause('backlash', 'shoulder', gap, EVIDENCE, ('joint_elasticity',)),
    ]
    assert [cause.to_dict()['in_model'] for cause in causes] == [True, False]
    again = round_trip(model, diagnosed(signals, causes), tmp_path / 'new')
    assert [t.effect for t in again.effects] == ['spring']
    assert [c['effect'] for c in again.provenance['causes']] == ['spring', 'backlash']


def test_a_joint_without_friction_gets_what_was_refitted(model, signals, tmp_path):
    joints = {**model.joints, 'elbow': JointModel(model.joints['elbow'].armature)}
    bare = RobotModelFile('bare', joints, model.urdf)
    refit = {'elbow coulomb': 0.3, 'elbow viscous': 0.1, 'elbow bias': -0.02}
    again = round_trip(bare, diagnosed(signals, refit=refit), tmp_path / 'new')
    friction = again.joints['elbow'].friction
    assert friction.law == 'coulomb_viscous'
    assert {key: p.value for key, p in friction.parameters.items()} == {
        'coulomb': 0.3, 'viscous': 0.1, 'bias': -0.02,
    }  # fmt: skip
    # Friction that drives the joint is none.
    refit['elbow coulomb'] = -0.1
    again = round_trip(bare, diagnosed(signals, refit=refit), tmp_path / 'other')
    assert again.joints['elbow'].friction is None


def test_an_identified_rigid_body_counts_more_than_a_drivers_description(model, signals, tmp_path):
    """A driver that was started with the old model does not know better."""
    cause = cause_of(signals, 'gravity', 'elbow', (0.05, 0.0))
    again = round_trip(model, diagnosed(signals, [cause]), tmp_path / 'new')
    q = np.array([0.2, 0.4])
    old = model.make_robot().gravity(q)
    assert again.make_robot(model.urdf).gravity(q) == pytest.approx(again.make_robot().gravity(q))
    assert again.make_robot(model.urdf).gravity(q) != pytest.approx(old)
    # One that was not identified follows the driver.
    assert model.make_robot(again.urdf).gravity(q) != pytest.approx(old)


def test_what_an_earlier_diagnosis_wrote_keeps_its_place_before_the_drivers(
    model, signals, tmp_path
):
    """A second diagnosis that changes no body leaves the first one's URDF in force."""
    cause = cause_of(signals, 'gravity', 'elbow', (0.05, 0.0))
    first = round_trip(model, diagnosed(signals, [cause]), tmp_path / 'first')
    second = round_trip(first, diagnosed(signals), tmp_path / 'second')
    assert second.is_rigid_body_identified
    assert second.provenance['rigid_body']['written'] == ['gravity@elbow']
    q = np.array([0.2, 0.4])
    assert second.make_robot(model.urdf).gravity(q) == pytest.approx(first.make_robot().gravity(q))
