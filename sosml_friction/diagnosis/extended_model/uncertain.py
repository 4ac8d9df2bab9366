# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number with its standard error over stretches of the data."""

from dataclasses import dataclass

from sosml_friction.regression.chance import BEYOND_CHANCE


@dataclass(frozen=True)
class Uncertain:
    """Hold a number and its standard error, by the jackknife over stretches of the data."""

    value: float
    std_error: float

    def beyond(self, other: float) -> bool:
        """Tell whether the number differs from another one by more than chance."""
        return abs(self.value - other) > BEYOND_CHANCE * self.std_error
