# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of momentum observers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError

FloatArray = NDArray[np.float64]


class Observer(ABC):
    """
    Estimate the disturbance tau_e in p' = tau + C^T q' - g + tau_e, joint by joint.

    tau_e = -tau_f: the minus sign is applied once, in
    :class:`~sosml_friction.observers.friction_estimator.FrictionEstimator`. A joint whose input is
    not finite gets a state that is not finite, and only that joint; :meth:`start` heals it.

    :param gains: per gain one value for each joint, units in ``gain_units``.
    :raises ConfigurationError: if a gain is missing, unknown, of the wrong length or out of range.
    """

    identifier: ClassVar[str]
    #: Unit of each gain of a revolute joint; a prismatic one has N for Nm.
    gain_units: ClassVar[Mapping[str, str]]

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
        self.n = shapes.pop()[0]

    @abstractmethod
    def start(self, p: FloatArray, joints: NDArray[np.bool_]) -> None:
        """
        Begin afresh at momentum ``p`` with the estimate zero.

        :param p: momentum (n,) [Nm s or N s].
        :param joints: which joints to start, (n,); the others keep their state.
        """

    @abstractmethod
    def step(self, p: FloatArray, forcing: FloatArray, h: float) -> FloatArray:
        """
        Advance by one interval and return tau_e at its end, (n,) [Nm or N].

        :param p: momentum at the end of the interval (n,).
        :param forcing: mean of tau + C^T q' - g over the interval (n,) [Nm or N].
        :param h: length of the interval [s], positive.
        """

    @abstractmethod
    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the digital filter b(z) / a(z) from the true disturbance to its estimate.

        What the observer does to a disturbance, so that a friction law can be compared with its
        output without the lag counting as friction.

        :param h: sampling interval [s].
        :param joint: which joint's gains.
        """
