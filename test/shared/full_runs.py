# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a test repeats and varies in the suite, and in full behind ``make validate``."""

from __future__ import annotations

import os

import pytest

#: Whether statistical runs are as long as the documentation's.
FULL = 'SOSML_FRICTION_SEEDS' in os.environ
#: Marks a case that is one more of what the suite has another one of.
only_full = pytest.mark.skipif(not FULL, reason='make validate has it (SOSML_FRICTION_SEEDS)')


def often(full: int) -> int:
    """Return how often a drawing is repeated, a third of ``full`` in the suite."""
    return full if FULL else full // 3
