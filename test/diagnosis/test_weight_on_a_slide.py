# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A vertical slide that lifts another mass than the model's is told to, and not to be biased."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import FrictionParameters, JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

CARRIAGE, ROTOR, COULOMB, VISCOUS, GRAVITY = 6.0, 7.0, 28.0, 110.0, 9.81
STEP, NOISE, COUNT = 2.5e-3, 1.2, 3e-7


def model(axis: str = '0 0 1', centre: str = '0 0 0') -> sf.Model:
    """Return the nominal axis, along ``axis``."""
    urdf = (
        '<robot name="lift"><link name="column"/><joint name="lift" type="prismatic">'
        f'<parent link="column"/><child link="carriage"/><axis xyz="{axis}"/>'
        '<limit lower="-0.3" upper="0.3" effort="600" velocity="2"/></joint>'
        f'<link name="carriage"><inertial><origin xyz="{centre}"/><mass value="{CARRIAGE}"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
        '</robot>'
    )
    known = {
        'coulomb': Parameter(COULOMB, 'N'),
        'viscous': Parameter(VISCOUS, 'N s/m'),
        'bias': Parameter(0.0, 'N'),
    }
    friction = FrictionParameters('coulomb_viscous', 0.0, known)
    return sf.Model(
        RobotModelFile('lift', {'lift': JointModel(Parameter(ROTOR, 'kg'), friction)}, urdf)
    )


def log(more: float, seed: int) -> JointLog:
    """Return 40 s of a vertical axis that carries ``more`` kg, moved in seven sines."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(round(40.0 / STEP))
    q, v, a = np.zeros((3, len(t)))
    for hertz in (0.13, 0.29, 0.47, 0.83, 1.3, 1.9, 2.7):
        w, phase, size = 2.0 * np.pi * hertz, rng.uniform(0.0, 6.28), 0.02 / hertz**0.7
        q += size * np.sin(w * t + phase)
        v += size * w * np.cos(w * t + phase)
        a -= size * w**2 * np.sin(w * t + phase)
    tau = (CARRIAGE + more) * (a + GRAVITY) + ROTOR * a + COULOMB * np.sign(v) + VISCOUS * v
    tau += NOISE * rng.standard_normal(len(t))
    seen = COUNT * np.round(q / COUNT)
    return JointLog(
        ('lift',), np.rint(1e9 * t).astype(np.int64), seen[:, None], v[:, None], tau[:, None]
    )


@pytest.mark.parametrize('centre', [in_full('0 0 0'), '0.05 0 0.1'])
@pytest.mark.parametrize('more', [1.5, -1.5])
def test_another_mass_on_a_vertical_slide_is_named(more, centre):
    with warnings.catch_warnings():
        # There is no place where it hangs free, and none is looked for in vain.
        warnings.simplefilter('error', RuntimeWarning)
        found = sf.diagnose(log(more, 5), model(centre=centre))
    (cause,) = found.causes
    assert cause.effect == 'payload'
    assert not cause.rivals
    mass = cause.parameters['mass']
    assert mass.value == pytest.approx(more, abs=0.3)
    # It comes on top of a carriage that is anywhere within its tolerance of 3.5 %.
    assert mass.std_error > 0.035 / np.sqrt(3.0) * CARRIAGE
    (body,) = found.model.content.make_robot().inertial_parameters()
    assert body[0] == pytest.approx(CARRIAGE + more, abs=0.5)


def test_nothing_is_named_where_the_mass_is_that_of_the_model():
    assert sf.diagnose(log(0.0, 6), model()).verdict == 'nothing_above_floor'


def test_a_mass_that_no_weight_pulls_along_its_slide_is_an_inertia():
    settings = DiagnosisSettings()
    for axis, lifts in (('0 0 1', True), ('1 0 0', False)):
        robot = model(axis).content.make_robot()
        signals = prepare([log(0.0, 6)], model(axis).content, robot, settings)[0]
        assert TERMS['payload']().applies(signals, 0) is lifts
