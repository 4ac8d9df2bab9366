# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What something without a name still explains beside the named causes."""

from dataclasses import dataclass

SPEED, POSITION, ACCELERATION, LOAD = 'speed', 'position', 'acceleration', 'load'
TIME = 'time'
#: What no cause of the catalogue is a function of.
NEIGHBOURS = 'the position of the next joint', 'the speed of the next joint'
TONE = 'a tone'
#: Free curves of each axis, and of friction that follows it, in the order of their columns.
AXES = (SPEED, POSITION, ACCELERATION, LOAD, TIME, *NEIGHBOURS, *NEIGHBOURS)
FRICTION_BY = 'friction by '


@dataclass(frozen=True)
class Leftover:
    """
    Hold what a free curve of a joint, a tone, a ripple, or one power of speed still explains.

    ``energy``: whitened energy that nothing else explains; ``floor``: what it has to exceed.
    ``share``: of all that the causes of the joint and it explain; ``least``: the largest share
    beside which the causes are the whole. ``instead``: one power of speed that explains more than
    all causes by speed; ``together``: what the curves of all axes explain, none of them enough by
    itself, ``axis`` that of the largest. ``hertz``: of a tone. ``period``: of a ripple of friction
    over position [rad or m].
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

    @property
    def form(self) -> str:
        """Return what it is: a tone, a ripple, a power of speed or a free curve."""
        if self.hertz:
            return 'tone'
        return 'ripple' if self.period else 'power of speed' if self.instead else 'free curve'

    @property
    def beyond_chance(self) -> bool:
        """Tell whether it is more than noise and the model's own uncertainty make of it."""
        return self.energy > self.floor

    @property
    def significant(self) -> bool:
        """Tell whether it is too much, besides, for the causes to be the whole."""
        return self.beyond_chance and self.share > self.least
