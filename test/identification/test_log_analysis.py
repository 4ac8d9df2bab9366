# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an analysis of a log takes from what was recorded, and what it does not."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.bags.block_means import block_means
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.source import Source
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.data_finding import WARNING
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import analyse_log, effort_holds
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.share import share_directory

RAN = ObserverConfiguration(
    ('slider',), {'first_order': {'cutoff': [37.0]}}, ('end',), 'message', 0.05
)
SETTINGS = FitSettings(method='segments')
SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS', '1'))


@pytest.fixture(scope='module')
def nominal():
    return read_model(share_directory() / 'config' / 'emps')


@pytest.fixture(scope='module')
def log(nominal):
    robot = nominal.make_robot()
    ladder = speed_ladder({'slider': 0.1}, {'slider': 0.12}, [0.01, 0.04, 0.1], plateau_s=0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.004)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += 20.0 * np.sign(v) + 200.0 * v + np.random.default_rng(3).normal(0.0, 0.3, v.shape)
    return JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


def test_effort_holds_as_stated_then_as_recorded_then_from_the_start():
    ran = replace(RAN, joints=('a', 'b'), effort_hold=('end', 'mean'))
    assert effort_holds(['a', 'b'], {'b': 'start'}, ran) == ('end', 'start')
    assert effort_holds(['a', 'b'], {'b': 'end'}, None) == ('start', 'end')
    # Gains of joints in another order are of another robot.
    assert effort_holds(['b', 'a'], {}, ran) == ('start', 'start')
    assert effort_holds(['a', 'b'], {}, replace(ran, effort_hold=())) == ('start', 'start')
    assert effort_holds(['a', 'b'], 'mean', ran) == ('mean', 'mean')
    with pytest.raises(ConfigurationError, match="'c', which is no joint of the model: it has a"):
        effort_holds(['a', 'b'], {'c': 'end'}, ran)


def test_the_observers_that_ran_run_again_unless_others_are_asked_for(log, nominal):
    def run(**options):
        return analyse_log(log, nominal, SETTINGS, recorded=RAN, **options).configuration

    assert run() == RAN
    assert run(effort_hold={'slider': 'mean'}) == replace(RAN, effort_hold=('mean',))
    wider = run(bandwidth=50.0)
    assert set(wider.gains) == {'first_order', 'sosml'}
    assert wider.effort_hold == ('end',)
    assert list(run(observers=['quasi_static']).gains) == ['quasi_static']


def test_controllers_are_asked_for_on_the_samples_that_are_used(log, nominal):
    seen = []

    def controllers(used):
        seen.append(used)
        return {}

    twice = log.rows(np.repeat(np.arange(len(log)), np.where(np.arange(len(log)) < 50, 2, 1)))
    analysis = analyse_log(twice, nominal, SETTINGS, controllers=controllers)
    assert analysis.data_checks.repeated_stamps == 50
    np.testing.assert_array_equal(seen[0].t_ns, log.t_ns)


def test_the_model_says_which_recording_it_rests_on(log, nominal):
    source = Source('run', 'ab' * 32, 'it was cut off after 3 s')
    analysis = analyse_log(log, nominal, SETTINGS, source=source, command='sosml fit run')
    provenance = analysis.model.provenance
    assert (provenance['bag'], provenance['sha256']) == ('run', 'ab' * 32)
    assert provenance['recovered'] is True
    assert provenance['command'] == 'sosml fit run'
    assert provenance['settings']['method'] == 'segments'
    assert source.recovery in analysis.data_checks.sentences
    assert analyse_log(log, nominal, SETTINGS).model.provenance['recovered'] is False


