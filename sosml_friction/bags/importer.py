# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Turn a MAT, CSV, NPZ or NPY recording into a bag, as a mapping file says."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.controllers import CONTROLLER_TAG
from sosml_friction.bags.data_file import DataFile
from sosml_friction.bags.joint_log import FloatArray, JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.mapping import (
    ANGULAR_UNITS,
    LINEAR_UNITS,
    ImportMapping,
    Series,
    Signal,
    read_mapping,
)
from sosml_friction.exceptions import BagError, ConfigurationError, DataError


def import_recording(source: str | Path, mapping: str | Path, destination: str | Path) -> Path:
    """
    Write the recording ``source`` as the bag ``destination`` and return its path.

    The bag holds joint_states (SI units; a quantity no joint has stays an empty array; NaN stays
    NaN), joint_temperatures and controller_reference where mapped, and the robot's and model's
    description where the mapping names their files. The stamp is the start time (0 unless given)
    plus the time in the file. If anything is wrong, nothing is written.

    :raises ConfigurationError: if the mapping is wrong (see :mod:`sosml_friction.bags.mapping`)
        or a joint is not in its URDF.
    :raises DataError: if the file does not hold what the mapping says, or time does not increase.
    :raises BagError: if the bag exists or cannot be written.
    """
    destination = Path(destination)
    plan = read_mapping(mapping)
    if destination.exists():
        raise BagError(
            f'{destination} exists and is not overwritten: choose another name or remove it'
        )
    log = read_recording(source, plan)
    reference = read_reference(source, plan, len(log))
    robot_description = None if plan.urdf is None else _robot_description(plan.urdf, plan)
    model_description = None if plan.model is None else _text(plan.model)
    # Made beside its place and moved there whole, so that no half of a bag is ever found.
    existing = destination.absolute().parent
    while not existing.exists():
        existing = existing.parent
    try:
        workshop = Path(tempfile.mkdtemp(prefix='.sosml_import_', dir=existing))
    except OSError as error:
        raise BagError(
            f'{destination} cannot be written: {error.strerror}: choose another place'
        ) from error
    try:
        made = write_joint_log(
            log, workshop / destination.name, robot_description, model_description, reference
        )
        destination.parent.mkdir(parents=True, exist_ok=True)
        os.rename(made, destination)
    except OSError as error:
        raise BagError(
            f'{destination} cannot be written: {error.strerror}: choose another place'
        ) from error
    finally:
        shutil.rmtree(workshop, ignore_errors=True)
    return destination


def read_recording(source: str | Path, plan: ImportMapping) -> JointLog:
    """
    Return the JointLog that a data file holds according to a mapping.

    :raises DataError: if the file does not hold what the mapping says, or time does not increase.
    :raises ConfigurationError: if the mapping does not fit the file.
    """
    data = DataFile(source, plan.rows, plan.columns)
    names = tuple(plan.joints)
    first = plan.joints[names[0]]['position'].series
    count = len(_series(data, first if plan.time is None else plan.time))
    if count == 0:
        raise DataError(f'{data.path} holds no samples: give a recording')
    t_ns = _stamps(data, plan, count)
    arrays: dict[str, FloatArray] = {}
    for quantity in ('position', 'velocity', 'effort', 'temperature'):
        arrays[quantity] = np.full((count, len(names)), np.nan)
        for j, name in enumerate(names):
            signal = plan.joints[name].get(quantity)
            if signal is None:
                continue
            values = _values(data, signal)
            if len(values) != count:
                raise DataError(
                    f'{data.path} has {count} samples of time and {len(values)} of the {quantity} '
                    f'of {name} ({signal.series.variable!r}): they must be as many'
                )
            arrays[quantity][:, j] = values
    has_temperature = any('temperature' in signals for signals in plan.joints.values())
    return JointLog(
        names,
        t_ns,
        arrays['position'],
        arrays['velocity'],
        arrays['effort'],
        arrays['temperature'] if has_temperature else None,
        {**plan.tags, **_controller_tags(data, plan)},
    )


def read_reference(source: str | Path, plan: ImportMapping, count: int) -> FloatArray | None:
    """
    Return the wanted positions of the controllers in a mapping (N, n), None if it has none.

    :raises DataError: if there are not as many as samples.
    """
    if not plan.controllers:
        return None
    data = DataFile(source, plan.rows, plan.columns)
    reference = np.full((count, len(plan.joints)), np.nan)
    for j, name in enumerate(plan.joints):
        if name not in plan.controllers:
            continue
        signal = plan.controllers[name].reference
        values = _values(data, signal)
        if len(values) != count:
            raise DataError(
                f'{data.path} has {count} samples of time and {len(values)} of the reference of '
                f'{name} ({signal.series.variable!r}): they must be as many'
            )
        reference[:, j] = values
    return reference


