# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A list of terms is fitted with its uncertainty; the same numbers as a diagnosis has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from full_runs import FULL

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.term_fit import fit_terms, parse_terms
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import JointModel, RobotModelFile, read_model
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.simulation.recorded.stretch import simulate_windows
from validation import plant as bp
from validation.motion import reference
from validation.trial import JOINTS, nominal_model

#: 20 in make validate.
SEEDS = 20 if FULL else 1
#: A drawn number for the seeds of this file.
SEED = 20261122


def record(seed, duration=None, **joint):
    """Return what the independent plant measures of itself with these numbers."""
    plant = bp.Plant()
    for name, value in joint.items():
        plant.joint[name][:] = value
    rng = np.random.default_rng([SEED, seed])
    run = bp.simulate(plant, *reference('rich', duration), rng, bp.Noise())
    return JointLog(JOINTS, np.rint(run.t * 1e9).astype(np.int64), run.q, run.v, run.tau)


def without_friction():
    model = nominal_model()
    joints = {name: replace(joint, friction=None) for name, joint in model.joints.items()}
    return replace(model, joints=joints)


def of(fit, joint, term):
    return next(t for t in fit.terms if t.joint in (joint, '*') and t.term == term).parameters


def test_load_dependent_friction_is_found_within_5_percent_and_its_interval_covers():
    """On a plant that shares no equation with the fit; 18 of 20 at 95 %, both joints."""
    inside, errors = np.zeros(2), []
    for seed in range(SEEDS):
        k = np.random.default_rng([SEED, 1, seed]).uniform(0.04, 0.12, 2)
        terms = ['coulomb', 'viscous', 'load_dependent_friction']
        fit = fit_terms([record(seed, load=k)], without_friction(), terms)
        for i, joint in enumerate(JOINTS):
            found = of(fit, joint, 'load_dependent_friction')['load_coefficient']
            errors.append(found.value / k[i] - 1.0)
            inside[i] += found.interval[0] <= k[i] <= found.interval[1]
    print(f'{SEEDS} seeds: covered {inside}, error of k {100 * np.mean(errors):+.1f} %, '
          f'largest {100 * np.abs(errors).max():.1f} %')  # fmt: skip
    assert np.abs(errors).max() < 0.05
    assert (inside >= 0.9 * SEEDS).all()


def test_real_joints_whose_friction_grows_with_load_show_it(data_directory):
    """UR10e: independent least squares have .057-.070 and .062-.080, the bars are wider."""
    folder = Path(data_directory) / 'ur10e'
    data = np.loadtxt(folder / '30sec_12harm.csv', delimiter=',')
    gains = np.array([10.0, 10.6956, 8.4566, 9.0029, 9.48, 10.1232])
    armature = (0.0, 3.7434, 0.0, 0.0708, 0.2342, 0.4365)
    names = ('shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',
             'wrist_2_joint', 'wrist_3_joint')  # fmt: skip
    t_ns = np.rint(data[:, 0] * 1e9).astype(np.int64)
    log = JointLog(names, t_ns, data[:, 1:7], data[:, 7:13], data[:, 13:19] * gains)
    joints = {n: JointModel(Parameter(a, 'kg m2')) for n, a in zip(names, armature, strict=True)}
    model = RobotModelFile('ur10e', joints, (folder / 'robot.urdf').read_text())
    fit = fit_terms([log], model, ['coulomb', 'viscous', 'load_dependent_friction'])
    k = [of(fit, n, 'load_dependent_friction')['load_coefficient'].value for n in names]
    print([f'{x:.4f}' for x in k])
    assert 0.050 < k[1] < 0.075
    assert 0.055 < k[2] < 0.085
    pan = names[0]
    assert of(fit, pan, 'coulomb')['coulomb'].value == pytest.approx(13.6, rel=0.1)
    assert of(fit, pan, 'viscous')['viscous'].value == pytest.approx(19.4, rel=0.1)


@pytest.fixture(scope='module')
def loaded():
    """Return a recording whose elbow has friction by load, of 5 %."""
    return record(0, load=[0.0, 0.08])


@pytest.fixture(scope='module')
def found(loaded):
    return diagnose([loaded], nominal_model())


def test_what_a_diagnosis_named_has_the_same_numbers_in_a_fit(loaded, found):
    (cause,) = found.causes
    assert (cause.effect, cause.joint) == ('load_dependent_friction', 'elbow')
    fit = fit_terms([loaded], nominal_model(), ['load_dependent_friction@elbow'])
    (term,) = fit.terms
    for name, parameter in cause.parameters.items():
        assert term.parameters[name].value == parameter.value
        assert term.parameters[name].std_error == parameter.std_error


