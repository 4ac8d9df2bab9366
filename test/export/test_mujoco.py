# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo does what the model says: read from MJCF, written into it, and stepped."""

from __future__ import annotations

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from known_robots import arm_model

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.cli.main import main
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.motion import recorded_motion
from sosml_friction.export.mjcf import MjcfTarget
from sosml_friction.export.urdf import UrdfTarget
from sosml_friction.model.known_terms import read_term
from sosml_friction.model.model_folder import EffectTerm, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.model.urdf_bodies import with_bodies, with_turned_base
from sosml_friction.mujoco import Friction, apply_friction
from sosml_friction.mujoco.engine import compiled
from sosml_friction.mujoco.reading import model_of, read_mjcf
from sosml_friction.mujoco.writing import write_mjcf
from sosml_friction.share import share_directory
from validation.mujoco_round_trip import bench_model, round_trip

DOWN = (9.81 * np.array([1.0, 2.0, -9.0]) / np.sqrt(86.0)).tolist()
ARM = f"""<mujoco><compiler angle="radian"/>
<option gravity="{' '.join(map(repr, DOWN))}"/><worldbody>
<body name="base" pos=".1 .2 .3" euler=".3 1.5707963267948966 .2">
<inertial pos="0 0 .1" mass="2" diaginertia=".01 .02 .015"/>
<body name="a" pos="0 .1 .2" euler=".5 -.3 .2">
<joint name="j1" axis="1 2 .3" pos=".02 .03 -.04" ref=".4" armature=".02" damping=".1"
 frictionloss=".3"/>
<joint name="j2" type="slide" axis="0 .2 1" pos=".1 0 .05" ref="-.1" armature=".5"/>
<inertial pos=".02 .1 .2" mass="1.5" fullinertia=".02 .03 .025 .002 .001 -.003"/>
<body pos=".2 .1 0"><geom type="box" size=".1 .05 .02" pos=".01 .02 .03" euler=".1 .2 .3"/>
<body name="c" pos=".1 -.2 .3" euler="0 1.5707963267948966 0">
<joint name="j3" axis="0 1 0" stiffness="2" springref=".3" pos=".01 .02 .03"/>
<geom type="capsule" fromto="0 0 0 .1 .2 .3" size=".03"/></body>
</body></body></body></worldbody></mujoco>"""


def parameter_of(kind, name, value=0.3):
    return Parameter(value, kind.unit(name, 'Nm'))


def with_term(kind, value=0.3):
    """Return the bench's pendulum with one term more."""
    parameters = {name: parameter_of(kind, name) for name in (*kind.amplitudes, *kind.inner)}
    return bench_model((EffectTerm(kind.identifier, 'joint', parameters),))


def needed(m, q, v, a):
    """Return M a + C v + g of MuJoCo's bodies."""
    d = mujoco.MjData(m)
    d.qpos[:], d.qvel[:], d.qacc[:] = q, v, a
    mujoco.mj_inverse(m, d)
    return d.qfrc_inverse + d.qfrc_passive + d.qfrc_constraint


def test_bodies_of_an_mjcf_are_those_of_the_model_to_rounding():
    m = compiled(ARM)
    robot = model_of(m, 'arm').make_robot()
    rng = np.random.default_rng(0)
    for _ in range(20):
        q, v, a = rng.uniform(-2.0, 2.0, (3, 3))
        np.testing.assert_allclose(robot.inverse_dynamics(q, v, a), needed(m, q, v, a), atol=1e-9)


def test_friction_of_nothing_is_not_known_and_springs_are_terms():
    model = model_of(compiled(ARM), 'arm')
    assert model.joints['j3'].friction is None
    assert model.joints['j1'].friction.parameters['coulomb'].value == 0.3
    assert model.joints['j1'].friction.parameters['viscous'].value == 0.1
    assert model.joints['j2'].armature == Parameter(0.5, 'kg')
    (spring,) = model.effects
    assert spring.parameters['stiffness'].value == 2.0
    assert spring.parameters['offset'].value == pytest.approx(-0.6)
    assert model.of_measured(['j1', 'j3']).joint_names == ('j1', 'j3')


