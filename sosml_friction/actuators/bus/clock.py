# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The time the driver lives in."""

import time
from abc import ABC, abstractmethod


class Clock(ABC):
    """Tell the time in integer nanoseconds and wait for a moment."""

    @abstractmethod
    def now_ns(self) -> int:
        """Return the time now [ns]; never goes backwards."""

    @abstractmethod
    def sleep_until_ns(self, t_ns: int) -> None:
        """Return at ``t_ns`` [ns], at once if that is past."""


class MonotonicClock(Clock):
    """The machine's CLOCK_MONOTONIC."""

    def now_ns(self) -> int:
        """Return the time since an arbitrary origin [ns]."""
        return time.monotonic_ns()

    def sleep_until_ns(self, t_ns: int) -> None:
        """Sleep until ``t_ns``."""
        remaining = t_ns - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
