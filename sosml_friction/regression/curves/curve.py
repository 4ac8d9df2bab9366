# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of free curves: what any term along an axis could explain at most."""

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term


class Curve(Term, registered=False):
    """A function without physics: it has columns, and is no term of a model."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__(registered=False)

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """
        Refuse: a curve is no model of anything.

        :raises ConfigurationError: always.
        """
        raise ConfigurationError(f'the free curve {self.identifier} cannot be simulated')
