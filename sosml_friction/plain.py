# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as people write them, and documents as JSON and YAML take them."""

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

_NUMBER = re.compile(r'[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?', re.ASCII)


def plain_number(text: str) -> float:
    """
    Return the number that a text is, with a point for its decimals; ``1_0`` and ``nan`` are none.

    :raises ValueError: if it is no number, or larger than a number can be.
    """
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        raise ValueError(f'{text!r} is no number')
    value = float(text)
    if not abs(value) < float('inf'):
        raise ValueError(f'{text!r} is larger than a number can be')
    return value


def to_plain(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document in plain Python types, a number that is not finite as None."""
    return {str(key): _plain(entry) for key, entry in document.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return to_plain(value)
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
