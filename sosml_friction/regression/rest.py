# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One rest of a joint."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray


@dataclass(frozen=True)
class Rest:
    """
    Hold what an effort of any course during one rest of a joint is in the band.

    ``rows`` of the band that see it; ``base`` (rows, r): orthonormal, None where they see nothing
    else and all of it is.
    """

    joint: int
    rows: slice
    base: FloatArray | None
