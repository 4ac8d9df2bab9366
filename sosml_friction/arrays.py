# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The types of arrays: their shapes stand where they are used."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
#: Floating-point numbers, of single precision where very many are kept.
ColumnArray = NDArray[Any]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.int64]
#: What an array holds, where a function returns some of it.
Entry = TypeVar('Entry', bound=np.generic)
