# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a free curve still explains beside the causes along its axis."""

from dataclasses import dataclass

#: Axes of curves that no cause has.
NEIGHBOURS = 'the position of the next joint'
NEIGHBOUR_FRICTION = 'friction by the position of the next joint'
#: Axes of free curves that could stand for causes, as ``Term.free_axis`` names them.
SPEED, POSITION = 'speed', 'position'


@dataclass(frozen=True)
class Leftover:
    """
    Hold what a free curve along an axis of a joint still predicts beside the named causes.

    ``gain``: whitened energy that it removes, ``energy``: the same on data left out; ``floor``:
    what ``gain`` has to exceed. ``share``: ``gain`` of all that the causes of this axis and the
    curve explain together; ``least``: the largest share with which the causes are the whole.
    ``instead``: the curve is one power of speed that explains more than all causes by speed.
    ``foreign``: no cause of the catalogue has such a curve.
    """

    axis: str
    joint: int
    gain: float
    energy: float
    floor: float
    share: float
    least: float
    instead: bool = False
    foreign: bool = False

    @property
    def significant(self) -> bool:
        """Tell whether it is beyond chance, and too much for the causes to be the whole."""
        return self.gain > self.floor and self.energy > 0.0 and self.share > self.least
