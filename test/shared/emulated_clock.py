# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A clock for what lives in emulated time."""

from __future__ import annotations

from sosml_friction.actuators.bus.clock import Clock


class EmulatedClock(Clock):
    """A clock that moves only when told to: waiting costs no wall-clock time."""

    def __init__(self, now_ns: int = 0) -> None:
        self._now_ns = now_ns

    def now_ns(self) -> int:
        """Return the emulated time [ns]."""
        return self._now_ns

    def sleep_until_ns(self, t_ns: int) -> None:
        """Set the time to ``t_ns`` unless it is later already."""
        self._now_ns = max(self._now_ns, t_ns)