def test_a_joint_that_follows_another_follows_it():
    tie = '<equality><joint joint1="j3" joint2="j1" polycoef=".1 .5 0 0 0"/></equality></mujoco>'
    robot = model_of(compiled(ARM.replace('</mujoco>', tie)), 'arm')
    robot = replace(robot, effects=()).with_locked({'j2': -0.1})
    robot = replace(robot, joints={'j1': robot.joints['j1']}).make_robot()
    q, m = np.array([0.9]), compiled(ARM)
    # Both are from where they are at rest: 0.4 and 0.
    whole = np.array([0.9, -0.1, 0.1 + 0.5 * (0.9 - 0.4)])
    pull = needed(m, whole, np.zeros(3), np.zeros(3))
    assert robot.gravity(q)[0] == pytest.approx(pull[0] + 0.5 * pull[2], abs=1e-9)


@pytest.mark.parametrize(
    ('old', 'new', 'said'),
    [
        ('<option gravity', '<option integrator="Euler"/><option flag="', 'MuJoCo cannot read'),
        ('name="c"', 'name="c" gravcomp="1"', 'body c of the MJCF has gravcomp'),
        (f'gravity="{DOWN[0]!r}', 'gravity="0.0', 'gravity of the MJCF is'),
        ('name="j', 'user="', 'no hinge or slide with a name'),
    ],
)
def test_what_no_model_has_is_refused(old, new, said, tmp_path):
    text = ARM.replace(old, new)
    if 'user=' in new:
        text = ARM.replace('name="j1"', '').replace('name="j2"', '').replace('name="j3"', '')
    (tmp_path / 'arm.xml').write_text(text)
    with pytest.raises(ConfigurationError, match=said):
        read_mjcf(tmp_path / 'arm.xml')


def test_other_bodies_and_another_stand_are_written_back(tmp_path):
    base = tmp_path / 'arm.xml'
    base.write_text(ARM)
    before = read_mjcf(base)
    robot = before.make_robot()
    bodies = robot.inertial_parameters()
    bodies[2] *= 1.1
    bodies[1, 0] += 0.2
    urdf = with_bodies(before.urdf, {'j3': bodies[2], 'j2': bodies[1]})
    after = replace(before, urdf=with_turned_base(urdf, np.array([0.1, -0.2, 0.0])))
    constants = {name: {'coulomb': 0.2, 'viscous': 0.1} for name in before.joints}
    text = write_mjcf(after, constants, ['note'], base, before)
    found = model_of(compiled(text), 'arm').make_robot()
    q, v, a = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 3))
    wanted = after.make_robot().inverse_dynamics(q, v, a)
    np.testing.assert_allclose(found.inverse_dynamics(q, v, a), wanted, atol=1e-9)


def test_effort_in_mujoco_is_that_of_the_plant():
    # 1 % with the module; what constants cost is told beforehand; half of Coulomb friction holds.
    found = round_trip(speeds=(0.2,), rounds=12)
    assert found.shares['module'] < 0.01
    # No other constants are a tenth better in MuJoCo than those that are written.
    assert 0.9 * found.shares['constants'] < found.least
    assert found.stated == pytest.approx(found.shares['constants'], rel=0.2)
    assert found.creep < 1e-5


@pytest.mark.parametrize(
    'name', sorted(n for n, kind in TERMS.classes.items() if issubclass(kind, EffortTerm))
)
def test_the_module_applies_each_term_by_its_own_equation(name):
    kind = TERMS[name]
    model = with_term(kind)
    text = MjcfTarget().text(bench_model())
    m = compiled(text)
    d = mujoco.MjData(m)
    d.qpos[:], d.qvel[:], d.time = 0.3, -0.2, 40.0
    mujoco.mj_forward(m, d)
    found = []
    for content in (bench_model(), model):
        Friction(m, content).apply(m, d)
        found.append([m.dof_frictionloss[0], -d.qfrc_applied[0], m.dof_damping[0]])
    level, both, slope = np.subtract(found[1], found[0])
    # Half of the difference of both signs, and half of the sum.
    load = d.qfrc_bias + (needed(m, d.qpos, 0.0, d.qacc) - needed(m, d.qpos, 0.0, 0.0))
    load = load - m.dof_armature * d.qacc
    (known,) = read_term(model.effects[0], model)
    efforts = []
    for sign in (1.0, -1.0):
        motion = Motion(np.array([40.0]), *(np.array([[x]]) for x in (0.3, -0.2, sign)),
                        load[:, None], np.array([[np.nan]]))  # fmt: skip
        state = known.term.path_state(np.zeros(1), known.inner)
        parts = known.term.effort(motion, 0, known.inner, state)
        efforts.append(float(sum(x * p[0] for x, p in zip(known.amplitude, parts, strict=True))))
    if name == 'viscous':
        assert slope == pytest.approx(0.3)
        return
    assert both == pytest.approx(0.5 * sum(efforts), abs=1e-12)
    wanted = max(found[0][0] + 0.5 * (efforts[0] - efforts[1]), 0.0) - found[0][0]
    assert level == pytest.approx(wanted, abs=1e-12)


