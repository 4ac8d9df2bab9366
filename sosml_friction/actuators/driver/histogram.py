# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Count durations in bins that never grow."""

from bisect import bisect_left

# Upper edges [ms]; one more bin takes what is beyond.
EDGES_MS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


class Histogram:
    """Count durations by bins (edge before, edge], the last without an end."""

    def __init__(self) -> None:
        self.counts = [0] * (len(EDGES_MS) + 1)
        self.greatest_ns = 0

    def add(self, duration_ns: int) -> None:
        """Count one duration [ns]."""
        self.counts[bisect_left(EDGES_MS, duration_ns * 1e-6)] += 1
        self.greatest_ns = max(self.greatest_ns, duration_ns)

    @property
    def total(self) -> int:
        """Return how many durations were counted."""
        return sum(self.counts)

    def text(self) -> str:
        """Return the bins that are not empty: ``<= 0.5 ms: 3, <= 2 ms: 1, > 100 ms: 1``."""
        parts = [
            f'<= {edge:g} ms: {count}'
            for edge, count in zip(EDGES_MS, self.counts, strict=False)
            if count
        ]
        if self.counts[-1]:
            parts.append(f'> {EDGES_MS[-1]:g} ms: {self.counts[-1]}')
        return ', '.join(parts) or 'none'
