# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A JointLog written as a bag comes back bit for bit."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.exceptions import BagError, DataError

WORDS = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=8)


@st.composite
def joint_logs(draw):
    names = draw(st.lists(WORDS.filter(bool), min_size=1, max_size=4, unique=True))
    stamps = draw(
        st.lists(st.integers(1, 2**31 * 10**9 - 1), min_size=1, max_size=12, unique=True)
    )
    shape = (len(stamps), len(names))
    numbers = hnp.arrays(np.float64, shape, elements=st.floats(-1e8, 1e8) | st.just(np.nan))
    unknown = st.just(np.full(shape, np.nan))
    return JointLog(
        names=tuple(names),
        t_ns=np.array(sorted(stamps), dtype=np.int64),
        q=draw(numbers),
        v=draw(numbers | unknown),
        tau=draw(numbers | unknown),
        temperature=draw(st.none() | numbers),
        tags=draw(st.dictionaries(WORDS, WORDS, max_size=3)),
    )


def bits(array):
    """Return the bits of an array, so that NaN equals NaN and 0.0 differs from -0.0."""
    return np.where(np.isnan(array), np.nan, array).view(np.int64).tolist()


@given(log=joint_logs())
@settings(max_examples=80, deadline=None)
def test_a_joint_log_comes_back_from_its_bag_bit_by_bit(log):
    with tempfile.TemporaryDirectory() as folder:
        bag = Bag.open(write_joint_log(log, Path(folder) / 'bag'))
        back = bag.joint_log()
        assert not bag.recovered
    assert back.names == log.names
    assert back.t_ns.dtype == np.int64
    assert back.t_ns.tolist() == log.t_ns.tolist()
    for what in ('q', 'v', 'tau'):
        assert bits(getattr(back, what)) == bits(getattr(log, what))
    assert (back.temperature is None) == (log.temperature is None)
    if log.temperature is not None:
        assert bits(back.temperature) == bits(log.temperature)
    assert back.tags == log.tags


def sample(t_ns=(1, 2)):
    ones = np.ones((len(t_ns), 1))
    return JointLog(('a',), np.array(t_ns), ones, ones * np.nan, ones)


def test_descriptions_go_into_the_bag_and_unknown_quantities_stay_out(tmp_path):
    bag = Bag.open(write_joint_log(sample(), tmp_path / 'bag', '<robot/>', 'joints: {}'))
    assert bag.text('robot_description') == '<robot/>'
    assert bag.text('model_description') == 'joints: {}'
    assert [len(message.velocity) for _, message in bag.decoded('/joint_states')] == [0, 0]


def test_the_same_log_makes_the_same_file(tmp_path):
    first, second = (
        write_joint_log(sample(), tmp_path / name / 'bag', '<robot/>') for name in ('x', 'y')
    )
    assert (first / 'bag_0.mcap').read_bytes() == (second / 'bag_0.mcap').read_bytes()


@pytest.mark.parametrize('stamps', [(-1, 5), (0, 2**31 * 10**9)])
def test_stamps_that_do_not_fit_are_refused_before_anything_is_written(tmp_path, stamps):
    with pytest.raises(BagError, match=f'the stamps run from {stamps[0]} to {stamps[1]} ns'):
        write_joint_log(sample(stamps), tmp_path / 'bag')
    assert list(tmp_path.iterdir()) == []


def test_a_log_without_any_effort_is_refused_by_who_needs_it():
    log = sample()
    log.require_effort()
    none = JointLog(log.names, log.t_ns, log.q, log.v, log.tau * np.nan)
    with pytest.raises(DataError, match='joint_states carries no effort for a: let the driver'):
        none.require_effort()


def test_joints_are_selected_by_name_and_missing_ones_named():
    table = np.arange(6.0).reshape(2, 3)
    log = JointLog(('a', 'b', 'c'), np.array([1, 2]), table, table + 10, table + 20, table + 30)
    part = log.select(['c', 'a'])
    assert part.names == ('c', 'a')
    assert part.q.tolist() == [[2, 0], [5, 3]]
    assert part.v.tolist() == [[12, 10], [15, 13]]
    assert part.tau.tolist() == [[22, 20], [25, 23]]
    assert part.temperature.tolist() == [[32, 30], [35, 33]]
    with pytest.raises(DataError, match='joint d is not in the recording, which has a, b, c'):
        log.select(['a', 'd'])


def test_shapes_that_disagree_and_empty_logs_are_refused():
    table = np.zeros((2, 1))
    with pytest.raises(DataError, match=r'v has shape \(2, 2\) where \(2, 1\) is needed'):
        JointLog(('a',), np.array([1, 2]), table, np.zeros((2, 2)), table)
    with pytest.raises(DataError, match='0 samples of 1 joints: no data'):
        JointLog(('a',), np.array([], dtype=np.int64), table[:0], table[:0], table[:0])


def test_samples_of_other_joints_only_are_no_samples_of_a_selection():
    """A gripper that shares joint_states makes no gap; a sample that knows nothing stays one."""
    nan = np.nan
    q = np.array([[1.0, nan], [nan, 5.0], [2.0, nan], [nan, nan], [3.0, nan]])
    log = JointLog(('arm', 'gripper'), np.arange(5), q, q.copy(), q.copy())
    arm = log.select(('arm',))
    assert arm.t_ns.tolist() == [0, 2, 3, 4]
    np.testing.assert_array_equal(arm.q[:, 0], [1.0, 2.0, nan, 3.0])
    assert log.select(('gripper', 'arm')).t_ns.tolist() == [0, 1, 2, 3, 4]
