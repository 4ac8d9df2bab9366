# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The gate on the simulation of data left out, and a model that already has its effects."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, sines, slider_model

from sosml_friction.diagnosis.decision.forward_gain import ForwardGain, gets_worse, reversal_term
from sosml_friction.diagnosis.decision.remainder import Remainder
from sosml_friction.diagnosis.decision.verdict import verdict_of
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.extended_model.gain import make_gain
from sosml_friction.diagnosis.wording import sentence_of
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.simulation.recorded.stretch import simulate_windows

COULOMB, VISCOUS, SLIP = 20.0, 200.0, 5e-5
#: Hidden: friction by direction [N s/m] and a force that repeats every 20 mm [N, rad/m].
ASYMMETRY, FORCE, FREQUENCY = 60.0, 3.0, 100.0 * np.pi


@pytest.fixture(scope='module')
def nominal():
    return slider_model()


def make_log(duration, seed):
    """Return a slider whose effort has two effects that the nominal model does not have."""
    t = np.arange(0.0, duration, 4e-3)
    q, v, a = sines(t, ((0.05, 0.7), (0.02, 2.3), (0.01, 4.1)))
    tau = SLIDER_MASS * a + COULOMB * dahl_path(q, SLIP) + VISCOUS * v
    tau += ASYMMETRY * np.abs(v) + FORCE * np.cos(FREQUENCY * q + 0.4)
    tau += np.random.default_rng(seed).normal(0.0, 1.0, len(t))
    return recording(('slider',), t, q, tau)


@pytest.fixture(scope='module')
def found(nominal):
    return diagnose([make_log(28.0, 0)], nominal)


def test_both_are_named_and_the_simulation_of_data_left_out_gets_better(found):
    effects = {cause.effect for cause in found.causes}
    assert effects == {'asymmetric_friction', 'cogging'}
    assert found.gain.forward_after[0] < 0.4 * found.gain.forward_before[0]
    assert found.gain.horizon_s == 0.3


def test_with_the_extended_model_nothing_is_left_to_name(found, nominal, tmp_path):
    extended_model(nominal, found, {}).write(tmp_path)
    model = read_model(tmp_path)
    assert len(known_terms(model)) == 2
    again = diagnose([make_log(28.0, 0)], model)
    assert again.verdict == 'nothing_above_floor'
    assert again.causes == ()
    # What was left before is where the error now begins, to a few percent of refitting, and the
    # simulation's to twice its standard error.
    assert again.gain.inverse_before == pytest.approx(found.gain.inverse_after, rel=0.05)
    error = float(found.gain.forward_error[0] * found.gain.forward_before[0])
    assert again.gain.forward_before == pytest.approx(found.gain.forward_after, abs=2.0 * error)


def test_another_recording_is_simulated_with_the_extended_model(found, nominal):
    """Its error there is that of noise alone, and an eighth of that of the refitted nominal."""
    laboratory, selection = found.laboratory, found.selection
    other = replace(laboratory.signals[0], time=laboratory.signals[0].time + 100.0)
    forward = ForwardGain(laboratory, nominal, [other])
    before = forward.squares((), selection.before.x, selection.before.fold_x)
    after = forward.squares(selection.accepted, selection.after.x, selection.after.fold_x)
    # Of 28 s, less the filter's ends, in windows of 0.3 s that do not overlap.
    assert 80 < len(before) == len(after) <= 28.0 / 0.3
    assert np.sqrt(after.mean()) < 0.4 * np.sqrt(before.mean())


def test_a_cause_of_another_sign_or_without_inertia_makes_it_worse(found, nominal):
    laboratory, selection = found.laboratory, found.selection
    forward = ForwardGain(laboratory, nominal)
    x, folds = selection.after.x, selection.after.fold_x
    p = len(laboratory.nominal.names)
    rows = np.array([0])
    before = forward.squares((), selection.before.x, selection.before.fold_x)
    assert not gets_worse(before, forward.squares(selection.accepted, x, folds), rows)
    turned = np.where(np.arange(len(x)) < p, x, -x)
    turned_folds = np.where(np.arange(len(x)) < p, folds, -folds)
    worse = forward.squares(selection.accepted, turned, turned_folds)
    assert gets_worse(before, worse, rows)
    index = laboratory.nominal.names.index('slider armature')
    gone, gone_folds = x.copy(), folds.copy()
    gone[index] = gone_folds[:, index] = -2.0 * SLIDER_MASS
    assert np.isinf(forward.squares(selection.accepted, gone, gone_folds)).all()


