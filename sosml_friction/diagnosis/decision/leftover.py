# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What something without a name still explains beside the named causes."""

import math
from dataclasses import dataclass

from sosml_friction.regression.curves.axes import (
    ACCELERATION,
    LOAD,
    NEIGHBOURS,
    POSITION,
    SPEED,
    TIME,
)
from sosml_friction.regression.rival import VERY_STRONG

TONE, BURSTS, SLOW = 'a tone', 'bursts', 'slow effort'
#: Free curves of each axis, and of friction that follows it, in the order of their columns.
AXES = (SPEED, POSITION, ACCELERATION, LOAD, TIME, *NEIGHBOURS, *NEIGHBOURS)
FRICTION_BY = 'friction by '
#: Of what is a share of the torque, as a torque constant that ripples makes it.
TORQUE_BY = 'torque constant by '
#: End of the name of two axes, of what is a function of both and no sum of one of each.
AT_ONCE = ' at once'
#: Energy of a curve, as a share of that of noise, that deviations within the tolerance, reversals
#: and rounding make where there is no cause: three times the largest of 42 recordings of three
#: plants, 0.0034, which is 0.0012 since noise is as slow as it is, and of further curves 0.0037
#: (``python -m validation.leftovers --seed 424242``).
LEAST = 0.01
#: If curves explain more than this share of what they and the causes explain together, the causes
#: are the smaller part. By definition.
REST = 0.5


def curve_floor(rows: float, tried: int = 1) -> float:
    """
    Return the energy that a curve has to exceed in ``rows``, the best of ``tried`` ones.

    The price of two parameters, as each curve that is seen has, and clear evidence.
    """
    return max(LEAST * rows, 2.0 * math.log(rows) + 2.0 * math.log(tried) + VERY_STRONG)


def share_beside(energy: float, named: float) -> float:
    """Return the share of an energy in what it and the causes explain."""
    # Causes that a fit without penalty needs less than not at all explain nothing.
    return energy / (max(named, 0.0) + energy) if energy > 0.0 else 0.0


@dataclass(frozen=True)
class Leftover:
    """
    Hold what a free curve of a joint, a tone, a ripple, bursts, or one power of speed explain.

    Or that part of what is left which is too slow for noise.

    ``energy``: whitened energy that nothing else explains; ``floor``: what it has to exceed.
    ``share``: of all that the causes of the joint and it explain; ``least``: the largest share
    beside which the causes are the whole. ``instead``: one power of speed that explains more than
    all causes by speed; ``together``: what the curves of all axes explain, none of them enough by
    itself, ``axis`` that of the largest. ``hertz``: of a tone. ``period``: of a ripple over
    position [rad or m]. ``bursts``: how many, the largest at ``at_s`` [s] of its recording.
    """

    axis: str
    joint: int
    energy: float
    floor: float
    share: float
    least: float
    instead: bool = False
    together: bool = False
    hertz: float = 0.0
    period: float = 0.0
    bursts: int = 0
    at_s: float = 0.0

    @property
    def form(self) -> str:
        """Return what it is: a tone, bursts, slow effort, a ripple, a power or a free curve."""
        if self.hertz or self.bursts:
            return 'tone' if self.hertz else 'bursts'
        if self.axis == SLOW:
            return SLOW
        return 'ripple' if self.period else 'power of speed' if self.instead else 'free curve'

    @property
    def beyond_chance(self) -> bool:
        """Tell whether it is more than noise and the model's own uncertainty make of it."""
        return self.energy > self.floor

    @property
    def significant(self) -> bool:
        """Tell whether it is too much, besides, for the causes to be the whole."""
        return self.beyond_chance and self.share > self.least
