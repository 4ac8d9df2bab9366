# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which of the paper's trajectories a recording is: stated, recorded with it, or by its motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.segments import (
    SegmentSettings,
    centred_difference,
    find_segments,
)
from sosml_friction.model.laws import unit_of
from sosml_friction.motion.trajectories import TRAJECTORIES

#: Roles of the paper's trajectories: speed ladder, symmetric reversals, slow ladder.
ROLES = tuple(kind.role for kind in TRAJECTORIES.values() if kind.role)
OTHER = 'other'

#: What the metadata of a bag says of its trajectory.
_TAGS = ('trajectory_label', 'trajectory')
#: Half-cycles whose peak speeds differ by less than this share are repetitions of one.
_SAME = 0.1
#: A train of reversals repeats a half-cycle as often; a ladder four times at its top.
_TRAIN = 6
#: Share of the time in motion that a ladder is on its plateaus, at least.
_STEADY = 0.3
#: A ladder slower than this share of the fastest one is the slow ladder.
_SLOW = 0.35
_WINDOW_S = 0.05
#: Share of the top speed below which a joint is taken to stand.
_STANDS = 0.02


@dataclass(frozen=True)
class BagRole:
    """
    Say what part a recording plays in the paper's rule.

    ``role`` is one of :data:`ROLES`, or empty for another trajectory. ``source`` is ``stated``
    (by the user), ``recorded`` (in the bag) or ``motion`` (told from its speeds); ``reason`` says
    it in words, as part of a sentence.
    """

    role: str
    source: str
    reason: str


def parse_roles(texts: Sequence[str], bags: Sequence[str]) -> dict[str, str]:
    """
    Return the roles in ``BAG=ROLE`` texts, by the label of the bag; ``other`` becomes empty.

    :raises ConfigurationError: if a text is not of that form, or names no such bag or role.
    """
    roles = {}
    for text in texts:
        bag, _, role = text.rpartition('=')
        if bag.rstrip('/') not in bags or role not in (*ROLES, OTHER):
            raise ConfigurationError(
                f'--role {text} is not BAG=ROLE: the bags are {", ".join(bags)}, a role is '
                f'{", ".join(ROLES)} or {OTHER}'
            )
        roles[bag.rstrip('/')] = '' if role == OTHER else role
    return roles


def find_roles(
    logs: Mapping[str, JointLog],
    stated: Mapping[str, str] | None = None,
    effort_units: Mapping[str, str] | None = None,
) -> dict[str, BagRole]:
    """
    Return the role of each recording: as stated, as recorded in its tags, else by its motion.

    By motion, of the joint that turns round most often: recordings that repeat half-cycles of the
    same peak speed six times or more are T2; recordings with plateaus of three speeds or more are
    ladders: T3 where their top speed is less than a third of the fastest ladder's, else T1.

    :param stated: roles by label, empty for none of the three.
    :param effort_units: ``Nm`` or ``N`` by joint, ``Nm`` where it is not said.
    """
    roles: dict[str, BagRole] = {}
    shapes: dict[str, _Shape] = {}
    for label, log in logs.items():
        if label in (stated or {}):
            roles[label] = BagRole((stated or {})[label], 'stated', 'stated with --role')
            continue
        recorded = _recorded(log.tags)
        if recorded is not None:
            roles[label] = recorded
        else:
            shapes[label] = _shape(log)
    every = [shapes.get(label) or _shape(log) for label, log in logs.items()]
    ladders = [shape.top for shape in every if _is_ladder(shape)]
    fastest = max(ladders, default=np.nan)
    for label, shape in shapes.items():
        unit = unit_of('velocity', (effort_units or {}).get(shape.joint, 'Nm'))
        roles[label] = _by_motion(shape, fastest, unit)
    return {label: roles[label] for label in logs}


def _recorded(tags: Mapping[str, str]) -> BagRole | None:
    said = [tags[key] for key in _TAGS if tags.get(key)]
    if not said:
        return None
    by_name = {kind.name: kind.role for kind in TRAJECTORIES.values()}
    roles = [by_name.get(text, text) for text in said]
    role = next((role for role in roles if role in ROLES), '')
    return BagRole(role, 'recorded', f'recorded as {said[-1]}')


@dataclass(frozen=True)
class _Shape:
    """The motion of the joint that turns round most often, as half-cycles."""

    longest_train: int
    speeds: int
    steady: float
    top: float
    joint: str = ''


def _shape(log: JointLog) -> _Shape:
    best = _Shape(0, 0, 0.0, 0.0)
    half_cycles = 0
    for i in range(len(log.names)):
        peaks, moving_s = _peaks(log.time, log.q[:, i])
        settings = SegmentSettings(zero_band=_STANDS * float(peaks.max(initial=0.0)))
        if len(peaks) <= half_cycles:
            continue
        half_cycles = len(peaks)
        same = np.abs(np.diff(peaks)) < _SAME * peaks[1:]
        runs = np.diff(np.flatnonzero(np.concatenate([[True], ~same, [True]])))
        windows = [
            window
            for window in find_segments(log.time, log.q[:, i], settings)
            if not window.rejected
        ]
        ordered = np.sort([abs(window.velocity) for window in windows])
        speeds = len(ordered[:1]) + int((np.diff(ordered) > _SAME * ordered[1:]).sum())
        steady = sum(window.end_s - window.start_s for window in windows) / moving_s
        top = float(max(ordered, default=0.0))
        best = _Shape(int(runs.max()), speeds, steady, top, log.names[i])
    return best


def _peaks(time: FloatArray, q: FloatArray) -> tuple[FloatArray, float]:
    """Return the usual top speed of each half-cycle of a joint, and for how long it moves [s]."""
    steps = np.diff(time)[np.diff(time) > 0.0]
    if not len(steps):
        return np.empty(0), 0.0
    half = max(1, round(0.5 * _WINDOW_S / float(np.median(steps))))
    if len(time) <= 2 * half:
        return np.empty(0), 0.0
    v = np.nan_to_num(centred_difference(time, q, half))
    top = float(np.abs(v).max())
    way = np.where(np.abs(v) > _STANDS * top, np.sign(v), 0.0)
    moving = np.flatnonzero(way)
    if not len(moving):
        return np.empty(0), 0.0
    cycles = np.split(moving, np.flatnonzero(np.diff(way[moving]) != 0.0) + 1)
    # Noise about standstill makes cycles of a few samples.
    peaks = np.array([np.quantile(np.abs(v[c]), 0.9) for c in cycles if len(c) > 4 * half])
    return peaks, len(moving) * float(np.median(steps))


def _is_ladder(shape: _Shape) -> bool:
    return shape.longest_train < _TRAIN and shape.speeds >= 3 and shape.steady >= _STEADY


def _by_motion(shape: _Shape, fastest: float, unit: str) -> BagRole:
    if shape.longest_train >= _TRAIN:
        times = f'it repeats a half-cycle {shape.longest_train} times'
        return BagRole('T2', 'motion', times)
    if not _is_ladder(shape):
        return BagRole('', 'motion', 'its motion is neither a ladder nor a train of reversals')
    slow = shape.top < _SLOW * fastest
    what = f'a ladder of {shape.speeds} speeds up to {shape.top:.2g} {unit}'
    return BagRole(
        'T3' if slow else 'T1', 'motion', f'{what}, {"slow" if slow else "the fastest"}'
    )