@pytest.mark.parametrize('size', [1e153, 1e200])
def test_a_simulation_that_runs_away_is_infinite_and_warns_of_nothing(
    found, nominal, monkeypatch, size
):
    """The larger overflows as it is squared, the smaller as its square is."""
    laboratory, selection = found.laboratory, found.selection
    forward, fit = ForwardGain(laboratory, nominal), selection.before
    before = forward.squares((), fit.x, fit.fold_x)
    place = 'sosml_friction.diagnosis.decision.forward_gain.simulate_windows'
    monkeypatch.setattr(
        place, lambda *args: replace(run := simulate_windows(*args), q=size * run.q)
    )
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        away = forward.squares((), fit.x, fit.fold_x)
        assert np.isinf(away).all()
        assert gets_worse(before, away, np.array([0]))
        gain = make_gain(*np.ones((3, 4, 1)), before, away, 0.3, 'folds left out')
    said = sentence_of('named', found.causes, gain, selection, ('slider',), ('N',))
    assert 'a simulation of 0.3 s runs away after.' in said
    assert 'inf' not in said


def test_a_model_that_is_impossible_once_others_are_left_out_is_left_out_too(
    found, nominal, monkeypatch
):
    """Without the windows of a model the others' posture is another one, and so is inertia."""
    laboratory, fit = found.laboratory, found.selection.before
    gain = ForwardGain(laboratory, nominal)
    usual = gain.squares((), fit.x, fit.fold_x)
    assert np.isfinite(usual).all()
    asked = []

    def possible(model, signals, at):
        """Refuse the second model with all windows, and the second of those left then."""
        asked.append(len(at))
        return not (asked.count(len(at)) == 2 and len(set(asked)) < 3)

    monkeypatch.setattr(
        'sosml_friction.diagnosis.decision.forward_gain.can_be_simulated', possible
    )
    left = gain.squares((), fit.x, fit.fold_x)
    gone = ~np.isfinite(left)[:, 0]
    assert len(set(asked)) == 3
    assert gone.sum() == len(usual) - min(asked)
    assert left[~gone] == pytest.approx(usual[~gone], rel=1e-9)


def test_worse_is_what_exceeds_its_standard_error():
    rng = np.random.default_rng(0)
    before = 1.0 + rng.uniform(0.0, 1.0, (200, 2))
    rows = np.array([0, 1])
    noise = rng.normal(0.0, 0.3, (200, 2))
    noise -= noise.mean(axis=0)
    assert not gets_worse(before, before + noise, rows)
    assert not gets_worse(before, before + noise - 0.2, rows)
    assert gets_worse(before, before + noise + 0.2, rows)
    # One and a half standard errors are chance, as often as once in 15; three are not.
    error = np.std((noise / before.mean(axis=0)).mean(axis=1)) / np.sqrt(200)
    for times, worse in ((1.5, False), (3.0, True)):
        more = times * error * before.mean(axis=0)
        assert gets_worse(before, before + noise + more, rows) == worse
    assert gets_worse(before, np.where(np.arange(200)[:, None] == 7, np.inf, before), rows)
    assert not gets_worse(before[:0], before[:0], rows)
    # A window that runs away with and without says nothing of the others.
    away = np.where(np.arange(200)[:, None] == 7, np.inf, before)
    assert not gets_worse(away, 0.1 * away, rows)
    assert gets_worse(away, 2.0 * away, rows)
    # Only the cause's own joints count.
    assert not gets_worse(before, before + np.array([-0.1, 5.0]), np.array([0]))


@pytest.mark.parametrize(('turn', 'share'), [('sooner', 0.3), ('later', 2.0), ('shape', None)])
def test_friction_that_turns_around_otherwise_is_what_the_state_says(turn, share):
    path = 1e-3 * np.sin(np.linspace(0.0, 12.0, 400))
    s = dahl_path(path, 1e-4)
    wanted = s * (1.0 - s**2) if share is None else dahl_path(path, share * 1e-4) - s
    term = reversal_term(None, 0, turn, 0.7, 1e-4)
    at = np.arange(400)
    still = np.zeros((400, 1))
    motion = Motion(np.zeros(400), path[:, None], still, s[:, None], still, still)
    load = term.load(motion, term.start(path[:, None], at))
    assert load[:, 0] == pytest.approx(0.7 * wanted, abs=1e-12)


def test_what_the_simulation_takes_back_is_not_called_chance(found, nominal, monkeypatch):
    """What is left is judged anew without it, and the sentence says why nothing is named."""
    assert not found.selection.remainder.beyond_chance
    monkeypatch.setattr(
        'sosml_friction.diagnosis.decision.forward_gate.gets_worse', lambda *_: True
    )
    refused = diagnose([make_log(28.0, 0)], nominal)
    assert refused.causes == ()
    assert refused.verdict == 'unknown_structure'
    assert refused.selection.remainder.beyond_chance
    assert 'but the forward simulation of data left out gets worse with it. ' in refused.sentence
    # It is no all-clear where no curve shows what it stood for, either.
    alone = replace(refused.selection, remainder=Remainder())
    assert verdict_of((), alone) == 'unknown_structure'
    assert verdict_of((), replace(alone, rejected=None)) == 'nothing_above_floor'
