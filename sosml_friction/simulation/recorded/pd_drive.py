# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's own controller in the loop of a simulation, cycle by recorded cycle."""

from collections.abc import Mapping

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.motion.velocity import WindowedSlope
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.loop_drive import LoopDrive
from sosml_friction.simulation.recorded.loop_start import LoopReference, velocity_gap_ns
from sosml_friction.simulation.recorded.recorded_loop import PdGains


class PdDrive(LoopDrive):
    """
    Drive one window as the driver did, a command in each of its cycles, at the recorded times.

        u_k = ahead(t_k) + kp (q_r(t_k) - q_{k-1}) + kd (v_r(t_k) - v_{k-1}),

    clipped, then its change; q and v are the simulated ones of the cycle before, v the slope of
    the last positions over their stamps. It acts from the time of sample k on and is what sample
    k + 1 reports. Cycles are uneven as they were: a late one holds the command for longer.

    :param gains: by the joint's place in the model; the others follow the recording.
    :param stamps: (C,) of the cycles [ns], increasing; ``times`` (C,) the same in samples of the
        simulation.
    :param reference: at the cycles, joints in the model's order.
    :param q: (C, n) and tau: (C, n) measured: before the simulation begins, and of the joints that
        follow; efforts that are not known are 0.
    """

    def __init__(
        self,
        model: ForwardModel,
        period: float,
        gains: Mapping[int, PdGains],
        stamps: IndexArray,
        times: FloatArray,
        reference: LoopReference,
        q: FloatArray,
        tau: FloatArray,
    ) -> None:
        super().__init__(model, period)
        self._joints = list(gains)
        values = list(gains.values())
        self._kp, self._kd, self._limit = (
            np.array([getattr(g, key) for g in values]) for key in ('kp', 'kd', 'limit')
        )
        self._change = np.array([g.rate_limit / g.rate for g in values])
        self._stamps, self._at = stamps, times
        self._wanted = reference.q[:, self._joints]
        self._wanted_v = reference.v[:, self._joints]
        self._ahead = reference.ahead[:, self._joints]
        self._tau = tau
        self._slopes = [
            WindowedSlope(g.velocity_window, velocity_gap_ns(g.rate, g.velocity_window))
            for g in values
        ]
        self._v = np.zeros(len(values))
        self._q = q[0, self._joints]
        #: The first cycle that is simulated.
        self.first = int(np.searchsorted(times, 0.0))
        for c in range(self.first):
            self._see(c, q[c, self._joints])
        self._seen = self.first
        self._next = self.first
        # A report is of the command before, which flowed until then.
        self.ask(-np.inf, tau[min(self.first, len(tau) - 1)])
        self._before = q[max(self.first - 1, 0), self._joints]

    def begin(self, k: int, q: FloatArray) -> None:
        """Make the commands of the cycles that begin in sample ``k``."""
        super().begin(k, q)
        here = q[0, self._joints]
        step = here - self._before if k else np.zeros_like(here)
        # A cycle knows the position of the one before: between two samples, or a little ahead.
        if self._seen < self._next and self._at[self._seen] <= k:
            self._look(k, here, step)
        while self._next < len(self._at) and self._at[self._next] < k + 1:
            if self._seen < self._next:
                self._look(k, here, step)
            self._command(self._next)
            self._next += 1
        self._before = here

    def _look(self, k: int, here: FloatArray, step: FloatArray) -> None:
        self._see(self._seen, here + (self._at[self._seen] - k) * step)
        self._seen += 1

    def _see(self, c: int, q: FloatArray) -> None:
        """Take the position of a cycle, as the driver does after it."""
        self._q = q
        stamp = int(self._stamps[c])
        for i, slope in enumerate(self._slopes):
            v = slope.update(stamp, float(q[i]))
            # The driver keeps the last velocity that it knew.
            if np.isfinite(v):
                self._v[i] = v

    def _command(self, c: int) -> None:
        wanted = (
            self._ahead[c]
            + self._kp * (self._wanted[c] - self._q)
            + self._kd * (self._wanted_v[c] - self._v)
        )
        last = self.commands[-1][self._joints]
        wanted = np.clip(wanted, -self._limit, self._limit)
        effort = np.array(self._tau[c])
        effort[self._joints] = np.clip(wanted, last - self._change, last + self._change)
        self.ask(float(self._at[c]), effort)

    def reported(self) -> FloatArray:
        """Return what was reported at each simulated cycle, (C - first, n)."""
        cycles = self._at[self.first : self._next]
        late = np.maximum(0.0, self._model.delay) / self._period
        # Strictly before: a cycle's own command flows after its report.
        before = np.searchsorted(self.times, cycles[:, None] - late, side='left') - 1
        return np.take_along_axis(np.array(self.commands), np.maximum(before, 0), axis=0)
