# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a term may ask of a recording: an interface, so that terms stand below the regression."""

from typing import Protocol

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.scales import Scales


class LowPass(Protocol):
    """A low-pass filter: ``cutoff`` [Hz], ``step`` [s], samples kept one in ``factor``."""

    @property
    def cutoff(self) -> float: ...
    @property
    def step(self) -> float: ...
    @property
    def factor(self) -> int: ...
    def smooth(self, x: FloatArray, wider: float = ...) -> FloatArray:
        """Return ``x`` (N, ...) low-passed at ``wider`` times the cut-off."""
        ...


class Recording(Protocol):
    """
    One stretch of a recording, N samples of n joints; fields as of the regression's ``Signals``.

    ``tau`` (N, n): measured effort, but of ``silent`` joints; ``rigid``, ``friction``, ``torque``
    (N, n): nominal effort of bodies, of friction, and in all [Nm or N]; ``whole_torque``: with
    friction that the model does not tell; ``sure_torque``: without noise of position;
    ``regressor`` (N, n, 10 n): of the bodies' ten numbers each;
    ``cache``: what terms computed and want to keep.
    """

    @property
    def time(self) -> FloatArray: ...
    @property
    def q(self) -> FloatArray: ...
    @property
    def v(self) -> FloatArray: ...
    @property
    def a(self) -> FloatArray: ...
    @property
    def tau(self) -> FloatArray: ...
    @property
    def sign(self) -> FloatArray: ...
    @property
    def rigid(self) -> FloatArray: ...
    @property
    def friction(self) -> FloatArray: ...
    @property
    def torque(self) -> FloatArray: ...
    @property
    def whole_torque(self) -> FloatArray: ...
    @property
    def sure_torque(self) -> FloatArray: ...
    @property
    def regressor(self) -> FloatArray: ...
    @property
    def temperature(self) -> FloatArray | None: ...
    @property
    def silent(self) -> frozenset[int]: ...
    @property
    def motion(self) -> Motion: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def scales(self) -> Scales: ...
    @property
    def band(self) -> LowPass: ...
    @property
    def cache(self) -> dict[object, FloatArray]: ...
    def through_gears(self, load: FloatArray) -> FloatArray:
        """Return the effort that a small load beyond the gears takes, (N, n, ...) as it."""
        ...

    def effort_unit(self, joint: int) -> str:
        """Return Nm or N."""
        ...

    def length_unit(self, joint: int) -> str:
        """Return rad or m."""
        ...

    def in_joint(self, joint: int, *columns: FloatArray) -> FloatArray:
        """Return (N, n, k) that is zero but for ``columns`` (N,) in one joint."""
        ...
