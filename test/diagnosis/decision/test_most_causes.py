# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How many causes are named, of robots of several joints."""

from types import SimpleNamespace

import pytest

from sosml_friction.diagnosis.decision.selector import Selector
from sosml_friction.regression.settings import DiagnosisSettings


@pytest.mark.parametrize('joints', [1, 3, 6])
def test_a_guess_of_the_friction_of_every_joint_is_found_and_something_else_besides(joints):
    """Four causes in all would be the friction of two joints; the others would stay guessed."""
    selector = object.__new__(Selector)
    selector.settings = DiagnosisSettings()
    selector.laboratory = SimpleNamespace(robot=SimpleNamespace(n=joints))
    named = [(name, i) for i in range(joints) for name in ('coulomb', 'viscous', 'stribeck')]
    accepted = [SimpleNamespace(key=key) for key in named]
    assert not selector._enough(accepted)
    assert selector._enough(
        accepted + [SimpleNamespace(key=('cogging', i)) for i in range(joints)]
    )
