# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A measured record says the same at half of its rate."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.share import share_directory


@pytest.mark.parametrize('first', [0, in_full(1)])
def test_every_second_sample_has_the_friction_of_all(emps_log, first):
    """
    EMPS bends: a sign as smooth as is looked for, beside a huge Stribeck term, stood for that.

    By the error of the fit of all samples, 0.67 N and 7.7 N s/m; those of all are 21.9 and 189.
    """
    thinned = emps_log.rows(np.arange(first, len(emps_log), 2))
    found = sf.fit(thinned, sf.Model.read(share_directory() / 'config/emps')).parameters['slider']
    assert found['coulomb'].value == pytest.approx(21.9, abs=0.67)
    assert found['viscous'].value == pytest.approx(189.0, abs=7.7)
    assert found['coulomb'].std_error < 1.0
