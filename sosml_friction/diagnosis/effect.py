# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The one extension point: a cause, its columns, its inner parameters, its physical range."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.diagnosis.signals import Signals
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.forward_term import ForwardTerm

FloatArray = NDArray[np.float64]
Inner = Mapping[str, float]

#: A cause of all joints together.
ALL_JOINTS = '*'
#: Index of a cause of all joints whose identifier is that of a cause of one joint, too.
ROBOT = -1


class Effect(ABC):
    """
    Say what a cause adds to the measured effort: columns(inner) @ amplitudes, [Nm or N].

    ``identifier`` as in model.yaml and diagnosis.json. ``amplitudes`` and ``inner``: names of its
    linear and its inner parameters. ``of_robot``: it has one instance for the robot, not one per
    joint. ``parameter_error``: it is a nominal parameter that is wrong, not a term that is
    missing. ``twins``: causes that are the same but at reversals and rest, so that little evidence
    separates them; ``inseparable``: causes that joint sensors cannot tell from it at all.
    ``refined``: inner parameters that are continuous, refined after selection.
    """

    identifier: ClassVar[str]
    amplitudes: ClassVar[tuple[str, ...]]
    inner: ClassVar[tuple[str, ...]] = ()
    refined: ClassVar[tuple[str, ...]] = ()
    of_robot: ClassVar[bool] = False
    parameter_error: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ()
    inseparable: ClassVar[tuple[str, ...]] = ()

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the cause can act in this joint at all."""
        return True

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the inner parameters to try; one empty mapping if there are none."""
        return ({},)

    @abstractmethod
    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return (N, n, k): effort per unit of each of k amplitudes, at the data's own rate."""

    def own_columns(
        self, signals: Signals, joint: int, grid: Sequence[Inner]
    ) -> FloatArray | None:
        """
        Return the columns of several points of the grid at once, (N, g, k), in ``joint`` alone.

        None, as here, where they are not cheaper at once, or not zero in other joints.
        """
        return None

    @abstractmethod
    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the unit of every amplitude and inner parameter."""

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ForwardTerm:
        """
        Return how the cause enters the forward simulation.

        What it adds to the effort is ``columns @ amplitude``, to first order in the amplitude.

        :raises ConfigurationError: if it cannot be simulated.
        """
        raise ConfigurationError(
            f'effect {self.identifier} has no term in the simulation: take it out of the model'
        )

    def parameters(
        self,
        signals: Signals,
        joint: int,
        inner: Inner,
        amplitude: FloatArray,
        error: FloatArray,
    ) -> dict[str, Parameter]:
        """Return amplitudes (k,) with their standard errors (k,), and the inner parameters."""
        units = self.units(signals, joint)
        result = {
            name: Parameter(float(x), units[name], float(e))
            for name, x, e in zip(self.amplitudes, amplitude, error, strict=True)
        }
        for name in self.inner:
            result[name] = Parameter(float(inner[name]), units[name])
        return result

    def restore(self, parameters: Mapping[str, Parameter]) -> tuple[dict[str, float], FloatArray]:
        """Return the inner parameters and the amplitudes that :meth:`parameters` reported."""
        inner = {name: parameters[name].value for name in self.inner}
        return inner, np.array([parameters[name].value for name in self.amplitudes])

    def implausible(
        self,
        signals: Signals,
        joint: int,
        inner: Inner,
        amplitude: FloatArray,
        error: FloatArray,
    ) -> str:
        """Return why such amplitudes are physically impossible for this cause, else ''."""
        return ''

    def reduces_to(self, amplitude: FloatArray, error: FloatArray) -> str:
        """Return the cause that this one is where its own part is not seen, else ''."""
        return ''

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range of each refined inner parameter."""
        return {}


def in_joint(signals: Signals, joint: int, *columns: FloatArray) -> FloatArray:
    """Return (N, n, k) that is zero but for ``columns`` (N,) in one joint."""
    result = np.zeros((len(signals.q), signals.robot.n, len(columns)))
    for k, column in enumerate(columns):
        result[:, joint, k] = column
    return result


def effort_unit(signals: Signals, joint: int) -> str:
    """Return the unit of effort of a joint, Nm or N."""
    return signals.robot.effort_units[joint]


def length_unit(signals: Signals, joint: int) -> str:
    """Return the unit of position of a joint, rad or m."""
    return 'rad' if effort_unit(signals, joint) == 'Nm' else 'm'


def level(signals: Signals, joint: int) -> float:
    """Return what a friction term of this joint is measured against [Nm or N]."""
    coulomb = float(signals.scales.coulomb[joint])
    return coulomb if np.isfinite(coulomb) and coulomb > 0.0 else signals.scales.effort[joint]
