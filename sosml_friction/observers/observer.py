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
from sosml_friction.observers.momentum_samples import MomentumSamples

FloatArray = NDArray[np.float64]


class Observer(ABC):
    """
    Estimate the disturbance tau_e in p' = tau + C^T q' - g + tau_e, joint by joint.

    tau_e = -tau_f: the minus sign is applied once, in
    :class:`~sosml_friction.observers.friction_estimator.FrictionEstimator`.

    On line and over a recording it is the same :meth:`run`, with one interval or with many, so the
    two agree to the last bit. A joint whose forcing is not finite has no estimate over that
    interval (NaN) and starts afresh at its end; the other joints go on.

    :param gains: per gain one value for each joint, units in ``gain_units``.
    :raises ConfigurationError: if a gain is missing, unknown, of the wrong length or out of range.
    """

    identifier: ClassVar[str]
    #: Unit of each gain of a revolute joint; a prismatic one has N for Nm and m for rad.
    gain_units: ClassVar[Mapping[str, str]]
    #: Gains that must not be zero.
    positive_gains: ClassVar[tuple[str, ...]] = ()
    #: False for a smoother, which needs the whole recording and cannot run in a node.
    causal: ClassVar[bool] = True
    #: True where a friction law is built in: to fit one to the estimate is to get it back.
    carries_law: ClassVar[bool] = False

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
