# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whose URDF counts: the bag's, that of the model that is put to the test, or a stated one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorded_robot import read_recorded_robot
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.urdf_bodies import with_bodies
from sosml_friction.share import share_directory

MASS, HEAVIER = 95.1089, 120.0


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    """Return a bag with the shipped URDF, folders with a heavier one, and that URDF as a file."""
    folder = tmp_path_factory.mktemp('urdf')
    t = np.arange(0.0, 3.0, 4e-3)
    columns = [np.sin(t)[:, None]] * 3
    log = JointLog(('slider',), np.rint(t * 1e9).astype(np.int64), *columns)
    shipped = read_model(share_directory() / 'config/emps')
    bag = write_joint_log(log, folder / 'bag', shipped.urdf, shipped.to_yaml())
    body = shipped.make_robot().inertial_parameters()[0] * HEAVIER / MASS
    heavy = replace(shipped, urdf=with_bodies(shipped.urdf, {'slider': body}))
    heavy.write(folder / 'heavy')
    found = {'rigid_body': {'written': ['refit'], 'refused': {}}}
    replace(heavy, provenance=found).write(folder / 'identified')
    (folder / 'shipped.urdf').write_text(shipped.urdf)
    return bag, folder


@pytest.mark.parametrize(
    ('model', 'urdf', 'own', 'mass'),
    [
        (None, None, False, MASS),
        ('heavy', None, False, MASS),
        ('heavy', None, True, HEAVIER),
        ('identified', None, False, HEAVIER),
        ('heavy', 'shipped.urdf', True, MASS),
        ('identified', 'shipped.urdf', False, MASS),
    ],
    ids=['bag', 'bag before model', 'under test', 'identified', 'stated', 'stated, identified'],
)
def test_the_mass_is_that_of_the_urdf_that_counts(files, model, urdf, own, mass):
    bag, folder = files
    recorded = read_recorded_robot(
        bag, model and folder / model, urdf and folder / urdf, own_urdf=own
    )
    assert recorded.robot.inertial_parameters()[0, 0] == pytest.approx(mass)
    assert recorded.nominal.make_robot().inertial_parameters()[0, 0] == pytest.approx(mass)
