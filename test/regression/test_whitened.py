# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the whitened regression takes from rests."""

from __future__ import annotations

import numpy as np
import pytest

import sosml_friction as sf
from sosml_friction.diagnosis.library import make_library
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare, sign_state
from sosml_friction.regression.whitened import WhitenedRegression

STEP, MOVE, REST = 1e-2, 100, 100
INERTIA, COULOMB = 0.05, 0.8


def strokes(count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Return position of strokes and rests, and how deep in a rest each sample is."""
    s = np.arange(1, MOVE + 1) / MOVE
    smooth = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    ends = np.random.default_rng(3).uniform(-1.0, 1.0, count)
    q, rest = [np.zeros(REST)], [np.zeros(REST)]
    for begin, end in zip(np.append(0.0, ends), ends, strict=False):
        q += [begin + (end - begin) * smooth, np.full(REST, end)]
        rest += [np.zeros(MOVE), np.sin(np.pi * np.arange(REST) / REST) ** 2]
    return np.concatenate(q), np.concatenate(rest)


@pytest.mark.parametrize('change', [-0.5, -0.1])
def test_what_holds_a_joint_at_rest_is_asked_nowhere(change):
    """The whitened rows are the same whether a joint is held by its last friction or by less."""
    urdf = '<robot name="p"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia'
    urdf += (
        f' ixx="{INERTIA}" iyy="{INERTIA}" izz="{INERTIA}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    urdf += '</link><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
    urdf += '<axis xyz="0 0 1"/></joint></robot>'
    model = sf.Model.from_urdf(urdf, {'j': 0.0}).content
    robot = model.make_robot()
    q, rest = strokes()
    v = np.gradient(q, STEP)
    # As the model has it, which the whole catalogue would fit at rest too.
    last = sign_state(q, v, 2e-4, 0.0)
    rng = np.random.default_rng(5)
    tau = INERTIA * np.gradient(v, STEP) + COULOMB * last + 0.2 * rng.standard_normal(len(q))
    q = q + 2e-5 * rng.standard_normal(len(q))
    found = []
    for held in (tau, tau * (1.0 + change * rest)):
        t_ns = np.rint(1e9 * STEP * np.arange(len(q))).astype(np.int64)
        log = sf.JointLog(('j',), t_ns, q[:, None], np.full((len(q), 1), np.nan), held[:, None])
        settings = DiagnosisSettings()
        signals = prepare([log], model, robot, settings)
        found.append(WhitenedRegression.make(signals, make_library(), settings))
    one, other = found
    # Half of this recording is rest, and a fifth what the low-pass reaches beside it.
    assert 0.5 < 1.0 - one.known[0] / len(one.y) < 0.8
    # A sine is no broken line between rows of the band; noise is 1.
    assert other.y == pytest.approx(one.y, abs=0.05)
