# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The one extension point: a cause, its columns, its inner parameters, its physical range."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import FloatArray, Signals
from sosml_friction.simulation.forward_term import ForwardTerm

Inner = Mapping[str, float]

#: A cause of all joints together.
ALL_JOINTS = '*'
#: Index of a cause of all joints whose identifier is that of a cause of one joint, too.
ROBOT = -1


class Effect(ABC):
    """
    Say what a cause adds to the measured effort: columns(inner) @ amplitudes, [Nm or N].

    ``identifier`` as in model.yaml and diagnosis.json. ``amplitudes`` and ``inner``: its linear
    and its inner parameters in order, each with its unit, in which {effort}, {length} and
    {inertia} stand for those of the joint. ``refined``: inner parameters that are continuous,
    refined after selection. ``of_robot``: it has one instance for the robot, not one per joint.
    ``parameter_error``: it is a nominal parameter that is wrong, not a term that is missing.
    ``twins``: causes that are the same but at reversals and rest, so that little evidence
    separates them; ``inseparable``: causes that joint sensors cannot tell from it at all.
    """

    identifier: ClassVar[str]
    amplitudes: ClassVar[Mapping[str, str]]
    inner: ClassVar[Mapping[str, str]] = {}
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

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ForwardTerm:
        """
        Return how the cause enters the forward simulation.

        What it adds to the effort is ``columns @ amplitude``, to first order in the amplitude.

        :raises ConfigurationError: if it cannot be simulated.
        """
        raise ConfigurationError(
            f'effect {self.identifier} has no term in the simulation: take it out of the model'
        )

    def units(self, signals: Signals, joint: int) -> dict[str, str]:
        """Return the unit of every amplitude and inner parameter in a joint."""
        effort, length = signals.effort_unit(joint), signals.length_unit(joint)
        inertia = 'kg m2' if effort == 'Nm' else 'kg'
        return {
            name: unit.format(effort=effort, length=length, inertia=inertia)
            for name, unit in (*self.amplitudes.items(), *self.inner.items())
        }

    def parameters(self, fit: Fitted) -> dict[str, Parameter]:
        """Return the amplitudes with their standard errors, and the inner parameters."""
        units = self.units(fit.signals, fit.joint)
        result = {
            name: Parameter(float(x), units[name], float(e))
            for name, x, e in zip(self.amplitudes, fit.amplitude, fit.error, strict=True)
        }
        for name in self.inner:
            result[name] = Parameter(float(fit.inner[name]), units[name])
        return result

    def restore(self, parameters: Mapping[str, Parameter]) -> tuple[dict[str, float], FloatArray]:
        """Return the inner parameters and the amplitudes that :meth:`parameters` reported."""
        inner = {name: parameters[name].value for name in self.inner}
        return inner, np.array([parameters[name].value for name in self.amplitudes])

    def implausible(self, fit: Fitted) -> str:
        """Return why such amplitudes are physically impossible for this cause, else ''."""
        return ''

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """Tell whether such amplitudes are a nominal parameter off by its tolerance, no cause."""
        return False

    def reduces_to(self, fit: Fitted) -> str:
        """Return the cause that this one is where its own part is not seen, else ''."""
        return ''

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range of each refined inner parameter."""
        return {}
