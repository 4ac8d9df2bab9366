# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Every term of the registry keeps the same promises; one from outside the package as well."""

from __future__ import annotations

import string
from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.laws import FRICTION_LAWS, TERM_LISTS, law_definition
from sosml_friction.model.model_folder import EffectTerm, parse_model, read_model
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, DATA_CAUSES, ROBOT, TERMS
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.share import share_directory
from validation.motion import reference
from validation.plant import Noise, Plant, simulate
from validation.trial import JOINTS, nominal_model

NAMES = sorted(TERMS)
AXES = {'speed', 'position', 'load', 'effort', 'acceleration', 'body', 'displacement', 'time',
        'direction', 'none'}  # fmt: skip


@pytest.fixture(scope='module')
def signals():
    """Return 20 s of two joints, long enough for every term but those of minutes."""
    q, v, a = (x[:10000] for x in reference('rich'))
    run = simulate(Plant(), q, v, a, np.random.default_rng(0), Noise())
    log = JointLog(JOINTS, np.rint(run.t * 1e9).astype(np.int64), run.q, run.v, run.tau)
    model = nominal_model()
    found = prepare([log], model, model.make_robot(), DiagnosisSettings())
    return found[0]


def joint_of(term):
    if not term.of_robot:
        return 1
    return ROBOT if term.counterpart else 0


@pytest.mark.parametrize('name', NAMES)
def test_units_are_of_the_joint_and_names_are_words(name):
    kind = TERMS[name]
    assert kind.identifier == name
    assert kind.__doc__
    for parameter, unit in {**kind.amplitudes, **kind.inner}.items():
        assert parameter.replace('_', '').isalnum()
        fields = {field for _, field, _, _ in string.Formatter().parse(unit) if field}
        assert fields <= {'effort', 'length', 'inertia'}
        assert '{' not in kind.unit(parameter, 'Nm')
        assert 'rad' not in kind.unit(parameter, 'N').replace('rad/m', '') or 'm' not in unit


@pytest.mark.parametrize('name', NAMES)
def test_what_it_says_of_others_are_terms_and_axes_that_exist(name):
    kind = TERMS[name]
    others = {*kind.aliases, *kind.inseparable, *kind.told_apart}
    assert others <= {*TERMS, *DATA_CAUSES}
    assert name not in others
    assert kind.axis in AXES
    assert kind.free_axis in ('', 'speed', 'position')
    assert set(kind.unspoken) <= {*kind.amplitudes, *kind.inner}
    assert set(kind.refined) <= set(kind.inner)
    assert set(kind.reported_as) <= set(kind.amplitudes)


@pytest.mark.parametrize('name', NAMES)
def test_the_grid_is_in_the_physical_range_and_columns_are_finite(signals, name):
    term = TERMS[name]()
    joint = joint_of(term)
    grid = term.grid(signals, joint)
    assert grid
    bounds = term.inner_bounds(signals, joint)
    for inner in grid:
        assert set(inner) == set(term.inner)
        for key, (low, high) in bounds.items():
            assert low <= inner[key] * (1.0 + 1e-9)
            assert inner[key] * (1.0 - 1e-9) <= high
    columns = term.columns(signals, joint, grid[0])
    assert columns.shape == (len(signals.q), 2, len(term.amplitudes))
    assert np.isfinite(columns).all()
    assert columns.any()


@pytest.mark.parametrize('name', NAMES)
def test_what_is_reported_is_restored_through_a_model_file(signals, name):
    term = TERMS[name]()
    joint = joint_of(term)
    inner = term.grid(signals, joint)[0]
    amplitude = np.linspace(0.1, 0.2, len(term.amplitudes))
    fitted = Fitted(signals, joint, inner, amplitude, 0.01 * amplitude)
    where = ALL_JOINTS if term.of_robot else JOINTS[joint]
    model = replace(nominal_model(), effects=(EffectTerm(name, where, term.reported(fitted)),))
    if term.of_law and 'change' not in term.reported(fitted):
        model = replace(
            model, joints={n: replace(j, friction=None) for n, j in model.joints.items()}
        )
    back = parse_model(model.to_yaml(), 'written')
    if back.effects:
        (known,) = known_terms(back)
        assert (type(known.term), known.joint) == (type(term), joint)
        assert known.inner == pytest.approx(inner)
        assert known.amplitude == pytest.approx(amplitude)
    else:
        law = back.joints[where].friction
        own = law.parameters | {k: p for k, p in law.by_term()[0][1].items()}
        assert [own[key].value for key in term.amplitudes] == pytest.approx(list(amplitude))


