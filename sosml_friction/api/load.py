# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read a recording, whatever it is stored in."""

from pathlib import Path

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.other_bag import SUFFIXES as OTHER_SUFFIXES
from sosml_friction.bags.tables.file_kind import is_table
from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.mapping import read_mapping
from sosml_friction.exceptions import ConfigurationError, DataError


def load(
    source: str | Path,
    mapping: str | Path | None = None,
    namespace: str | None = None,
    rate: float | None = None,
) -> JointLog:
    """
    Read a recording.

    :param source: a bag (folder or file), or a table of any kind that sosml import reads.
    :param mapping: of a table, the YAML file that says which variable is what, in which unit; see
        :mod:`sosml_friction.bags.tables.mapping`.
    :param namespace: which robot, where a bag holds several.
    :param rate: samples per second [Hz], where the mapping of a table has no time.
    :return: the measured motion in SI units: ``t_ns`` (N,), ``q``, ``v``, ``tau`` (N, n), NaN
        where a quantity was not measured.
    :raises ConfigurationError: if a table comes without a mapping, a bag with one, or the mapping
        is wrong.
    :raises BagError: if the bag cannot be read or has no joint_states.
    :raises DataError: if the table does not hold what the mapping says.
    """
    if not Path(source).exists():
        raise DataError(f'{source} does not exist: give the path of a bag or a table')
    path = Path(source)
    if mapping is None and is_table(path):
        raise ConfigurationError(
            f'{source} does not say which number is what: give a mapping file, such as '
            f'sosml import {source} --guess proposes'
        )
    if mapping is not None and (path.is_dir() or path.suffix in ('.mcap', *OTHER_SUFFIXES)):
        raise ConfigurationError(
            f'{source} is a bag, which says itself what it holds: leave the mapping out'
        )
    if mapping is not None:
        return read_recording(source, read_mapping(mapping, rate))
    return Bag.open(source, namespace).joint_log()
