# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of the encoder: the position is another than it says."""

from abc import abstractmethod

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.moved_body import STEP
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term


class EncoderTerm(Term):
    """State by how much the joint is ahead of its encoder, linear in the amplitudes."""

    @abstractmethod
    def error(self, q: FloatArray, inner: Inner) -> tuple[FloatArray, ...]:
        """Return true less measured position per unit of each amplitude, as ``q`` [rad or m]."""

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """
        Return the effort of a body and a rotor that are where the encoder does not say.

        The error's derivatives in time are e' q' and e'' q'^2 + e' q''; the effort is that of the
        nominal with them less that without, to the first order in e.
        """
        q = signals.q[:, joint]
        before, at, after = (
            np.stack(self.error(q + step, inner), axis=1)[:, None] for step in (-STEP, 0.0, STEP)
        )
        slope, bend = (after - before) / (2.0 * STEP), (after - 2.0 * at + before) / STEP**2
        v, a = signals.v[:, joint, None, None], signals.a[:, joint, None, None]
        moved = np.stack([at, slope * v, bend * v**2 + slope * a])[:, :, 0]
        return _more_effort(signals, joint, moved)

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """Return the encoder."""
        return _SimulatedEncoder(self, joint, inner, amplitude)


def _more_effort(signals: Recording, joint: int, moved: FloatArray) -> FloatArray:
    """Return the effort (N, n, k) that a joint's changes of q, q' and q'', (3, N, k), take."""
    state = signals.q, signals.v, signals.a
    along, parts = signals.robot.inverse_dynamics_along, []
    own = along(*state)
    for changes in np.moveaxis(moved, 2, 0):
        there = [x.copy() for x in state]
        for x, change in zip(there, changes, strict=True):
            x[:, joint] += STEP * change
        parts.append((along(*there) - own) / STEP)
    return np.stack(parts, axis=2)


class _SimulatedEncoder(SimulatedTerm):
    def __init__(self, term: EncoderTerm, joint: int, inner: Inner, amplitude: FloatArray) -> None:
        self._term, self._joint, self._inner = term, joint, inner
        self._amplitude = [float(x) for x in amplitude]

    def true_position(self, measured: FloatArray) -> FloatArray:
        result = np.array(measured)
        parts = self._term.error(measured[..., self._joint], self._inner)
        result[..., self._joint] += sum(
            x * part for x, part in zip(self._amplitude, parts, strict=True)
        )
        return result