def _controller_tags(data: DataFile, plan: ImportMapping) -> dict[str, str]:
    """Return the gains of each controller as a tag, ``controller.<joint>``, JSON."""
    return {
        f'{CONTROLLER_TAG}{name}': json.dumps(
            {key: _one_number(data, value) for key, value in loop.gains.items()}
        )
        for name, loop in plan.controllers.items()
    }


def _series(data: DataFile, series: Series) -> NDArray[Any]:
    """Return one series (N,) of the file."""
    values = data[series.variable]
    name = series.variable
    if series.column is not None or series.row is not None:
        what, index = ('column', series.column) if series.row is None else ('row', series.row)
        if values.ndim != 2:
            raise DataError(
                f'the variable {name!r} of {data.path} has shape {values.shape}: it is no table, '
                f'so remove {what} from the mapping'
            )
        table = values.T if what == 'column' else values
        if index is None or index >= len(table):
            raise DataError(
                f'the variable {name!r} of {data.path} has {len(table)} {what}s: {what} {index} '
                '(counted from 0) does not exist'
            )
        return np.asarray(table[index])
    values = np.atleast_1d(values)
    if values.ndim != 1:
        raise DataError(
            f'the variable {name!r} of {data.path} has shape {values.shape}: say in the mapping '
            'which column or row of it is meant'
        )
    return values


def _one_number(data: DataFile, value: float | str) -> float:
    """Return a number of the mapping, or the one that the variable of this name holds."""
    if not isinstance(value, str):
        return value
    values = data[value]
    if values.size != 1 or not np.isfinite(values).all():
        raise DataError(
            f'the variable {value!r} of {data.path} has shape {values.shape}: one finite number '
            'is needed'
        )
    return float(values.reshape(()))


def _values(data: DataFile, signal: Signal) -> FloatArray:
    """Return a signal in SI units, (N,)."""
    values: FloatArray = _series(data, signal.series).astype(np.float64)
    for factor in (signal.factor, _one_number(data, signal.scale)):
        if factor != 1.0:
            values = values * factor
    offset = _one_number(data, signal.offset)
    return values + offset if offset != 0.0 else values


def _stamps(data: DataFile, plan: ImportMapping, count: int) -> NDArray[np.int64]:
    """Return the stamps (N,) [ns], strictly increasing."""
    if plan.time is None:
        assert plan.sample_rate is not None
        rate = _one_number(data, plan.sample_rate)
        if not rate > 0.0:
            raise DataError(f'the sample rate in {data.path} is {rate:g} Hz: it must be positive')
        t_ns = np.rint(np.arange(count) * (1e9 / rate)).astype(np.int64)
        what = f'a sample rate of {rate:g} Hz'
    else:
        time = _series(data, plan.time)
        what = f'the time {plan.time.variable!r} of {data.path}'
        if not np.isfinite(time).all():
            k = int(np.flatnonzero(~np.isfinite(time))[0])
            raise DataError(f'{what} is {time[k]} at index {k}: each sample needs its time')
        if float(np.abs(time).max()) * plan.ns_per_time_unit >= 2**62:
            raise DataError(
                f'{what} reaches {np.abs(time).max():g}: check its unit in the mapping'
            )
        if time.dtype.kind in 'iu':
            t_ns = time.astype(np.int64) * plan.ns_per_time_unit
        else:
            t_ns = np.rint(time * plan.ns_per_time_unit).astype(np.int64)
    backward = np.flatnonzero(np.diff(t_ns) <= 0)
    if len(backward):
        k = int(backward[0]) + 1
        raise DataError(
            f'{what} does not increase at index {k} ({t_ns[k - 1]} ns, then {t_ns[k]} ns): remove '
            'repeated samples or check the unit'
        )
    t_ns = t_ns + plan.start_time_ns
    if t_ns[0] < 0:
        raise DataError(
            f'{what} begins {-int(t_ns[0])} ns before 0: set start_time in {plan.path} so that no '
            'stamp is negative'
        )
    return t_ns


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f'{path} cannot be read as text: {error}') from error


def _robot_description(path: Path, plan: ImportMapping) -> str:
    """Return the URDF's text after checking that it has the joints, of the kind the units say."""
    text = _text(path)
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ConfigurationError(f'{path} is no readable URDF: {error}') from error
    joints = {joint.get('name', ''): joint.get('type') for joint in root.findall('joint')}
    missing = [name for name in plan.joints if name not in joints]
    if missing:
        raise ConfigurationError(
            f'joint {", ".join(missing)} is not in {path}, which has '
            f'{", ".join(joints)}: use the names of the URDF in '
            'the mapping'
        )
    for name, signals in plan.joints.items():
        wrong = LINEAR_UNITS if joints[name] in ('revolute', 'continuous') else ANGULAR_UNITS
        for quantity, signal in signals.items():
            if signal.unit in wrong:
                raise ConfigurationError(
                    f'joint {name} is {joints[name]} in {path} and its {quantity} is in '
                    f'{signal.unit}: correct the unit in {plan.path} or the URDF'
                )
    return text
