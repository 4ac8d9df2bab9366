# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a test repeats and varies in the suite, and in full behind ``make validate``."""

from __future__ import annotations

import os
from typing import Any

import pytest

#: Whether statistical runs are as long as the documentation's.
FULL = 'SOSML_FRICTION_SEEDS' in os.environ
#: Marks a case that is one more of what the suite has another one of.
only_full = pytest.mark.skipif(not FULL, reason='make validate has it (SOSML_FRICTION_SEEDS)')


def in_full(*values: Any, **options: Any) -> Any:
    """Return a case of a parametrised test that only the full runs have."""
    return pytest.param(*values, marks=only_full, **options)


def often(full: int) -> int:
    """Return how often a drawing is repeated, a third of ``full`` in the suite."""
    return full if FULL else full // 3