def test_a_long_recording_is_fitted_to_means_and_tells_the_same(log, nominal, monkeypatch):
    whole = analyse_log(log, nominal).fit.joints['slider']['weak_form'].fit
    monkeypatch.setattr(block_means, '__defaults__', ((), len(log) // 2 + 1))
    monkeypatch.setattr('sosml_friction.bags.block_means._LEAST_HZ', 100.0)
    found = analyse_log(log, nominal)
    assert len(found.log) == len(log) // 2
    (said,) = (f.sentence for f in found.data_checks.findings if f.check == 'means')
    assert 'means of 2 samples' in said
    fit = found.fit.joints['slider']['weak_form'].fit
    for name in ('coulomb', 'viscous'):
        one, other = whole.parameters[name], fit.parameters[name]
        # Both have the same noise: they differ by less than its standard error.
        assert abs(one.value - other.value) < one.std_error


def chirp(seed):
    """Return a pendulum in a chirp of 5 s, 0.3 to 3 Hz: it turns around before it is steady."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, 5.0, 1e-3)
    phase = 2.0 * np.pi * (0.3 * t + 0.27 * t**2)
    rate, bend = 2.0 * np.pi * (0.3 + 0.54 * t), 2.0 * np.pi * 0.54
    q, v = 0.5 * np.sin(phase), 0.5 * rate * np.cos(phase)
    a = 0.5 * (bend * np.cos(phase) - rate**2 * np.sin(phase))
    tau = 0.1 * a + 1.0 * 9.81 * 0.3 * np.sin(q) + 0.3 * np.tanh(v / 5e-3) + 0.1 * v
    tau += 0.05 * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 2e-5 * rng.standard_normal(len(t)), tau)


def test_a_recording_too_short_for_the_weak_form_has_the_law_of_the_regression():
    """It had that of SOSML, whose lag its interval does not hold: B 0.085 +- 0.005 of 0.1."""
    model = pendulum_model(1.0, 0.3, 0.0, 0.01, 'joint')
    held = {'coulomb': 0, 'viscous': 0}
    for seed in range(SEEDS):
        found = analyse_log(chirp(seed), model)
        fits = found.fit.joints['joint']
        assert 'weak_form' not in fits
        assert preferred_observer(fits) == 'regression'
        for name, true in (('coulomb', 0.3), ('viscous', 0.1)):
            p = found.model.joints['joint'].friction.parameters[name]
            low, high = p.interval
            held[name] += low < true < high
            assert abs(p.value - true) < 4.0 * p.std_error
            assert p.std_error < 0.05 * true
        assert not [f for f in found.data_checks.findings if f.check == 'observer_law']
    print(f'C and B within their intervals, of {SEEDS}: {held}')
    assert min(held.values()) >= 0.85 * SEEDS - 1


def test_a_law_of_an_observer_is_told_to_be_one():
    """Of bodies and a timing that are exact, as told, no regression is made."""
    model = pendulum_model(1.0, 0.3, 0.0, 0.01, 'joint')
    found = analyse_log(chirp(0), model, FitSettings(body_tolerance=0.0), effort_hold='mean')
    (said,) = (f for f in found.data_checks.findings if f.check == 'observer_law')
    assert (said.joint, said.level) == ('joint', WARNING)
    assert 'an observer, sosml' in said.sentence


def test_a_joint_that_does_not_move_is_left_out_for_that():
    """A robot that ignored its trajectory was said to report no effort, and reported all of it."""
    nominal = read_model(share_directory() / 'config' / 'exoskeleton')
    t = np.arange(0.0, 4.0, 0.004)
    rng = np.random.default_rng(5)
    # An encoder wanders over one of its steps, which is no law; the other stands still.
    q = np.column_stack([-1.4 + 4.8e-5 * (np.arange(len(t)) // 25 % 2), np.full(len(t), 1.2)])
    v = 0.0 * q
    robot = nominal.make_robot()
    tau = np.array([robot.gravity(x) for x in q])
    tau += 0.05 * rng.standard_normal(q.shape)
    rests = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)
    with pytest.raises(DataError, match='elbow does not move while its effort is known') as told:
        analyse_log(rests, nominal)
    assert 'no effort of it' not in str(told.value)