def test_a_state_goes_with_the_joint_and_starts_again_with_the_clock():
    model = with_term(TERMS['presliding_hysteresis'])
    m = compiled(MjcfTarget().text(model))
    d = mujoco.MjData(m)
    efforts = []
    for q in (0.0, 0.1, 5.0):
        d.qpos[0], d.time = q, q
        apply_friction(m, d)
        efforts.append(-d.qfrc_applied[0])
    # F z, from nothing to F.
    assert efforts[0] == 0.0 < efforts[1] < efforts[2]
    assert efforts[2] == pytest.approx(0.3, rel=1e-3)
    mujoco.mj_resetData(m, d)
    apply_friction(m, d)
    assert d.qfrc_applied[0] == 0.0


def test_ripple_is_an_actuator_of_its_own_and_leaves_ctrl_alone():
    model = with_term(TERMS['cogging'])
    m = compiled(MjcfTarget().text(model))
    d = mujoco.MjData(m)
    for q in (0.0, 1.0, 7.0):
        d.qpos[0] = q
        mujoco.mj_forward(m, d)
        expected = 0.3 * np.cos(0.3 * q) + 0.3 * np.sin(0.3 * q)
        assert -d.qfrc_actuator[0] == pytest.approx(expected, abs=1e-9)
    assert m.nu == 0
    apply_friction(m, d)
    assert d.qfrc_applied[0] == 0.0


def test_a_reported_effort_is_scaled_and_late():
    effects = (
        EffectTerm('effort_scale', 'joint', {'error': Parameter(0.1, '1')}),
        EffectTerm('effort_delay', '*', {'delay': Parameter(4e-3, 's')}),
        EffectTerm('backlash', 'joint', {
            'amplitude': Parameter(1.0, '1'), 'gap': Parameter(1e-3, 'rad'),
            'stiffness': Parameter(1e3, 'Nm/rad')}),
    )  # fmt: skip
    friction = Friction(compiled(MjcfTarget().text(bench_model())), bench_model(effects))
    said = [friction.reported(2e-3 * k, np.array([float(k)]))[0] for k in range(6)]
    np.testing.assert_allclose(said, 1.1 * np.array([0.0, 0.0, 0.0, 1.0, 2.0, 3.0]))
    np.testing.assert_allclose(friction.torques(np.array([1.1])), [1.0])
    assert friction.left_out == ['backlash of joint']


def test_each_joint_reports_as_late_as_it_is():
    delays = {'shoulder': 4e-3, 'elbow': -2e-3, '*': 2e-3}
    effects = tuple(
        EffectTerm('effort_delay', joint, {'delay': Parameter(delay, 's')})
        for joint, delay in delays.items()
    )
    arm = replace(arm_model(), effects=effects)
    friction = Friction(compiled(MjcfTarget().text(arm)), arm)
    said = np.array([friction.reported(2e-3 * k, np.full(2, float(k))) for k in range(6)])
    np.testing.assert_array_equal(said.T, [[0, 0, 0, 0, 1, 2], [0, 1, 2, 3, 4, 5]])


def test_what_the_module_needs_is_asked_for():
    bare = (
        '<mujoco><worldbody><body><joint name="{}"/><geom size=".1"/></body></worldbody></mujoco>'
    )
    m = compiled(bare.format('joint'))
    with pytest.raises(ConfigurationError, match='holds no model'):
        apply_friction(m, mujoco.MjData(m))
    with pytest.raises(ConfigurationError, match='compiled without frictionloss'):
        Friction(m, bench_model())
    with pytest.raises(ConfigurationError, match='has no joint joint'):
        Friction(compiled(bare.format('other')), bench_model())


