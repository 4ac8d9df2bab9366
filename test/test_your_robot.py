# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/your_robot.md, on recordings of a plant that is integrated here."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.simple_models import pendulum_model

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / 'docs' / 'your_robot.md'
MASS, LENGTH, KT, ARMATURE = 1.0, 0.25, 1.8, 0.003
#: Of the rotor, which is a twentieth of the body: what the regression's band blurs is less.
ARMATURE_WITHIN = 0.1
COULOMB, VISCOUS = 0.3, 0.05
#: Of what 30 s of this motion tell: three standard errors are less than that.
COULOMB_WITHIN, VISCOUS_WITHIN = 0.03, 0.15


def swing(armature):
    """
    Return t, q and torque of the pendulum under a PD loop, by semi-implicit Euler at 5 kHz.

    Friction is Coulomb's, smooth below 1 mrad/s, and viscous. It is a plant of its own, which
    shares no code with the package.
    """
    step, every = 2e-4, 20
    inertia = MASS * LENGTH**2 + armature
    q = v = torque = 0.0
    rows = []
    for k in range(round(30.0 / step)):
        t = k * step
        if k % every == 0:
            wanted = 1.2 * np.sin(0.9 * t) + 0.5 * np.sin(2.3 * t)
            rate = 1.08 * np.cos(0.9 * t) + 1.15 * np.cos(2.3 * t)
            torque = 25.0 * (wanted - q) + 1.5 * (rate - v)
            rows.append((t, q, torque))
        friction = COULOMB * np.tanh(v / 1e-3) + VISCOUS * v
        weight = MASS * 9.81 * LENGTH * np.sin(q)
        v += step * (torque - friction - weight) / inertia
        q += step * v
    t, q, torque = np.array(rows).T
    noise = np.random.default_rng(0).normal(size=(2, len(t)))
    return t, q + 2e-5 * noise[0], torque + 0.01 * noise[1]


def section(title):
    """Return the commands of one section of the page, as lists of words."""
    text = PAGE.read_text(encoding='utf-8').split(f'## {title}\n')[1].split('\n## ')[0]
    block = re.search(r'```sh\n(.+?)```', text, re.DOTALL)
    return [shlex.split(line)[1:] for line in block[1].splitlines()]


def bare(words):
    """Return a command without where it writes, and which figures."""
    kept = list(words)
    for option in ('--out', '--figures'):
        if option in kept:
            del kept[kept.index(option) : kept.index(option) + 2]
    return kept


def test_the_tutorial_and_the_readme_have_the_commands_that_are_run_here():
    known = [bare(words) for words in section('From a CSV')]
    for name in ('README.md', 'docs/tutorial_csv.md'):
        text = (ROOT / name).read_text(encoding='utf-8')
        lines = re.findall(r'^sosml ((?:fit|diagnose) joint\.csv.*)$', text, re.MULTILINE)
        assert lines
        for line in lines:
            assert bare(shlex.split(line)) in known


def check(folder):
    document = json.loads((folder / 'fit.json').read_text())
    (armature,) = document['armature'].values()
    assert armature['value'] == pytest.approx(ARMATURE, rel=ARMATURE_WITHIN)
    low, high = armature['interval']
    assert low < armature['value'] < high
    (written,) = read_model(folder).joints.values()
    assert written.armature.value == armature['value']
    (fits,) = document['joints'].values()
    found = fits['weak_form']['parameters']
    assert found['coulomb']['value'] == pytest.approx(COULOMB, rel=COULOMB_WITHIN)
    assert found['viscous']['value'] == pytest.approx(VISCOUS, rel=VISCOUS_WITHIN)


def test_from_a_csv(sosml, tmp_path):
    t, q, torque = swing(ARMATURE)
    table = np.column_stack([t, q, torque / KT])
    np.savetxt(tmp_path / 'joint.csv', table, delimiter=',', header='time,q,i', comments='')
    fit, diagnose = section('From a CSV')
    code, out, err = sosml(*fit)
    assert code == 0, err
    assert 'Coulomb' in out
    for assumed in (
        'position 0 is straight down',
        'q [rad]',
        '1.8 Nm',
    ):
        assert assumed in err
    check(tmp_path / 'pendulum_fit')
    assert sosml(*diagnose)[0] == 0
    diagnosis = json.loads((tmp_path / 'pendulum_why' / 'diagnosis.json').read_text())
    # Coulomb and viscous friction is all there is, and any model has that refitted.
    assert diagnosis['verdict'] == 'nothing_above_floor'


def test_from_a_urdf_and_a_recording(sosml, tmp_path):
    t, q, torque = swing(ARMATURE)
    (tmp_path / 'robot.urdf').write_text(pendulum_model(MASS, LENGTH, joint='shoulder').urdf)
    table = np.column_stack([1e3 * t, np.rad2deg(q), torque / KT])
    header = 'time [ms];shoulder_position [deg];shoulder_current [A]'
    text = '\n'.join(';'.join(f'{x:.9f}'.replace('.', ',') for x in row) for row in table)
    (tmp_path / 'log.csv').write_text(f'{header}\n{text}\n')
    guess, make, fit = section('From a URDF and a recording')
    code, out, err = sosml(*guess)
    assert code == 0, err
    assert 'Left open, as nothing in the file tells it: joints.shoulder.effort.scale' in out
    assert sosml(*make)[0] == 2
    mapping = tmp_path / 'log.yaml'
    mapping.write_text(mapping.read_text().replace('FILL_IN', str(KT)))
    assert sosml(*make)[0] == 0
    assert sosml(*fit)[0] == 0
    check(tmp_path / 'robot_fit')


def test_from_a_bag_of_another_driver(sosml, tmp_path):
    t, q, torque = swing(ARMATURE)
    stamps = 10**9 + np.rint(t * 1e9).astype(np.int64)
    v = np.gradient(q, t)
    log = JointLog(('shoulder',), stamps, q[:, None], v[:, None], torque[:, None])
    urdf = pendulum_model(MASS, LENGTH, joint='shoulder').urdf
    write_joint_log(log, tmp_path / 'driver_bag', urdf)
    (fit,) = section('From a ROS bag of another driver')
    code, _, err = sosml(*fit)
    assert code == 0, err
    check(tmp_path / 'driver_fit')


def test_every_command_of_the_page_is_run():
    titles = re.findall(r'^## (.+)$', PAGE.read_text(encoding='utf-8'), re.MULTILINE)
    assert titles == [
        'From a CSV', 'From a URDF and a recording', 'From a ROS bag of another driver',
    ]  # fmt: skip
    assert [len(section(title)) for title in titles] == [2, 3, 1]
