# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an extended model, and each cause in it, is worth on data it was not fitted to."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray

#: A change of more standard errors than this is beyond chance: one-sided p = 0.01 of a normal
#: distribution, as for the F test. A right cause that is too fast to show in 0.3 s stays below it.
BEYOND_CHANCE = 2.33


@dataclass(frozen=True)
class Gain:
    """
    Hold root mean squares by joint (n,), with the refitted nominal and with the causes.

    ``inverse``: of measured minus predicted effort in the band [Nm or N]; ``relative`` [%] the
    same as a share of the measured effort; ``forward``: of simulated minus measured position over
    ``horizon_s`` from the measured state, driven by the measured effort [rad or m].
    ``forward_error``: standard error of the ratio of the latter two, after over before.
    """

    inverse_before: FloatArray
    inverse_after: FloatArray
    relative_before: FloatArray
    relative_after: FloatArray
    forward_before: FloatArray
    forward_after: FloatArray
    forward_error: FloatArray
    horizon_s: float
    on: str

    @property
    def forward_ratio(self) -> FloatArray:
        """Return the error of position after over before (n,), NaN where none is known before."""
        known = np.isfinite(self.forward_before) & (self.forward_before > 0.0)
        ratio = np.full(self.forward_before.shape, np.nan)
        return np.divide(self.forward_after, self.forward_before, out=ratio, where=known)

    @property
    def forward_by_chance(self) -> BoolArray:
        """Tell where the error of position changes by no more than chance (n,)."""
        change = np.abs(self.forward_ratio - 1.0)
        return np.asarray((change > 0.0) & (change <= BEYOND_CHANCE * self.forward_error))

    def to_dict(self, names: tuple[str, ...], units: tuple[str, ...]) -> dict[str, Any]:
        """Return the entry ``gain`` of diagnosis.json, by joint whose effort is known."""
        return {
            name: {
                'inverse': {
                    'before': float(self.inverse_before[i]),
                    'after': float(self.inverse_after[i]),
                    'unit': units[i],
                    'relative_before_percent': float(self.relative_before[i]),
                    'relative_after_percent': float(self.relative_after[i]),
                },
                'forward': {
                    'before': float(self.forward_before[i]),
                    'after': float(self.forward_after[i]),
                    'ratio': float(self.forward_ratio[i]),
                    'ratio_std_error': float(self.forward_error[i]),
                    'unit': 'rad' if units[i] == 'Nm' else 'm',
                    'horizon_s': self.horizon_s,
                },
                'on': self.on,
            }
            for i, name in enumerate(names)
            if np.isfinite(self.relative_before[i])
        }


def make_gain(
    before: FloatArray,
    after: FloatArray,
    measured: FloatArray,
    squares_before: FloatArray,
    squares_after: FloatArray,
    horizon_s: float,
    on: str,
) -> Gain:
    """
    Return the gain from effort errors (rows, n) and simulated windows (W, n) before and after.

    :param measured: effort (rows, n) in the band.
    :param squares_before: mean square of the position error of each window [rad2 or m2]; without
        windows the forward gain is not known, NaN.
    :param on: what the errors are on, for the report.
    """
    size = np.sqrt(np.mean(measured**2, axis=0))
    # A joint without effort has no error of it.
    size[size == 0.0] = np.nan
    root = [np.sqrt(np.mean(x**2, axis=0)) for x in (before, after)]
    forward = [
        np.sqrt(np.mean(x, axis=0)) if len(x) else np.full(x.shape[1], np.nan)
        for x in (squares_before, squares_after)
    ]
    return Gain(
        root[0], root[1], 100.0 * root[0] / size, 100.0 * root[1] / size, forward[0], forward[1],
        _ratio_error(squares_before, squares_after), horizon_s, on,
    )  # fmt: skip


def _ratio_error(before: FloatArray, after: FloatArray) -> FloatArray:
    """
    Return the standard error (n,) of sqrt(mean after / mean before) over windows (W, n).

    Each window is compared with itself: most of the error of both is the noise of the measured
    effort. To first order the ratio R moves by R / 2 (after / mean after - before / mean before).
    """
    result = np.full(before.shape[1], np.nan)
    for i in range(before.shape[1]):
        b, a = before[:, i], after[:, i]
        if len(b) > 1 and np.isfinite(a).all() and np.isfinite(b).all() and a.any() and b.any():
            moved = a / a.mean() - b / b.mean()
            ratio = np.sqrt(a.mean() / b.mean())
            result[i] = 0.5 * ratio * np.std(moved, ddof=1) / np.sqrt(len(b))
    return result


@dataclass(frozen=True)
class Uncertain:
    """Hold a number and its standard error, by the jackknife over stretches of the data."""

    value: float
    std_error: float

    def to_dict(self) -> dict[str, float]:
        """Return both, by name."""
        return {'value': self.value, 'std_error': self.std_error}

    def beyond(self, other: float) -> bool:
        """Tell whether the number differs from another one by more than chance."""
        return abs(self.value - other) > BEYOND_CHANCE * self.std_error