def test_ones_own_mjcf_keeps_what_it_has_wherever_it_is_written(tmp_path, monkeypatch, capsys):
    own = tmp_path / 'own'
    own.mkdir()
    (own / 'arm.xml').write_text(
        '<mujoco><option timestep="0.001"/><!-- mine --><worldbody><include file="body.xml"/>'
        '</worldbody><actuator><motor name="m" joint="joint"/></actuator></mujoco>'
    )
    (own / 'body.xml').write_text(
        '<mujoco><body><joint name="joint" axis="0 1 0" damping="9"/><geom size=".1"/>'
        '</body></mujoco>'
    )
    model = bench_model()
    model.write(tmp_path / 'fit')
    assert read_mjcf(own / 'arm.xml').joints['joint'].friction.parameters['viscous'].value == 9.0
    monkeypatch.chdir(tmp_path)
    command = ['export', 'fit', '--to', 'mjcf', '--mjcf', 'own/arm.xml', '--out', 'new.xml']
    assert main(command) == 0
    out = capsys.readouterr().out
    assert 'mjcf cannot hold: stribeck of joint' in out
    m = mujoco.MjModel.from_xml_path('new.xml')
    assert m.nu == 1
    assert m.dof_damping[0] < 1.0
    assert m.dof_solref[0, 0] == pytest.approx(2e-3)
    again = ['export', 'fit', '--to', 'mjcf', '--mjcf', 'new.xml', '--out', 'newer.xml']
    assert main(again) == 0
    assert mujoco.MjModel.from_xml_path('newer.xml').ntext == 1
    assert main(['export', 'fit', '--to', 'urdf', '--mjcf', 'own/arm.xml']) == 2
    assert 'urdf takes no --mjcf' in capsys.readouterr().err


def test_a_model_without_urdf_is_a_snippet_to_be_included(tmp_path):
    (tmp_path / 'snippet.xml').write_text(MjcfTarget().text(replace(bench_model(), urdf=None)))
    (tmp_path / 'arm.xml').write_text(
        '<mujoco><include file="snippet.xml"/><worldbody><body><joint name="joint" class="joint"/>'
        '<geom size=".1"/></body></worldbody></mujoco>'
    )
    m = mujoco.MjModel.from_xml_path(str(tmp_path / 'arm.xml'))
    assert m.dof_frictionloss[0] == pytest.approx(0.8)
    d = mujoco.MjData(m)
    apply_friction(m, d)
    assert m.dof_frictionloss[0] == pytest.approx(1.3)


def test_what_is_no_friction_costs_what_its_columns_say(tmp_path):
    scale = EffectTerm('effort_scale', 'joint', {'error': Parameter(0.1, '1')})
    model = bench_model((scale,))
    t = np.arange(0.0, 8.0, 2e-3)
    q, v, a = 0.5 * np.sin(2.0 * t), np.cos(2.0 * t), -2.0 * np.sin(2.0 * t)
    robot = model.make_robot()
    tau = np.array([robot.inverse_dynamics(*np.array(x)[:, None])[0]
                    for x in zip(q, v, a, strict=True)])  # fmt: skip
    tau += model.friction_laws()[0].torque(v)
    stamps = np.rint(t * 1e9).astype(np.int64)
    log = JointLog(('joint',), stamps, q[:, None], v[:, None], tau[:, None])
    write_joint_log(log, tmp_path / 'bag', model.urdf)
    motion = recorded_motion(model, tmp_path / 'bag')
    said = UrdfTarget(motion).losses(model)
    assert said[0].startswith('joint: without stribeck the effort is wrong by')
    size, rotor = (float(re.search(r'wrong by \D*([\d.]+) Nm', x)[1]) for x in said[1:])
    assert size == pytest.approx(0.1 * np.sqrt(np.mean(tau**2)), rel=0.05)
    assert rotor == pytest.approx(0.005 * np.sqrt(np.mean(a**2)), rel=0.05)
    # What a target holds is not lost: MJCF has a field for the rotor.
    assert len(MjcfTarget(motion).losses(model)) == 2
    shipped = read_model(share_directory() / 'config/emulated_exoskeleton')
    partly = replace(shipped, provenance={'not_known': {'elbow': 'not yet'}})
    write_joint_log(replace(log, names=('shoulder',)), tmp_path / 'other')
    with pytest.raises(ConfigurationError, match='has not all joints of model'):
        recorded_motion(partly, tmp_path / 'other')


def test_a_point_mass_is_exported():
    """MuJoCo itself refuses a body without inertia about its centre."""
    model = pendulum_model(1.0, 0.25, armature=0.002)
    again = compiled(write_mjcf(model, {'joint': {'coulomb': 0.3, 'viscous': 0.05}}, []))
    assert again.body_mass[-1] == 1.0
    assert again.body_inertia[-1] == pytest.approx(0.0, abs=1e-11)
    assert again.dof_armature[0] == 0.002
