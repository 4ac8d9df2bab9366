# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Documents as JSON and YAML take them."""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def to_plain(document: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return a document in plain Python types, a number that is not finite as None.

    A result in it is what its ``to_dict`` says, a dataclass without that its fields by name.
    """
    return {str(key): _plain(entry) for key, entry in document.items()}


def _plain(value: Any) -> Any:
    if hasattr(value, 'to_dict'):
        return to_plain(value.to_dict())
    if is_dataclass(value):
        return {own.name: _plain(getattr(value, own.name)) for own in fields(value)}
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