def test_the_model_of_a_fit_simulates_and_holds_what_was_fitted(loaded, tmp_path):
    fit = fit_terms([loaded], without_friction(), ['m3'])
    fit.model.write(tmp_path / 'fitted')
    again = read_model(tmp_path / 'fitted')
    known = {(k.term.identifier, k.joint): k.amplitude[0] for k in known_terms(again)}
    assert known[('load_dependent_friction', 1)] == pytest.approx(0.08, rel=0.05)
    friction = again.joints['elbow'].friction
    assert friction.law == 'coulomb_viscous'
    assert friction.parameters['coulomb'].value == pytest.approx(bp.COULOMB[1], rel=0.05)
    # Nothing is left: fitted once more beside itself, each term changes by nothing.
    assert (fit.after < fit.before).all()


def test_a_term_that_is_not_there_is_flagged_and_covers_nothing(loaded):
    fit = fit_terms([loaded], nominal_model(), ['load_dependent_friction@shoulder'])
    (term,) = fit.terms
    found = term.parameters['load_coefficient']
    assert NOT_IDENTIFIABLE in found.flags
    assert found.interval[0] < 0.0 < found.interval[1]


@pytest.mark.parametrize(
    ('terms', 'words'),
    [
        (['lugre'], "'lugre' is unknown: use .*coulomb.*, or a list: m1"),
        (['coulomb@knee'], 'unknown joint'),
        (['payload@elbow'], 'all joints together'),
        (['spring@*'], 'acts in one joint'),
        ([], 'no term is named'),
    ],
)
def test_a_list_that_is_wrong_is_refused_in_one_sentence(terms, words):
    with pytest.raises(ConfigurationError, match=words) as caught:
        parse_terms(terms, JOINTS)
    assert '\n' not in str(caught.value)


def test_terms_are_of_all_joints_unless_one_is_named():
    found = parse_terms(['coulomb', 'cogging@elbow', 'effort_delay', 'coulomb'], JOINTS)
    assert found == {
        'shoulder': ('coulomb',), 'elbow': ('coulomb', 'cogging'), '*': ('effort_delay',),
    }  # fmt: skip
    assert parse_terms(['effort_delay@elbow'], JOINTS) == {'elbow': ('effort_delay',)}


@pytest.fixture(scope='module')
def drag():
    """Return a term from outside the package, in the one class that says all of it."""

    class Drag(EffortTerm):
        """Add c q'^2 s: friction that grows with the square of speed."""

        identifier: ClassVar[str] = 'drag'
        amplitudes: ClassVar[dict[str, str]] = {'drag': '{effort} s2/{length}2'}
        axis: ClassVar[str] = 'speed'
        free_axis: ClassVar[str] = 'speed'

        def effort(self, motion, joint, inner, state):
            """Return q'^2 s."""
            return (motion.v[:, joint] ** 2 * motion.sign[:, joint],)

        def implausible(self, fit):
            """Return why such an amplitude is impossible, else ''."""
            return '' if fit.amplitude[0] > 0.0 else 'friction would fall with speed'

    yield Drag
    TERMS.remove('drag')


@pytest.fixture(scope='module')
def dragged():
    return record(3, quadratic=[0.0, 0.05])


def test_a_term_from_outside_is_fitted_simulated_and_written(drag, dragged, tmp_path):
    fit = fit_terms([dragged], without_friction(), ['coulomb', 'viscous', 'drag@elbow'])
    found = of(fit, 'elbow', 'drag')['drag']
    assert found.unit == 'Nm s2/rad2'
    assert found.interval[0] <= 0.05 <= found.interval[1]
    fit.model.write(tmp_path / 'fitted')
    again = read_model(tmp_path / 'fitted')
    (known,) = known_terms(again)
    assert (known.term.identifier, known.joint) == ('drag', 1)
    assert known.amplitude[0] == found.value
    # In the simulation: windows of the recording go less astray with it than without.
    from sosml_friction.model.known_terms import model_friction
    from sosml_friction.simulation.forward_model import ForwardModel

    signals = fit.laboratory.signals[0]
    at = np.linspace(2000, len(signals.q) - 2000, 40).astype(np.int64)

    def astray(terms):
        model = ForwardModel(
            signals.robot, model_friction(again), signals.scales.displacement, terms
        )
        run = simulate_windows(model, signals, at, 150)
        rows = at[:, None] + np.arange(150)
        return np.sqrt(np.mean((run.q - signals.q[rows])[:, :, 1] ** 2))

    assert astray([known.simulated(signals.robot)]) < 0.7 * astray([])


def test_a_term_from_outside_is_named_by_a_diagnosis(drag, dragged):
    diagnosis = diagnose([dragged], nominal_model())
    assert [(c.effect, c.joint) for c in diagnosis.causes] == [('drag', 'elbow')]
    assert 'drag' in diagnosis.sentence
