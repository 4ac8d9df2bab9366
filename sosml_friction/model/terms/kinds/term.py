# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of terms: one physical idea of a joint model, stated once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any, ClassVar, TypeVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.registry import Registry

Inner = Mapping[str, float]
_T = TypeVar('_T', bound='Term')

#: The joint of a term that acts in all joints together, in files.
ALL_JOINTS = '*'
#: Findings about the data that have no term: lost samples, contacts, late velocity.
DATA_CAUSES = ('dropped_samples', 'external_contact', 'velocity_lag')
#: Its index where there is a term of the same identifier in one joint, too.
ROBOT = -1


class Term(ABC):
    """
    Say what a term adds to the measured effort: columns(inner) @ amplitudes, [Nm or N].

    A term is made from one of the kinds beside this file, which derive its columns and its place
    in the simulation from the one function in which it states its equation.

    ``identifier``: its name in files. ``amplitudes`` and ``inner``: the parameters that it is
    linear in, and the others, each with its unit, in which {effort}, {length} and {inertia} stand
    for those of the joint. ``refined``: inner parameters that are continuous, and fitted.
    ``amplitude_range``: what each amplitude is within where the inner parameters are right.

    Where it acts: ``of_robot``: one for the robot, not one per joint; ``counterpart``: the class
    of the same identifier that is so where this one is not, or is not where this one is. A robot
    of one joint has no use for it.

    What a diagnosis needs to know: ``searched``: whether it is looked for unless asked not to;
    ``parameter_error``: it is a nominal parameter that is wrong, not a term that is missing;
    ``reported_as``: names of amplitudes as a deviation from the nominal, where they differ;
    ``axis``: along which axis it says how effort depends on it: ``speed``, ``position``,
    ``load``, ``effort``, ``acceleration`` or ``none``; ``free_axis``: the axis of the free curve
    that could stand for it; ``one_power``: one power of speed could stand for it; ``repeats``:
    its ``frequency`` is a line in a periodogram over position. ``aliases``: terms of the
    same columns but at reversals and rest; ``inseparable``: terms that joint sensors cannot
    tell from it at all; ``told_apart``: by other term, the condition that separates the two
    and what is seen then. ``worn``: it comes with a person or cable and goes with them;
    ``needs``: what recordings lack where they are too short or too poor to show it;
    ``with_body``: inner parameters that are in proportion to the nominal body, and as wrong;
    ``size_known``: its numbers are right within their errors, not only that it is there;
    ``unspoken``: parameters that a sentence leaves out; ``at_reversals``: it acts there, and what
    shows it may be beside reversals alone, unless it acts ``elsewhere_too`` as much and has to
    show there; ``reversals_alone``: it acts nowhere else.

    ``trusted_as``: the group of what it states, as of ``--trust``.

    ``stated``: of a term that the model has already, its amplitudes there, and ``stated_names``
    what they are called among the nominal parameters; see :meth:`as_stated`. ``about``: of one
    made by :meth:`further`, for which displacement; 0 of others.

    What a model file needs to know: ``of_law``: it is a function of velocity alone, and part of
    a joint's friction law; ``left_out``: why observers do not undo it, '' if they do or need not;
    ``held_by``: the export targets, of those that do not hold everything, that can hold it.
    """

    identifier: ClassVar[str]
    amplitudes: ClassVar[Mapping[str, str]]
    inner: ClassVar[Mapping[str, str]] = {}
    refined: ClassVar[tuple[str, ...]] = ()
    amplitude_range: ClassVar[tuple[float, float]] = (-np.inf, np.inf)
    of_robot: ClassVar[bool] = False
    counterpart: ClassVar[type[Term] | None] = None
    searched: ClassVar[bool] = True
    parameter_error: ClassVar[bool] = False
    reported_as: ClassVar[Mapping[str, str]] = {}
    axis: ClassVar[str] = 'none'
    free_axis: ClassVar[str] = ''
    one_power: ClassVar[bool] = False
    repeats: ClassVar[bool] = False
    aliases: ClassVar[tuple[str, ...]] = ()
    inseparable: ClassVar[tuple[str, ...]] = ()
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {}
    worn: ClassVar[bool] = False
    needs: ClassVar[str] = ''
    size_known: ClassVar[bool] = True
    with_body: ClassVar[tuple[str, ...]] = ()
    unspoken: ClassVar[tuple[str, ...]] = ()
    at_reversals: ClassVar[bool] = False
    reversals_alone: ClassVar[bool] = False
    elsewhere_too: ClassVar[bool] = False
    trusted_as: ClassVar[str] = 'terms'
    stated: FloatArray | None = None
    stated_names: tuple[str, ...] = ()
    about: float = 0.0
    of_law: ClassVar[bool] = False
    left_out: ClassVar[str] = ''
    held_by: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, registered: bool = True, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if registered:
            TERMS.add(cls)

    @classmethod
    def acting_in(cls, joint: str) -> Term | None:
        """Return the term, or its counterpart, that acts in a joint, ``*`` for all; else None."""
        kinds = [kind for kind in (cls, cls.counterpart) if kind is not None]
        return next((kind() for kind in kinds if kind.of_robot == (joint == ALL_JOINTS)), None)

    @property
    def key(self) -> str:
        """Return what tells it from other candidates of its joint."""
        return self.identifier if self.stated is None else self.stated_names[0]

    def as_stated(self, amplitude: FloatArray, names: tuple[str, ...]) -> Term:
        """
        Return the term as a model states it, in which a fit finds a change of its amplitudes.

        It is a nominal parameter then, and its inner parameters stay.
        """
        result = copy(self)
        vars(result).update(stated=amplitude, stated_names=names)
        vars(result).update(refined=(), parameter_error=True)
        return result

    def rivals(self: _T) -> tuple[_T, ...]:
        """
        Return the same idea with other published equations, of the same parameters.

        None of them is looked for; where one explains more, what it moves is in the errors.
        """
        return ()

    def further(self: _T, displacement: float) -> tuple[_T, Inner] | None:
        """
        Return the term with an inner parameter more, and where it begins; None for no such form.

        As of friction that follows its level as bristles do. It stands in the place of this one
        where it explains very strongly more.

        :param displacement: over which the friction of its joint turns around [rad or m].
        """
        return None

    def whole(self, change: FloatArray) -> FloatArray:
        """Return the amplitudes (k,) of which a fit found ``change``: with what the model has."""
        return change if self.stated is None else self.stated + change

    def change(self, fit: Fitted) -> FloatArray:
        """Return by how much the amplitudes (k,) differ from what the model has of them."""
        return fit.amplitude if self.stated is None else fit.amplitude - self.stated

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the term can act in this joint at all."""
        return True

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the inner parameters to try; one empty mapping if there are none."""
        return ({},)

    @abstractmethod
    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return (N, n, k): effort per unit of each of k amplitudes, at the data's own rate."""

    def own_columns(
        self, signals: Recording, joint: int, grid: Sequence[Inner]
    ) -> FloatArray | None:
        """
        Return the columns of several points of the grid at once, (N, g, k), in ``joint`` alone.

        Each sample's by itself: the recording may be a part of one. None, as here, if that is no
        faster than one by one, or if they act in other joints, too.
        """
        return None

    @abstractmethod
    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """
        Return how the term enters a simulation.

        What it adds to the effort is ``columns @ amplitude``, to first order in the amplitude.
        """

    @classmethod
    def unit(cls, name: str, effort_unit: str) -> str:
        """
        Return the unit of a parameter of a joint.

        :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
        """
        text = cls.amplitudes[name] if name in cls.amplitudes else cls.inner[name]
        length, inertia = ('rad', 'kg m2') if effort_unit == 'Nm' else ('m', 'kg')
        return text.format(effort=effort_unit, length=length, inertia=inertia)

    def units(self, signals: Recording, joint: int) -> dict[str, str]:
        """Return the unit of every amplitude and inner parameter in a joint."""
        effort = signals.effort_unit(joint)
        return {name: self.unit(name, effort) for name in (*self.amplitudes, *self.inner)}

    def parameters(self, fit: Fitted) -> dict[str, Parameter]:
        """Return amplitudes and inner parameters with standard errors, by their own names."""
        units = self.units(fit.signals, fit.joint)
        result = {
            name: Parameter(float(x), units[name], float(e))
            for name, x, e in zip(self.amplitudes, fit.amplitude, fit.error, strict=True)
        }
        errors = fit.inner_error or {}
        for name in self.inner:
            error = float(errors.get(name, np.nan))
            result[name] = Parameter(float(fit.inner[name]), units[name], error)
        return result

    def reported(self, fit: Fitted) -> dict[str, Parameter]:
        """Return the parameters by the names under which a diagnosis reports them."""
        return {self.reported_as.get(k, k): p for k, p in self.parameters(fit).items()}

    def restore(self, parameters: Mapping[str, Parameter]) -> tuple[dict[str, float], FloatArray]:
        """
        Return the inner parameters and the amplitudes of what a model or a diagnosis wrote.

        :raises ConfigurationError: if one is missing, has no value, or is not of this term.
        """
        names = {self.reported_as.get(k, k): k for k in (*self.amplitudes, *self.inner)}
        own = {names.get(k, k): p for k, p in parameters.items()}
        expected = (*self.amplitudes, *self.inner)
        missing = [name for name in expected if name not in own]
        if missing:
            raise ConfigurationError(f'has no {", ".join(missing)}: give each a value')
        bad = [name for name in expected if not np.isfinite(own[name].value)]
        if bad:
            shown = ', '.join(self.reported_as.get(name, name) for name in bad)
            raise ConfigurationError(f'has no value of {shown}: give a number')
        unknown = sorted(set(own) - set(expected))
        if unknown:
            raise ConfigurationError(f'has an unknown parameter {unknown[0]}: remove it')
        inner = {name: own[name].value for name in self.inner}
        return inner, np.array([own[name].value for name in self.amplitudes])

    def of_older(
        self, parameters: Mapping[str, Parameter], robot: Callable[[], Robot]
    ) -> Mapping[str, Parameter]:
        """Return the parameters of a file of before, of a robot, by today's names."""
        return parameters

    def implausible(self, fit: Fitted) -> str:
        """Return why such amplitudes are physically impossible for this term, else ''."""
        return ''

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """Tell whether such amplitudes are a nominal parameter off by its tolerance, no cause."""
        return False

    def reduces_to(self, fit: Fitted) -> str:
        """Return the term that this one is where its own part is not seen, else ''."""
        return ''

    def nested(self, fit: Fitted) -> str:
        """Return the term that is left where a part of this one is 0, as it may be, else ''."""
        return ''

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range of each refined inner parameter."""
        return {}

    def searched_inner(self, signals: Recording, joint: int) -> dict[str, tuple[float, float]]:
        """Return the inner parameters that are searched in a joint, with their physical range."""
        bounds = self.inner_bounds(signals, joint)
        return {name: bounds[name] for name in self.refined if name in bounds}


TERMS: Registry[Term] = Registry('term', 'sosml_friction.model.terms')
