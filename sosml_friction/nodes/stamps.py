# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From the monotonic clock a measurement is stamped with to ROS time."""

from collections.abc import Callable

# Two readings further apart than this were interrupted between them.
_TRUSTED_NS = 50_000
_ATTEMPTS = 5


class StampConverter:
    """
    Keep the offset between two clocks [ns] and apply it to stamps.

    The offset is read anew at each :meth:`refresh`, between two readings of the monotonic clock;
    of several attempts the least disturbed counts, so that a preempted process does not shift its
    stamps.
    """

    def __init__(self, monotonic_ns: Callable[[], int], ros_ns: Callable[[], int]) -> None:
        self._monotonic_ns = monotonic_ns
        self._ros_ns = ros_ns
        self._offset_ns = 0
        self.refresh()

    def refresh(self) -> None:
        """Read the offset again: the ROS clock may be steered or set."""
        best: int | None = None
        for _ in range(_ATTEMPTS):
            before = self._monotonic_ns()
            ros = self._ros_ns()
            spread = self._monotonic_ns() - before
            if best is None or spread < best:
                best = spread
                self._offset_ns = ros - before - spread // 2
            if best < _TRUSTED_NS:
                return

    def to_ros_ns(self, stamp_ns: int) -> int:
        """Return ``stamp_ns`` in ROS time [ns]."""
        return stamp_ns + self._offset_ns
