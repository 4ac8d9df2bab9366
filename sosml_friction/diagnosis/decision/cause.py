# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cause as it is reported: effect, joint, parameters, evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.extended_model.cause_gain import CauseGain
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS, Inner, Term

#: Faults of the data. The diagnosis uses no recorded velocity, bridges short holes and undoes a
#: large delay: they leave nothing in the residual.
FAULTS = ('velocity_lag', 'dropped_samples', 'effort_delay')


@dataclass(frozen=True)
class Cause:
    """
    Hold one cause.

    ``joint``: its name, or '*' for all; ``evidence``: delta_bic, cv_gain, cv_gain_se, floor; None
    where a data check and not the model shows it. ``rivals``: causes that the data cannot tell
    from it. ``terms``: inner parameters and amplitudes of each harmonic;
    none where the extended model does not have it. ``tolerated``: it is a nominal parameter that
    is off within its tolerance: it is refitted like all of them, and no cause of what is wrong.
    ``stated``: of a term that the model states and that is off, what the model has, by parameter;
    ``stated_names``: what these are called among the nominal parameters.
    ``gain``: what it removes by itself on data left out; None where the model does not show it.
    ``tried``: of how many candidates it is the one that was taken. ``by_tolerance``: by how much
    the nominal's deviations within their tolerance move a size, the standard deviation and the
    most, in standard errors of the size.
    """

    effect: str
    joint: str
    parameters: Mapping[str, Parameter]
    evidence: Mapping[str, float | None]
    rivals: tuple[str, ...] = ()
    terms: tuple[tuple[Inner, FloatArray], ...] = ()
    tolerated: bool = False
    gain: CauseGain | None = None
    stated: Mapping[str, float] = field(default_factory=dict)
    stated_names: tuple[str, ...] = ()
    tried: int = 1
    by_tolerance: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def changes(self) -> dict[str, Parameter]:
        """Return by how much each number of a stated term is off, by its nominal name."""
        return {
            name: replace(self.parameters[key], value=self.parameters[key].value - before)
            for name, (key, before) in zip(self.stated_names, self.stated.items(), strict=True)
        }

    @property
    def key(self) -> tuple[str, str]:
        """Return effect and joint."""
        return self.effect, self.joint

    @property
    def shown_by_data(self) -> bool:
        """Tell whether the data show it by themselves, and no column of the regression."""
        return self.evidence.get('delta_bic') is None

    @property
    def is_fault(self) -> bool:
        """Tell whether it is a fault of the data, of which nothing is left in the residual."""
        return self.effect in FAULTS and self.shown_by_data

    @property
    def size_known(self) -> bool:
        """Tell whether its numbers are right within their errors, or only that it is there."""
        kind = TERMS.classes.get(self.effect)
        return kind is None or kind.size_known

    @property
    def in_model(self) -> bool:
        """Tell whether the extended model has it."""
        return bool(self.terms)

    def stands_for(self, other: Cause) -> bool:
        """Tell whether another one of its joint is the same, or either may be the other."""
        alike = self.effect in other.rivals and other.effect in self.rivals
        return self.joint == other.joint and (self.effect == other.effect or alike)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'effect': self.effect,
            'joint': self.joint,
            'parameters': {
                name: p
                if self.size_known
                else {'value': p.value, 'std_error': None, 'unit': p.unit}
                for name, p in self.parameters.items()
            },
            **({'stated': self.stated} if self.stated else {}),
            'size_known': self.size_known,
            'evidence': self.evidence,
            'rivals': self.rivals,
            'in_model': self.in_model,
            'gain': self.gain,
        }


def joint_name(effect: Term, joint: int, names: tuple[str, ...]) -> str:
    """Return the name under which a cause is reported."""
    return ALL_JOINTS if effect.of_robot else names[joint]