@dataclass(frozen=True)
class CauseGain:
    """
    Hold what one cause removes by itself on data left out.

    ``joints``: those that it acts in; ``without`` and ``with_it``: root mean square of the effort
    error there [Nm or N]; ``removed``: the difference. ``recurs``: the share b of what it predicts
    that is there, 1 where it carries over. ``size``: root mean square of its columns fitted to the
    data left out, over that of what it predicts; ``phase`` [degrees]: by how much that is off; NaN
    where the term has none. ``units`` of the joints.
    """

    joints: tuple[str, ...]
    units: tuple[str, ...]
    without: FloatArray
    with_it: FloatArray
    removed: tuple[Uncertain, ...]
    recurs: Uncertain
    size: Uncertain
    phase: float

    @property
    def helps(self) -> bool:
        """Tell whether the error is smaller with the cause."""
        return self.recurs.value > 0.5

    @property
    def carries_over(self) -> bool:
        """Tell that the data left out do not contradict: it helps, or is off by chance only."""
        return self.helps or not self.recurs.beyond(1.0)

    @property
    def size_recurs(self) -> bool:
        """Tell whether another phase of the same frequency is there, beyond chance."""
        return bool(np.isfinite(self.phase)) and self.size.beyond(0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``gain`` of a cause in diagnosis.json."""
        return {
            'joints': {
                name: {
                    'without': float(self.without[i]),
                    'with': float(self.with_it[i]),
                    'removed': self.removed[i].value,
                    'removed_std_error': self.removed[i].std_error,
                    'unit': self.units[i],
                }
                for i, name in enumerate(self.joints)
            },
            'recurs': self.recurs.to_dict(),
            'size': self.size.to_dict(),
            'phase_degrees': self.phase,
            'carries_over': self.carries_over,
        }


@dataclass(frozen=True)
class SimulatorGain:
    """
    Hold a simulator's errors before and after, by joint, and the file that it runs after.

    ``inverse``: rms of measured minus simulated effort, in the band, as a share of the measured
    effort [%]; ``forward``: rms of simulated minus measured position over ``horizon_s`` from the
    measured state, driven by the measured effort [rad or m]; pairs before and after, NaN where not
    known. ``friction``: its constants, by joint and parameter, before and after. ``on``: the
    recording; ``fitted_to``: whether the model was fitted to it. ``document``: the extended model
    in the simulator's form, ``file`` its name, ``left_out`` what of the model is not simulated,
    sentence parts.
    """

    simulator: str
    on: str
    fitted_to: bool
    inverse: Mapping[str, tuple[float, float]]
    forward: Mapping[str, tuple[float, float]]
    units: Mapping[str, str]
    friction: Mapping[str, Mapping[str, tuple[float, float]]]
    horizon_s: float
    file: str
    document: str
    left_out: Sequence[str] = field(default=())

    @property
    def sentence(self) -> str:
        """Return friction and the errors before and after."""
        levels = '; '.join(
            f'{name} {", ".join(f"{key} {_both(x)}" for key, x in own.items())}'
            for name, own in self.friction.items()
        )
        effort = ', '.join(
            f'{name} {_both(x)} %' for name, x in self.inverse.items() if math.isfinite(x[0])
        )
        place = ', '.join(
            f'{name} {_both((1e3 * x[0], 1e3 * x[1]))} m{self.units[name]}'
            for name, x in self.forward.items()
            if math.isfinite(x[0])
        )
        seen = ', to which the model was fitted (--holdout gives another)' * self.fitted_to
        said = f'Friction: {levels}. ' if levels else ''
        said += f'In {self.simulator}, on {self.on}{seen}: error of effort {effort}'
        if place:
            said += f', of a position simulated for {self.horizon_s:g} s {place}'
        if self.left_out:
            said += f'; not simulated: {", ".join(self.left_out)}'
        return f'{said}; {self.file} is that model.'

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``simulator`` of diagnosis.json."""
        return {
            'simulator': self.simulator,
            'on': self.on,
            'fitted_to': self.fitted_to,
            'file': self.file,
            'left_out': list(self.left_out),
            'joints': {
                name: {
                    'friction': {k: list(x) for k, x in self.friction.get(name, {}).items()},
                    'inverse_before_percent': self.inverse[name][0],
                    'inverse_after_percent': self.inverse[name][1],
                    'forward_before': self.forward[name][0],
                    'forward_after': self.forward[name][1],
                    'unit': self.units[name],
                    'horizon_s': self.horizon_s,
                }
                for name in self.inverse
            },
        }


def _both(pair: tuple[float, float]) -> str:
    return f'{pair[0]:.3g} -> {pair[1]:.3g}'
