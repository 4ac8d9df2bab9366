# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that several commands are tried on."""

import numpy as np
import pytest
from slider_bags import record, slider_log

from sosml_friction.bags.joint_log import JointLog


@pytest.fixture(scope='session')
def slider_bag(tmp_path_factory):
    return record(tmp_path_factory.mktemp('bags') / 'ladder', slider_log())


@pytest.fixture(scope='session')
def encoder_bag(tmp_path_factory):
    """Return the ladder as an encoder of 2 um sees it, with backward differences."""
    log = slider_log()
    q = 2e-6 * np.round(log.q / 2e-6 + np.random.default_rng(8).normal(0.0, 0.3, log.q.shape))
    v = np.diff(q, axis=0, prepend=q[:1]) / 0.004
    folder = tmp_path_factory.mktemp('bags') / 'encoder'
    return record(folder, JointLog(log.names, log.t_ns, q, v, log.tau))
