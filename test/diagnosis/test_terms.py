# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Each effect's term in the simulation does what its columns say, and a model folder holds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.known_terms import known_terms, model_friction
from sosml_friction.model.model_folder import EffectTerm, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, ROBOT, TERMS
from sosml_friction.regression.known_effort import with_known
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import nominal_friction, prepare
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.stretch import simulate_windows

JOINTS = ('shoulder', 'elbow')
COULOMB, VISCOUS = (0.8, 0.15), (0.35, 0.06)
#: Amplitudes and inner parameters of every effect of the library in the shoulder.
SIZES = {
    'coulomb': ([0.24], {}),
    'viscous': ([0.14], {}),
    'stribeck': ([0.32], {'stribeck_velocity': 0.1, 'exponent': 1.3}),
    'asymmetric_friction': ([0.1, 0.05], {'by_speed': 1.0}),
    'load_dependent_friction': ([0.06], {}),
    'position_dependent_friction': ([0.15, 0.1], {'frequency': 2.0}),
    'cogging': ([0.1, 0.06], {'frequency': 20.0}),
    'presliding_hysteresis': ([0.8], {'displacement': 0.03}),
    'hysteresis': ([0.2], {'displacement': 0.3}),
    'joint_elasticity': ([1.0], {'stiffness': 2000.0}),
    'backlash': ([1.0], {'gap': 4e-3, 'stiffness': 3000.0}),
    'effort_scale': ([0.08], {}),
    'effort_saturation': ([0.5], {'reference': 10.0}),
    'effort_bias': ([0.15], {}),
    'effort_delay': ([4e-3], {}),
    'gravity': ([0.05, 0.04], {}),
    'gravity_tilt': ([0.04, 0.05], {}),
    'inertia': ([0.05], {}),
    'payload': ([0.25], {'x': 0.25, 'y': 0.05, 'z': 0.0}),
    'joint_coupling': ([0.08], {'source': 1.0}),
    'spring': ([0.4, 0.2], {}),
    'encoder_eccentricity': ([3e-3, 2e-3], {}),
    'thermal_drift': ([-0.2, -0.2], {'time_constant': 60.0}),
}
#: Share of an effect's error that its term may leave. Most leave less than 0.1 %: terms that are
#: not linear, and columns of first order, leave what is of second order in their size. Columns of
#: a gear leave out how inertia and C q' change with the displacement, that of an encoder friction.
SHARES = {'joint_elasticity': 0.08, 'backlash': 0.06, 'encoder_eccentricity': 0.05,
          'effort_delay': 0.04}  # fmt: skip
SHARE = 0.01
#: Friction turns around so slowly [rad] that samples of 2 ms see it turn.
DISPLACEMENT = 1e-2
SAMPLES = 151


def nominal_model():
    """Return the exoskeleton with Coulomb and viscous friction."""
    return arm_model(*zip(COULOMB, VISCOUS, strict=True))


@pytest.fixture(scope='module')
def signals():
    """Return a smooth motion of the exoskeleton whose effort is that of the nominal model."""
    t = np.arange(0.0, 24.0, 2e-3)
    w = 2.0 * np.pi * np.array([[0.11, 0.43, 1.1], [0.17, 0.53, 1.3]])
    size = np.array([[0.5, 0.2, 0.03], [0.45, 0.22, 0.04]])
    angle = w[:, :, None] * t + np.arange(3.0)[:, None]
    q = (size[:, :, None] * np.sin(angle)).sum(axis=1).T
    t_ns = np.rint(t * 1e9).astype(np.int64)
    log = JointLog(JOINTS, t_ns, q, np.full_like(q, np.nan), np.zeros_like(q))
    model = nominal_model()
    s = prepare([log], model, model.make_robot(), DiagnosisSettings(band=20.0))[0]
    scales = replace(s.scales, displacement=np.full(2, DISPLACEMENT))
    sign = np.column_stack([dahl_path(np.ascontiguousarray(x), DISPLACEMENT) for x in s.q.T])
    friction = nominal_friction(s.v, sign, scales)
    s = replace(s, sign=sign, scales=scales, friction=friction)
    return replace(s, tau=s.torque)


def astray(signals, tau, terms):
    """Return the root mean square error of position of windows that are driven by ``tau``."""
    model = nominal_model()
    forward = ForwardModel(
        signals.robot, model_friction(model), signals.scales.displacement, terms
    )
    at = np.arange(3000, len(signals.q) - 700, 173)
    run = simulate_windows(forward, replace(signals, tau=tau), at, SAMPLES)
    rows = at[:, None] + np.arange(SAMPLES)
    return float(np.sqrt(np.mean((run.q - signals.q[rows]) ** 2)))


