# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether an answer came later than usual, so that nobody knows when it was measured."""

# So many late answers in a row are the usual time from then on. Chosen, no measurement.
NEW_USUAL = 25
# By how much the usual latency follows each answer, as a share of the tolerance: by as much as it
# may differ within a hundred answers. Chosen, no measurement.
_FOLLOWS = 0.01


class Lateness:
    """
    Follow the median of a latency, and tell what is later.

    An actuator measures when it is asked. Where an answer comes ``tolerance_ns`` later than half
    of them do, the program stood still, or the bus: between its questions, before one of them
    arrived, or after the answer. Position and effort are then up to so much apart, or from their
    stamp, and an effort that is d late reads as viscous friction.

    :param tolerance_ns: what a time of measurement may be wrong by [ns].
    """

    def __init__(self, tolerance_ns: int) -> None:
        self._tolerance_ns = tolerance_ns
        self._step_ns = max(1, round(_FOLLOWS * tolerance_ns))
        self._in_a_row = 0
        #: The median latency [ns], None before the first.
        self.usual_ns: int | None = None

    def is_late(self, latency_ns: int) -> bool:
        """Take one latency [ns] and tell whether its answer was late."""
        if self.usual_ns is None:
            self.usual_ns = latency_ns
        late = latency_ns - self.usual_ns > self._tolerance_ns
        self._in_a_row = self._in_a_row + 1 if late else 0
        if self._in_a_row >= NEW_USUAL:
            self.usual_ns, self._in_a_row, late = latency_ns, 0, False
        change_ns = latency_ns - self.usual_ns
        self.usual_ns += max(-self._step_ns, min(self._step_ns, change_ns))
        return late