@pytest.mark.parametrize('name', [n for n in NAMES if issubclass(TERMS[n], EffortTerm)])
def test_columns_are_the_effort_of_the_simulation_along_the_same_motion(signals, name):
    """One function makes both: what is left is the order of sums."""
    term = TERMS[name]()
    joint = joint_of(term)
    inner = term.grid(signals, joint)[0]
    amplitude = np.linspace(0.1, 0.2, len(term.amplitudes))
    simulated = term.simulated(signals.robot, joint, inner, amplitude)
    wanted = term.columns(signals, joint, inner) @ amplitude
    at = np.arange(len(signals.q))
    state = simulated.start(signals.q, at)
    motion = signals.motion
    load = simulated.load(
        Motion(motion.time, motion.q, motion.v, motion.sign, motion.load, motion.warm), state
    )
    np.testing.assert_allclose(load, wanted, atol=1e-12)
    # Its own states, advanced step by step, are those along the path; where a path turns around
    # between samples it is followed to there, which steps are not.
    if state.shape[1]:
        ways = np.diff(signals.q[:, joint])
        turns = np.flatnonzero(ways[1:] * ways[:-1] < 0.0)
        longest = int(np.argmax(np.diff(turns)))
        first, last = (int(k) for k in turns[longest : longest + 2] + 1)
        assert last - first > 50
        now = state[first + 1 : first + 2]
        for k in range(first + 1, last):
            now = simulated.advance(now, (signals.q[k + 1] - signals.q[k])[None])
        np.testing.assert_allclose(now, state[last : last + 1], atol=1e-12)


@pytest.mark.parametrize('name', [n for n in NAMES if issubclass(TERMS[n], MeasurementTerm)])
def test_what_is_reported_is_undone(signals, name):
    term = TERMS[name]()
    amplitude = np.full(len(term.amplitudes), 0.1)
    inner = {**term.grid(signals, 1)[0]}
    simulated = term.simulated(signals.robot, 1, inner, amplitude)
    torque = np.random.default_rng(0).normal(0.0, 3.0, (50, 2))
    reported = simulated.reported(torque)
    assert np.abs(reported - torque).max() > 1e-3
    # Newton's rule to rounding, of numbers of the size of ten.
    np.testing.assert_allclose(simulated.torque(reported), torque, atol=1e-13)


def test_a_name_that_nobody_knows_is_refused_with_those_that_exist():
    with pytest.raises(ConfigurationError, match=r"'lugre' is unknown: use .*coulomb.*viscous"):
        TERMS['lugre']


def test_two_terms_of_one_name_are_refused():
    with pytest.raises(ConfigurationError, match="two terms of the name 'coulomb'"):

        class Coulomb(EffortTerm):
            identifier = 'coulomb'


def test_a_parameter_that_nobody_knows_is_never_dropped():
    path = share_directory() / 'config/emulated_exoskeleton'
    model = read_model(path)
    text = model.to_yaml().replace('    coulomb:\n', '    level:\n', 1)
    assert text != model.to_yaml()
    with pytest.raises(ConfigurationError, match='coulomb has level: give it coulomb'):
        parse_model(text, 'file')


@pytest.mark.parametrize('name', sorted(FRICTION_LAWS))
def test_a_law_is_its_terms_one_by_one(name):
    """In steady motion, with the sign itself."""
    law = law_definition(name)
    values = {key: 0.1 + 0.1 * k for k, key in enumerate(law.parameter_names)}
    v = np.array([-0.4, -0.05, 0.02, 1.0])
    sign = np.sign(v)
    own = {**law.fixed, **values}
    total = own['coulomb'] * sign + own['viscous'] * v + own['bias']
    if 'stribeck' in law.terms:
        fade = np.exp(-((np.abs(v) / own['stribeck_velocity']) ** own['exponent']))
        total = total + own['stribeck'] * sign * fade + own.get('stribeck_asymmetry', 0.0) * fade
    total = total + own.get('viscous_asymmetry', 0.0) * np.abs(v)
    from sosml_friction.model.laws import make_friction_law

    np.testing.assert_allclose(make_friction_law(name, values, 0.0).torque(v), total, atol=1e-14)


def test_the_servo_models_are_nested():
    """Each has what the one before it has; M5's directional load is M3's with two coefficients."""
    lists = [set(TERM_LISTS[f'm{k}']) for k in range(1, 7)]
    assert lists[0] < lists[1] < lists[3]
    assert lists[0] < lists[2] < lists[3]
    general = {'load_dependent_friction'}
    assert lists[3] - general < lists[4] < lists[5]
    assert all(term in TERMS.classes for terms in lists for term in terms)


def test_maxwell_slip_closes_a_small_loop_within_a_large_one():
    """Non-local memory: after an inner loop the outer curve goes on as if it had not been."""
    term = TERMS['maxwell_slip']()
    inner = {'displacement': 1.0}
    outer = np.concatenate([np.linspace(0, 3, 301), np.linspace(3, 2.6, 41)[1:]])
    loop = np.concatenate([np.linspace(2.6, 2.8, 21)[1:], np.linspace(2.8, 2.6, 21)[1:]])
    on = np.linspace(2.6, 1.0, 161)[1:]
    with_loop = term.path_state(np.concatenate([outer, loop, on]), inner)
    without = term.path_state(np.concatenate([outer, on]), inner)
    np.testing.assert_allclose(with_loop[-len(on) :], without[-len(on) :], atol=1e-12)


def test_maxwell_slip_slides_at_the_sum_of_its_levels_and_starts_as_its_springs():
    term = TERMS['maxwell_slip']()
    inner = {'displacement': 1e-3}
    path = np.linspace(0.0, 2e-3, 201)
    z = term.path_state(path, inner)
    np.testing.assert_allclose(z[-1], 1.0)
    # Before the first block slides, each spring has stretched by the same way.
    k = 5
    shares = np.array([0.125, 0.25, 0.5, 1.0])
    np.testing.assert_allclose(z[k], path[k] / (shares * 1e-3))
