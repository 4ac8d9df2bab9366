# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The time the driver lives in."""

import time


class Clock:
    """Tell CLOCK_MONOTONIC [ns] and wait for a moment; a subclass may live in another time."""

    def now_ns(self) -> int:
        """Return the time since an arbitrary origin [ns]; never goes backwards."""
        return time.monotonic_ns()

    def sleep_until_ns(self, t_ns: int) -> None:
        """Return at ``t_ns`` [ns], at once if that is past."""
        remaining = t_ns - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
