# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much of a hidden effect a diagnosis that refits friction can see at all."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('mujoco')

from validation.mujoco_plant import Arm, hide, signal_to_noise


@pytest.mark.parametrize(('effect', 'least', 'most'), [
    ('root_friction', 0.0, 0.2), ('quadratic_drag', 0.0, 0.35), ('cogging', 0.95, 1.01),
])  # fmt: skip
def test_refitted_friction_takes_what_is_a_function_of_speed_and_leaves_a_ripple(
    effect, least, most
):
    """A root or a square of speed is nearly a straight line over the speeds of a motion."""
    arm = hide(Arm(), effect, 0, 1.0, np.random.default_rng(0))
    whole = signal_to_noise(arm, Arm(), 'rich')
    beside = signal_to_noise(arm, Arm(), 'rich', beside_friction=True)
    assert least * whole[0] <= beside[0] <= most * whole[0]