def test_the_nominal_model_moves_as_it_was_measured(signals):
    # Samples on lines in between: 3 urad in windows that move by 0.1 rad.
    assert astray(signals, signals.torque, []) < 1e-5


@pytest.mark.parametrize('name', searched_terms())
def test_with_its_term_the_simulation_follows_effort_that_has_the_effects_columns(signals, name):
    """The same effort moves the nominal model elsewhere, and the model with the term as told."""
    effect = TERMS[name]()
    amplitude, inner = np.array(SIZES[name][0]), SIZES[name][1]
    tau = signals.torque + effect.columns(signals, 0, inner) @ amplitude
    without = astray(signals, tau, [])
    term = effect.simulated(signals.robot, 0, inner, amplitude)
    assert without > 3e-4
    assert astray(signals, tau, [term]) < SHARES.get(name, SHARE) * without
    # A term of the other sign would make it worse: the test knows the sign.
    if 'amplitude' not in effect.amplitudes and name != 'presliding_hysteresis':
        assert (
            astray(signals, tau, [effect.simulated(signals.robot, 0, inner, -amplitude)]) > without
        )


@pytest.mark.parametrize('name', searched_terms())
def test_a_model_folder_holds_the_effect_and_the_signals_have_it(signals, name, tmp_path):
    effect = TERMS[name]()
    amplitude, inner = np.array(SIZES[name][0]), SIZES[name][1]
    fit = Fitted(signals, 0, inner, amplitude, np.zeros(len(amplitude)))
    parameters = effect.reported(fit)
    where = ALL_JOINTS if effect.of_robot else 'shoulder'
    model = replace(nominal_model(), effects=(EffectTerm(name, where, parameters),))
    model.write(tmp_path)
    model = read_model(tmp_path)
    if effect.of_law and 'change' not in parameters:  # Then it is in the joint's law.
        friction = model.joints['shoulder'].friction
        assert friction is not None
        values = [friction.parameters[key].value for key in (*effect.amplitudes, *effect.inner)]
        assert values == pytest.approx([*amplitude, *inner.values()])
        return
    (found,) = known_terms(model)
    joint = ROBOT if effect.of_robot and effect.counterpart else 0
    assert (found.term.identifier, found.joint, found.inner) == (name, joint, inner)
    assert found.amplitude == pytest.approx(amplitude)
    (extended,) = with_known([signals], model)
    wanted = effect.columns(signals, 0, inner) @ amplitude
    assert extended.torque - signals.torque == pytest.approx(wanted, abs=1e-12)


def test_harmonics_are_terms_of_their_own():
    p = {'cosine': 0.1, 'sine': 0.2, 'frequency': 7.0,
         'cosine_2': 0.3, 'sine_2': 0.4, 'frequency_2': 14.0}  # fmt: skip
    entry = EffectTerm('cogging', 'elbow', {k: Parameter(v, '1') for k, v in p.items()})
    found = known_terms(replace(nominal_model(), effects=(entry,)))
    assert [(f.joint, f.inner['frequency']) for f in found] == [(1, 7.0), (1, 14.0)]
    assert found[1].amplitude == pytest.approx([0.3, 0.4])


@pytest.mark.parametrize(
    ('effect', 'joint', 'parameters', 'what'),
    [
        ('stiction', 'elbow', {}, 'unknown'),
        ('spring', '*', {'stiffness': 1.0, 'offset': 0.0}, 'one joint'),
        ('gravity_tilt', 'elbow', {'gravity_x': 1e-3}, 'all joints'),
        ('spring', 'elbow', {'stiffness': 1.0}, 'has no offset'),
        ('coulomb', 'elbow', {'change': float('nan')}, 'no value of change'),
        ('coulomb', 'elbow', {'change': 0.1, 'size': 1.0}, 'unknown parameter size'),
    ],
)
def test_an_effect_that_cannot_be_read_is_refused_in_a_sentence(effect, joint, parameters, what):
    entry = EffectTerm(effect, joint, {k: Parameter(v, '1') for k, v in parameters.items()})
    with pytest.raises(ConfigurationError, match=what):
        known_terms(replace(nominal_model(), effects=(entry,)))


def test_faults_of_the_data_are_no_terms():
    entries = tuple(EffectTerm(name, '*', {}) for name in ('velocity_lag', 'dropped_samples'))
    assert known_terms(replace(nominal_model(), effects=entries)) == []
