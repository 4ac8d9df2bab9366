# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Inertia and friction by the inverse model: filter, differentiate, decimate, least squares."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, decimate, sosfiltfilt

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.even_stretches import on_lines
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.law.jackknife import jackknife_errors, t_95
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.regression.column_norms import column_norms

FORMS = ('symmetric', 'asymmetric')
#: Of the Butterworth filter, and of the Chebyshev filter before decimation.
_ORDER = 4
#: Collinearity: share of a column that the others must leave unexplained for it to be fitted.
_COLLINEAR = 1e-6
#: Gravity below this share of the largest effort is rounding: doubles have 2e-16.
_ROUNDING = 1e-9
#: Largest cut-off, as a share of the sampling frequency.
_HIGHEST = 0.4
#: Cut-off of the low-pass of positions [Hz]. Chosen, no measurement.
_CUTOFF = 100.0
#: Length of a cluster [s]: samples in one may share their noise. Chosen, no measurement.
_CLUSTER_S = 1.0
#: Fewest clusters for a covariance by clusters. Chosen, no measurement.
_FEWEST_CLUSTERS = 8
_POSITIVE = ('inertia', 'inertia_scale')


@dataclass(frozen=True)
class InverseFit:
    """
    Hold one joint's least-squares fit.

    ``parameters``: ``inertia`` [kg m2 or kg] for a robot of one joint, rotor included, else
    ``inertia_scale``, the factor on all inertial torque of the joint; ``gravity_scale`` where the
    model has gravity; ``viscous``, ``coulomb`` and ``bias``, or in the asymmetric form
    ``viscous_positive``, ``coulomb_positive``, ``viscous_negative`` and ``coulomb_negative`` by
    direction of motion (their bias is in the two Coulomb terms). A parameter that the motion
    cannot tell is flagged, NaN, and has what the data leave open as its interval.

    ``relative_error`` [%] = 100 |residual| / |effort| and ``residual_std`` [Nm or N] are over the
    ``samples`` kept.
    """

    joint: str
    form: str
    unit: str
    parameters: Mapping[str, Parameter]
    relative_error: float
    residual_std: float
    samples: int
    clusters: int

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings, ready for JSON."""
        return {
            'parameters': self.parameters,
            'relative_error': self.relative_error,
            'residual_std': self.residual_std,
            'residual_unit': self.unit,
            'samples': self.samples,
            'clusters': self.clusters,
        }


@dataclass(frozen=True)
class InverseFits:
    """
    Hold the inverse-model fits of a recording.

    ``joints[joint][form]`` for both of :data:`FORMS`; ``unavailable[joint]`` says why not.
    """

    joints: Mapping[str, Mapping[str, InverseFit]]
    unavailable: Mapping[str, str]


def fit_inverse_model(log: JointLog, robot: Robot, cutoff: float = _CUTOFF) -> InverseFits:
    """
    Fit inertia and friction of every joint to its effort.

        tau = s_M (M q'' + C q') + s_g g + B v + F sgn(v) + bias  (F: Coulomb),

    by least squares. q is low-passed by a zero-phase Butterworth filter; q' and q'' are its
    central differences. The columns of the design matrix and the effort go through the same
    decimation filter, so that it changes both sides alike. 10 / cutoff seconds are cut from both
    ends of each uninterrupted stretch, where filters settle. Standard errors are those of the
    jackknife over clusters of 1 s; intervals are 95 % with Student's t.

    The method of A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS",
    Workshop on Nonlinear System Identification Benchmarks, 2019. Unlike the weak form it
    differentiates position twice, so that it needs a fine encoder.

    :param log: the recording; its joints include the robot's. Velocities in it are not used.
    :param cutoff: of the low-pass [Hz]; for slow sampling at most 0.4 times the frequency of it.
    :raises DataError: if a joint of the robot is not in the log.
    """
    log = log.select(robot.names)
    joints: dict[str, dict[str, InverseFit]] = {}
    unavailable: dict[str, str] = {}
    for i, name in enumerate(robot.names):
        task = _InverseTask(log, robot, i, cutoff)
        reason = task.problem()
        if reason:
            unavailable[name] = reason
        else:
            joints[name] = {form: task.fit(form) for form in FORMS}
    return InverseFits(joints, unavailable)


class _InverseTask:
    """What the forms of one joint have in common: decimated columns, stretch after stretch."""

    def __init__(self, log: JointLog, robot: Robot, i: int, cutoff: float) -> None:
        self.robot, self.i = robot, i
        self.name, self.unit = robot.names[i], robot.effort_units[i]
        self.log = log
        time = log.time
        self.step = log.step
        self.cutoff = min(cutoff, _HIGHEST / self.step)
        blocks = [
            self._columns(time[run], log.q[run], log.tau[run, i]) for run in self._runs(time)
        ]
        blocks = [block for block in blocks if len(block)]
        self.rows = np.concatenate(blocks) if blocks else np.empty((0, 9))

    def _runs(self, time: FloatArray) -> list[IndexArray]:
        """Return the rows of each stretch without holes in time, position or effort."""
        known = np.isfinite(self.log.q).all(axis=1) & np.isfinite(self.log.tau[:, self.i])
        rows = np.flatnonzero(known)
        if not len(rows) or not np.isfinite(self.step):
            return []
        # A repeated stamp is no sample of its own.
        rows = rows[np.append(True, np.diff(time[rows]) != 0.0)]
        jumps = np.diff(time[rows])
        return np.split(rows, np.flatnonzero((jumps < 0.0) | (jumps > 2.0 * self.step)) + 1)

    def _columns(self, time: FloatArray, q: FloatArray, tau: FloatArray) -> FloatArray:
        """Return time, effort, inertia's and gravity's, v and sgn(v) forth, then back, and 1."""
        h = self.step
        edge = max(1, round(10.0 / self.cutoff / h))
        count = round(float(time[-1] - time[0]) / h) + 1
        if count < 4 * edge:
            return np.empty((0, 9))
        even = time[0] + h * np.arange(count)
        q = on_lines(even, time, q)
        tau = np.interp(even, time, tau)
        low_pass = butter(_ORDER, self.cutoff, fs=1.0 / h, output='sos')
        q = sosfiltfilt(low_pass, q, axis=0)
        v = np.gradient(q, h, axis=0)
        a = np.gradient(v, h, axis=0)
        gravity = self.robot.statics(q)[1][:, self.i]
        if self.robot.n == 1:
            inertial = a[:, 0]
        else:
            states = zip(q, v, a, strict=True)
            inertial = np.array([self.robot.inverse_dynamics(*s)[self.i] for s in states])
            inertial -= gravity
        w = v[:, self.i]
        forth, back = (w > 0.0).astype(float), (w < 0.0).astype(float)
        columns = np.column_stack(
            [even, tau, inertial, gravity, w * forth, forth, w * back, -back, np.ones(count)]
        )
        factor = max(1, round(1.0 / self.cutoff / h))
        if factor > 1:
            # 1 as well: at rest the filter passes not quite all.
            columns[::factor, 1:] = decimate(columns[:, 1:], factor, _ORDER, axis=0)
        kept = columns[::factor]
        edge = -(-edge // factor)
        return kept[edge:-edge]

    def problem(self) -> str:
        """Return why the joint cannot be fitted, empty if it can."""
        if not np.isfinite(self.log.tau[:, self.i]).any():
            return 'the recording has no effort of it'
        if (count := len(np.unique(self._groups()))) < _FEWEST_CLUSTERS:
            return (
                f'only {count} stretches of {_CLUSTER_S:g} s are without a hole in position or '
                f'effort: {_FEWEST_CLUSTERS} or more are needed, record longer'
            )
        if not np.nanmax(self.log.q[:, self.i]) > np.nanmin(self.log.q[:, self.i]):
            return 'it did not move: record motion in both directions'
        return ''

    def _groups(self) -> IndexArray:
        return (self.rows[:, 0] / _CLUSTER_S).astype(np.int64)

    def fit(self, form: str) -> InverseFit:
        """Return the fit of one of :data:`FORMS`."""
        _, tau, inertial, gravity, v_forth, forth, v_back, back, one = self.rows.T
        rotary = self.unit == 'Nm'
        named: dict[str, tuple[str, FloatArray]] = {}
        if self.robot.n == 1:
            named['inertia'] = ('kg m2' if rotary else 'kg', inertial)
        else:
            named['inertia_scale'] = ('1', inertial)
        # Gravity that is rounding, about a vertical axis, does not act on the joint.
        if np.abs(gravity).max() > _ROUNDING * np.abs(tau).max():
            named['gravity_scale'] = ('1', gravity)
        viscous = unit_of('viscous', self.unit)
        if form == 'symmetric':
            named['viscous'] = (viscous, v_forth + v_back)
            named['coulomb'] = (self.unit, forth + back)
            named['bias'] = (self.unit, one)
        else:
            named['viscous_positive'] = (viscous, v_forth)
            named['coulomb_positive'] = (self.unit, forth)
            named['viscous_negative'] = (viscous, v_back)
            named['coulomb_negative'] = (self.unit, back)
        X = np.column_stack([column for _, column in named.values()])
        norms = column_norms(X)
        X = X / norms
        theta = np.linalg.lstsq(X, tau, rcond=1e-12)[0]
        residual = tau - X @ theta
        _, groups = np.unique(self._groups(), return_inverse=True)
        clusters = int(groups.max()) + 1
        errors = jackknife_errors(X, residual, groups) / norms
        quantile = t_95(max(clusters - len(named), 1))
        parameters = {}
        for k, (name, (unit, _)) in enumerate(named.items()):
            if self._left(X, k) < _COLLINEAR:
                parameters[name] = Parameter.not_told(unit)
                continue
            value, half = float(theta[k] / norms[k]), quantile * float(errors[k])
            low, high = value - half, value + half
            if name in _POSITIVE and low <= 0.0:
                parameters[name] = Parameter.not_told(unit, '', (0.0, max(high, 0.0)))
            else:
                parameters[name] = Parameter(value, unit, float(errors[k]), (low, high))
        size = float(np.linalg.norm(tau))
        return InverseFit(
            self.name,
            form,
            self.unit,
            parameters,
            100.0 * float(np.linalg.norm(residual)) / size if size > 0.0 else np.nan,
            float(np.linalg.norm(residual) / np.sqrt(len(tau) - len(named))),
            len(tau),
            clusters,
        )

    @staticmethod
    def _left(X: FloatArray, k: int) -> float:
        """Return what the other columns leave of column k, of which the norm is 1 or 0."""
        others = np.delete(X, k, axis=1)
        rest = X[:, k] - others @ np.linalg.lstsq(others, X[:, k], rcond=1e-12)[0]
        return float(np.linalg.norm(rest))
