# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of momentum observers, which also knows every class that is derived of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.search_space import SearchSpace
from sosml_friction.registry import Registry

#: Gains as a recipe says them: one number for all joints, or one for each.
Recipe = Mapping[str, FloatArray | float]

#: What each class has to say in its own body, and what it may take over from its base.
_OWN, _SAID = ('identifier', 'label', 'study'), ('place', 'gain_units', 'causal')


class Observer(ABC):
    """
    Estimate the disturbance tau_e in p' = tau + C^T q' - g + tau_e, joint by joint.

    tau_e = -tau_f: the minus sign is applied once, in
    :class:`~sosml_friction.observers.friction_estimator.FrictionEstimator`.

    On line and over a recording it is the same :meth:`run`, with one interval or with many, so the
    two agree to the last bit. A joint whose forcing is not finite has no estimate over that
    interval (NaN) and starts afresh at its end; the other joints go on.

    A class registers itself when it is defined, wherever that is: by its identifier it then runs
    on line, in the study and in ``tune``
    (:data:`~sosml_friction.observers.registry.OBSERVERS`).

    :param gains: per gain one value for each joint, units in ``gain_units``.
    :raises ConfigurationError: if a gain is missing, unknown, of the wrong length or out of range.
    """

    identifier: ClassVar[str]
    #: What a person calls it, in tables and figures.
    label: ClassVar[str]
    #: Its place in tables, from simple to elaborate and slow.
    place: ClassVar[float]
    #: Unit of each gain of a revolute joint; a prismatic one has N for Nm and m for rad.
    gain_units: ClassVar[Mapping[str, str]]
    #: Gains that must not be zero; none may be negative.
    positive_gains: ClassVar[tuple[str, ...]] = ()
    #: False for a smoother, which needs the whole recording and cannot run in a node.
    causal: ClassVar[bool]
    #: True where a friction law is built in: to fit one to the estimate is to get it back.
    carries_law: ClassVar[bool] = False
    #: True where the estimate of a joint depends on the efforts of the others.
    coupled: ClassVar[bool] = False
    #: True where the torque of an acceleration is taken for friction.
    slow_motion_only: ClassVar[bool] = False
    #: The variants of it in the study, by name, in the order of its tables.
    study: ClassVar[Mapping[str, SearchSpace]]

    registry: ClassVar[Registry[Observer]] = Registry(
        'observer', 'sosml_friction.observers.kinds', lambda kind: kind.place
    )

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        lacking = [name for name in _OWN if name not in vars(cls)]
        lacking += [name for name in _SAID if not hasattr(cls, name)]
        if lacking:
            raise TypeError(f'the observer {cls.__name__} does not say its {", ".join(lacking)}')
        cls.registry.add(cls)

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        unknown = sorted(set(gains) - set(self.gain_units))
        missing = [name for name in self.gain_units if name not in gains]
        if unknown or missing:
            raise ConfigurationError(
                f'observer {self.identifier} takes the gains {", ".join(self.gain_units)}: '
                f'missing {", ".join(missing) or "none"}, unknown {", ".join(unknown) or "none"}'
            )
        try:
            self.gains = {name: np.array(gains[name], dtype=float) for name in self.gain_units}
        except (TypeError, ValueError) as error:
            written = ', '.join(f'{name} {gains[name]!r}' for name in self.gain_units)
            raise ConfigurationError(
                f'observer {self.identifier} needs a list of numbers for each gain: it has '
                f'{written}'
            ) from error
        shapes = {gain.shape for gain in self.gains.values()}
        usable = all(np.all((gain >= 0.0) & np.isfinite(gain)) for gain in self.gains.values())
        if len(shapes) != 1 or len(next(iter(shapes))) != 1 or not usable:
            written = ', '.join(f'{name} {gain.tolist()}' for name, gain in self.gains.items())
            raise ConfigurationError(
                f'observer {self.identifier} needs one finite gain >= 0 for each joint: it '
                f'has {written}'
            )
        for name in self.positive_gains:
            if not np.all(self.gains[name] > 0.0):
                raise ConfigurationError(
                    f'gain {name} of observer {self.identifier} must be positive'
                )
        self.n = shapes.pop()[0]

    @classmethod
    @abstractmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """
        Return the gains for the noise, the friction and the motion.

        They balance the noise that is let through against the square of the error after a jump D,
        averaged over the time T between jumps.
        """

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """
        Return the gains for which a slow disturbance is followed with the delay 1 / w.

        None where the observer has no bandwidth of its own.

        :param w: (n,) [rad/s].
        :param momentum_noise: standard deviation s_p of the momentum, (n,) [Nm s or N s].
        """
        return None

    @abstractmethod
    def start(self, p: FloatArray) -> None:
        """
        Begin afresh, all joints, at momentum ``p`` with the estimate zero.

        :param p: momentum (n,) [Nm s or N s].
        """

    @abstractmethod
    def run(self, samples: MomentumSamples) -> FloatArray:
        """Advance over the intervals and return tau_e at the end of each, (N, n) [Nm or N]."""

    @abstractmethod
    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the digital filter b(z) / a(z) from the true disturbance to its estimate.

        What the observer does to a disturbance, so that a friction law can be compared with its
        output without the lag counting as friction.

        :param h: sampling interval [s].
        :param joint: which joint's gains.
        """
