# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a recorded control law makes the recorded effort, and what it leaves."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray

#: Largest share of the feedback effort that a control law may leave unexplained; above, the law is
#: not the recorded one. In two recordings with cycles of 1 to 24 ms the true law left 7 and 8 %,
#: with kp 20 % lower 16 and 17 %, with kp 40 % lower 28 and 30 %. Noise may leave the same share
#: of the whole effort besides.
_MOST_LEFT, _NOISE = 0.2, 0.02
#: An injected signal is on where what is left is more than this share of its 0.99 quantile.
#: Chosen, no measurement: the middle between on and off.
_ON = 0.5
#: Pieces of fewer samples than this on the average are a signal that is not switched on and off.
#: Chosen, no measurement.
_PIECE = 10


@dataclass(frozen=True)
class LawCheck:
    """
    Hold what the law of a joint, fed with the recorded motion, leaves of the recorded effort.

    ``left`` (N,) [Nm or N], NaN where it is not known; ``made``: mean size of the recorded effort
    without what was fed forward, which the gains should make; ``size``: that of the whole effort;
    ``time`` (N,) [s].
    """

    joint: str
    left: FloatArray
    made: float
    size: float
    time: FloatArray

    @property
    def share(self) -> float:
        """Return which share of what the gains should make is left [%]."""
        return 100.0 * float(np.nanmean(np.abs(self.left))) / max(self.made, 1e-300)

    @property
    def holds(self) -> bool:
        """Tell whether the law is the one that was at work, as far as noise lets it be told."""
        return float(np.nanmean(np.abs(self.left))) <= _MOST_LEFT * self.made + _NOISE * self.size

    def remark(self) -> str:
        """Return how much the law explains."""
        return (
            f'{self.joint}: the recorded law makes the recorded effort, but for {self.share:.2g} %'
        )

    def objection(self, unit: str) -> str:
        """Return what the law leaves, and when: a signal that was added, or another law."""
        size = np.nan_to_num(np.abs(self.left))
        level = float(np.quantile(size, 0.99))
        on = np.flatnonzero(size > _ON * level)
        pieces = 1 + int(np.count_nonzero(np.diff(on) > 1))
        when = f' in {pieces} pieces' if len(on) >= _PIECE * pieces else ''
        return (
            'the recorded controller and wanted motion do not make the recorded effort of '
            f'{self.joint}: {self.share:.0f} % of what its gains should make is left, '
            f'{level:.3g} {unit}{when} from {self.time[on[0]]:.4g} to {self.time[on[-1]]:.4g} s '
            f'({100.0 * len(on) / len(size):.0f} % of the time): a signal was added to its '
            'command, which the mapping of sosml import takes as injected, or the gains are not '
            'those that were at work'
        )
