# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The measured motion of a robot: what all offline work takes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import DataError

#: In rad, m, their rates, Nm and N no joint has as much: 1e9 rad are 160 million turns.
LARGEST = 1e9


@dataclass(frozen=True)
class JointLog:
    """
    Hold one recording of N samples of n joints.

    ``t_ns`` (N,) int64 stamps of measurement; ``q`` (N, n) [rad or m]; ``v`` (N, n) [rad/s or
    m/s]; ``tau`` (N, n) actuator effort at the joint [Nm or N]. What was not measured is NaN.
    ``temperature`` (N, n) [degC] or None. ``tags`` are conditions (worn, payload, ...).
    ``wraps``: periods [rad or m] by which positions were unwrapped, by joint.

    :raises DataError: if something is no array, stamps are no whole numbers, a shape disagrees or
        there is no sample.
    """

    names: tuple[str, ...]
    t_ns: IndexArray
    q: FloatArray
    v: FloatArray
    tau: FloatArray
    temperature: FloatArray | None = None
    tags: Mapping[str, str] = field(default_factory=dict)
    wraps: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        warm = () if self.temperature is None else ('temperature',)
        for what in ('t_ns', 'q', 'v', 'tau', *warm):
            if not isinstance(getattr(self, what), np.ndarray):
                raise DataError(f'{what} is no array: give one of NumPy')
        if self.t_ns.dtype.kind not in 'iu':
            raise DataError('t_ns are no whole numbers: give nanoseconds, such as int64 of 1e9 t')
        shape = (len(self.t_ns), len(self.names))
        if 0 in shape:
            raise DataError(f'the recording has {shape[0]} samples of {shape[1]} joints: no data')
        for what in ('q', 'v', 'tau', 'temperature'):
            array = getattr(self, what)
            if array is not None and array.shape != shape:
                raise DataError(f'{what} has shape {array.shape} where {shape} is needed')

    def __len__(self) -> int:
        return len(self.t_ns)

    def __repr__(self) -> str:
        span = f'{len(self)} samples over {self.time[-1]:.4g} s'
        return f'<JointLog; {", ".join(self.names)}; {span}>'

    @property
    def time(self) -> FloatArray:
        """Return seconds since the first sample, (N,)."""
        return (self.t_ns - self.t_ns[0]) * 1e-9

    @property
    def step(self) -> float:
        """Return the median time between samples [s], NaN where no time passes."""
        steps = np.diff(self.time)
        return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else np.nan

    def require_effort(self) -> None:
        """Refuse a recording without torque, from which no friction can be told (DataError)."""
        if np.isnan(self.tau).all():
            raise DataError(
                f'joint_states carries no effort for {", ".join(self.names)}: let the driver fill '
                'effort [Nm or N], or name the column of a table that has it, as --effort or '
                '--current; positions alone do not tell friction'
            )

    def reported_together(self, among: Collection[str]) -> tuple[str, ...]:
        """
        Return the joints of those samples that tell of most of the joints ``among``.

        Where an arm and a gripper publish on one topic by turns, these are the joints of the arm.
        """
        says = np.isfinite(self.q) | np.isfinite(self.v) | np.isfinite(self.tau)
        says &= np.array([name in among for name in self.names])
        most = says[int(np.argmax(says.sum(axis=1)))]
        return tuple(name for name, told in zip(self.names, most, strict=True) if told)

    def first_positions(self) -> dict[str, tuple[float, float]]:
        """Return the first position that is known, by joint, and its range [rad or m]."""
        found = {}
        for i, name in enumerate(self.names):
            known = self.q[np.isfinite(self.q[:, i]), i]
            if len(known):
                found[name] = (float(known[0]), float(np.ptp(known)))
        return found

    def mapped(self, change: Callable[[FloatArray], FloatArray], **others: Any) -> JointLog:
        """Return the log with position, velocity, effort and temperature changed alike."""
        return replace(
            self,
            q=change(self.q),
            v=change(self.v),
            tau=change(self.tau),
            temperature=None if self.temperature is None else change(self.temperature),
            **others,
        )

    def rows(self, rows: IndexArray | BoolArray) -> JointLog:
        """
        Return the log of the samples ``rows``, all joints.

        :raises DataError: if there are none.
        """
        return self.mapped(lambda x: x[rows], t_ns=self.t_ns[rows])

    def select(self, names: Sequence[str]) -> JointLog:
        """Return the log of ``names``, in that order; a joint that it lacks is a DataError."""
        missing = [name for name in names if name not in self.names]
        if missing:
            raise DataError(
                f'joint {", ".join(missing)} is not in the recording, which has '
                f'{", ".join(self.names)}: name its joints in the model or rename them'
            )
        if tuple(names) == self.names:
            return self
        index = [self.names.index(name) for name in names]
        # A sample that says something of other joints only came from another publisher on the
        # same topic: it is no sample of these.
        says = np.isfinite(self.q) | np.isfinite(self.v) | np.isfinite(self.tau)
        own = says[:, index].any(axis=1) | ~says.any(axis=1)
        if not own.all():
            return self.rows(np.flatnonzero(own)).select(names)
        return self.mapped(lambda x: x[:, index], names=tuple(names))
