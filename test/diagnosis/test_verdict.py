# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What causes and what is left beside them amount to, and how it is said."""

import numpy as np
import pytest

from sosml_friction.diagnosis.cause import Cause
from sosml_friction.diagnosis.gain import Gain
from sosml_friction.diagnosis.selection import Selection
from sosml_friction.diagnosis.verdict import verdict_of
from sosml_friction.diagnosis.wording import describe, sentence_of
from sosml_friction.model.parameter import Parameter


@pytest.mark.parametrize(
    ('over', 'effect', 'verdict'),
    [
        (True, 'velocity_lag', 'unknown_structure'),
        (False, 'velocity_lag', 'named'),
        (True, 'dropped_samples', 'unknown_structure'),
        (True, 'external_contact', 'named'),
    ],
)
def test_a_fault_that_leaves_nothing_does_not_hide_that_something_is_missing(
    over, effect, verdict
):
    """The diagnosis does not use a late velocity, and bridges short holes."""
    gain = np.array([0.5 if over else 0.0])
    no_fit = (None,) * 4
    selection = Selection(
        *no_fit,
        structure_gain=gain,
        structure_floor=np.array([0.1]),
        structure_energy=gain,
    )
    parameters = {'lag_s': Parameter(0.01, 's'), 'lag_std_error_s': Parameter(1e-4, 's')}
    cause = Cause(effect, 'elbow', parameters, {})
    assert verdict_of([cause], selection) == verdict
    assert describe(cause) == f'elbow: {effect.replace("_", " ")} (lag 0.01 s)'
    sentence = sentence_of(verdict, [cause], unmoved(), selection, ('elbow',), ('Nm',))
    assert (effect.replace('_', ' ') in sentence) == (verdict == 'named')
    assert ('The refitted model explains the data' in sentence) != over


def unmoved():
    one = np.ones(1)
    return Gain(one, one, one, one, one, one, one, 0.3, 'folds left out')
