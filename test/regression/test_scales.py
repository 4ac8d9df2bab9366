# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The scales of a recording are found whatever is missing in it."""

from dataclasses import replace

import numpy as np
import pytest
from slider_bags import EMPS, slider_log

from sosml_friction.exceptions import DataError
from sosml_friction.model.model_folder import read_model
from sosml_friction.regression.signals import find_scales

MODEL = read_model(EMPS)
ROBOT = MODEL.make_robot()


def test_one_unknown_position_changes_next_to_nothing():
    log = slider_log()
    q = log.q.copy()
    q[len(q) // 3] = np.nan
    whole, holed = (find_scales([one], MODEL, ROBOT) for one in (log, replace(log, q=q)))
    for name in ('displacement', 'span', 'speed', 'effort'):
        assert getattr(holed, name) == pytest.approx(getattr(whole, name), rel=0.01)


def test_a_joint_without_any_position_has_scales_that_are_numbers():
    log = slider_log()
    scales = find_scales([replace(log, q=np.full_like(log.q, np.nan))], MODEL, ROBOT)
    assert np.isfinite([*scales.displacement, *scales.span, *scales.speed]).all()


@pytest.mark.parametrize('count', [1, 50])
def test_samples_of_one_stamp_are_refused_in_a_sentence(count):
    log = slider_log().rows(np.arange(count))
    log = replace(log, t_ns=np.full(count, 10**9))
    with pytest.raises(DataError, match=f'has {count} samples of one stamp: record a motion'):
        find_scales([log], MODEL, ROBOT)
