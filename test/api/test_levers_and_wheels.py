# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Robots of one joint that nothing was tuned on: a lever of another weight, and a wheel."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.exceptions import DataError

MASS, ARM, ROTOR, STEP, SEED = 1.5, 0.3, 0.05, 5e-3, 20261123
COULOMB, VISCOUS, NOISE, ENCODER = 0.8, 0.5, 0.05, 2.0 * np.pi / 2**17


def model(mass=MASS, arm=ARM, kind='revolute', rotor=ROTOR):
    """Return a lever that hangs down, or with ``arm`` 0 a wheel."""
    inertia = ''.join(f'i{a}="0.01" ' for a in ('xx', 'yy', 'zz'))
    inertia += ''.join(f'i{a}="0" ' for a in ('xy', 'xz', 'yz'))
    return sf.Model.from_urdf(
        f'<robot name="r"><link name="base"/><joint name="j" type="{kind}"><parent link="base"/>'
        '<child link="l"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="99" '
        f'velocity="99"/></joint><link name="l"><inertial><origin xyz="0 0 {-arm}"/>'
        f'<mass value="{mass}"/><inertia {inertia}/></inertial></link></robot>',
        {'j': rotor},
    )


def recorded(q, arm=ARM):
    """Return a log of a motion (N,) with Coulomb and viscous friction, in equations of its own."""
    rng = np.random.default_rng(SEED)
    v = np.gradient(q, STEP)
    inertia = ROTOR + 0.01 + MASS * arm**2
    tau = inertia * np.gradient(v, STEP) + MASS * 9.81 * arm * np.sin(q)
    tau += COULOMB * np.tanh(v / 2e-3) + VISCOUS * v + NOISE * rng.standard_normal(len(q))
    t = np.round(np.arange(len(q)) * STEP * 1e9).astype(np.int64)
    q = np.round(q / ENCODER) * ENCODER
    return sf.JointLog(('j',), t, *(x[:, None] for x in (q, np.full(len(q), np.nan), tau)))


@pytest.mark.parametrize(
    ('rotor', 'options'),
    [
        in_full(ROTOR, {}),
        in_full(np.nan, {}),
        (ROTOR, {'refit_inertia': True, 'method': 'weak'}),
    ],
)
def test_friction_of_a_lever_whose_weight_is_off_within_the_tolerance_is_within_its_errors(
    rotor, options
):
    t = np.arange(0.0, 60.0, STEP)
    log = recorded(0.3 + 0.7 * np.sin(0.5 * t) + 0.25 * np.sin(2.3 * t + 1.0))
    truth = {'coulomb': COULOMB, 'viscous': VISCOUS, 'bias': 0.0}
    found = sf.fit(log, model(1.025 * MASS, rotor=rotor), **options).conf_int()['j']
    for name, value in truth.items():
        low, high = found[name]
        # One recording: three standard errors, and not the two of the interval.
        assert abs(value - 0.5 * (low + high)) <= 0.75 * (high - low), name
    # Not by being vague: a weight of 2.5 % is 0.11 Nm.
    assert found['coulomb'][1] - found['coulomb'][0] < 0.2 * COULOMB


def test_one_speed_is_refused_though_an_observer_sees_more_where_the_joint_turns_around():
    t = np.arange(0.0, 60.0, STEP)
    sawtooth = np.abs((t / 12.0 + 0.25) % 1.0 - 0.5) * 4.0 - 1.0
    smooth = np.hanning(17) / np.hanning(17).sum()
    with pytest.raises(DataError, match='one speed only'):
        sf.fit(recorded(0.6 * np.convolve(sawtooth, smooth, 'valid')), model())


def test_a_wheel_may_be_anywhere():
    """A simulation that begins 600 turns from zero does not run away."""
    t = np.arange(0.0, 20.0, STEP)
    log = recorded(4000.0 + 20.0 * t - 3.0 * np.cos(t), 0.0)
    run = sf.simulate(log, model(arm=0.0, kind='continuous'))
    assert np.isfinite(run.simulated['position']).all()


def test_one_number_is_the_armature_of_each_joint():
    content = sf.Model.from_urdf(model().content.urdf, ROTOR).content
    assert content.joints['j'].armature.value == ROTOR
