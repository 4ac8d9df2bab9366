# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which recording is which: by what is in it, whatever it is called."""

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.source import Source, bag_name, log_source, refuse_copies
from sosml_friction.exceptions import ConfigurationError


@pytest.fixture
def log():
    q, v, tau = np.arange(18.0).reshape(3, 3, 2)
    return JointLog(('shoulder', 'elbow'), np.arange(3, dtype=np.int64), q, v, tau)


def test_logs_of_the_same_samples_are_one_recording(log):
    copy = replace(log, q=log.q.copy(order='F'), tags={'worn': 'no'})
    assert log_source(log, 'a').sha256 == log_source(copy, 'b').sha256
    assert log_source(log, 'a').recovery == ''


@pytest.mark.parametrize('what', ['q', 'v', 'tau', 't_ns', 'temperature', 'names'])
def test_logs_that_differ_in_anything_measured_are_two(log, what):
    changed = {
        'names': ('shoulder', 'wrist'),
        't_ns': log.t_ns + 1,
        'temperature': np.full((3, 2), 30.0),
    }.get(what)
    if changed is None:
        changed = getattr(log, what).copy()
        changed[2, 1] = np.nextafter(changed[2, 1], np.inf)
    other = replace(log, **{what: changed})
    assert log_source(other, 'a').sha256 != log_source(log, 'a').sha256


def test_a_recording_under_two_labels_is_refused():
    refuse_copies([Source('t1', 'aa'), Source('t2', 'bb')])
    with pytest.raises(ConfigurationError, match='t1 and t3 are copies of one recording'):
        refuse_copies([Source('t1', 'aa'), Source('t2', 'bb'), Source('t3', 'aa')])


def test_a_bag_is_called_by_its_folder_or_file(tmp_path):
    assert bag_name(tmp_path / 'run' / 't1') == 't1'
    assert bag_name(tmp_path / 't1_0.mcap') == 't1_0'


def test_a_log_is_shown_in_a_line(log):
    assert repr(log) == '<JointLog; shoulder, elbow; 3 samples over 2e-09 s>'
