# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Models that differ from window to window, such as those fitted without each fold."""

from collections.abc import Callable, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.simulation.forward_model import ForwardModel


class WindowModels:
    """
    Hold the models of W windows: the same terms with other numbers.

    A step of a simulation costs as much for one window as for hundreds, so that all are simulated
    together.

    :param models: with the same joints, displacements, kinds of terms and joints with gears that
        give.
    :param of: which of the models each window has (W,).
    """

    def __init__(self, models: Sequence[ForwardModel], of: IndexArray) -> None:
        self.models, self.of = tuple(models), of
        first = self.first = models[0]
        self.n, self.displacement = first.n, first.displacement
        self.bent = [gear.joint for gear in first.gears]
        self.friction = JointFriction.of_windows([model.friction for model in models], of)
        self.terms = [
            terms[0].of_windows(terms, of)
            for terms in zip(*(model.terms for model in models), strict=True)
        ]
        self.robots = [models[k].robot for k in of]
        self.rotors = self.numbers(lambda model: model.rotors)
        self.rigid = self.numbers(lambda model: np.diag(model.rigid_rotors()))
        self.stiffness = self.numbers(lambda m: np.array([gear.stiffness for gear in m.gears]))
        self.half_gap = self.numbers(lambda m: np.array([0.5 * gear.gap for gear in m.gears]))
        self.damping = self.numbers(lambda m: np.array([gear.damping for gear in m.gears]))

    def numbers(self, of_model: Callable[[ForwardModel], FloatArray]) -> FloatArray:
        """Return what each window's model has, (W, ...)."""
        return np.array([of_model(model) for model in self.models])[self.of]

    def each(self, part: Callable[[ForwardModel, IndexArray], FloatArray]) -> FloatArray:
        """Return (W, ...) made of ``part(model, its windows)`` of every model."""
        rows = [np.flatnonzero(self.of == k) for k in range(len(self.models))]
        used = [(model, own) for model, own in zip(self.models, rows, strict=True) if len(own)]
        result = np.concatenate([part(model, own) for model, own in used])
        order = np.concatenate([own for _, own in used])
        return result[np.argsort(order, kind='stable')]

    def true_position(self, measured: FloatArray) -> FloatArray:
        """Return where the motors are, (W, n)."""
        return self.each(lambda model, own: model.true_position(measured[own]))

    def measured_position(self, true: FloatArray) -> FloatArray:
        """Return what the encoders say, (W, n)."""
        return self.each(lambda model, own: model.measured_position(true[own]))

    def steps(self, q: FloatArray, effort: FloatArray, period: float) -> int:
        """Return in how many steps a period is integrated: the most that a model needs."""
        return max(model.steps(q, effort, period) for model in self.models)


def as_window_models(model: ForwardModel | WindowModels, windows: int) -> WindowModels:
    """Return the models of windows that may all have the same."""
    if isinstance(model, WindowModels):
        return model
    return WindowModels([model], np.zeros(windows, dtype=np.int64))
