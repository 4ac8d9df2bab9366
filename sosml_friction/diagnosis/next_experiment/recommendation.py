# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What to do next where data leave causes open, with what was weighed."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sosml_friction.model.terms.kinds.term import ALL_JOINTS


@dataclass(frozen=True)
class Option:
    """
    Hold one thing to do: a trajectory of ``sosml trajectory``, or a change of condition.

    ``overlap``: share of the first cause that the second explains, with what it adds to these
    data; ``margin``: log-likelihood by which the right one leads then.
    """

    name: str
    kind: str
    duration_s: float
    overlap: float
    margin: float
    instruction: str


@dataclass(frozen=True)
class Recommendation:
    """
    Hold what to do next.

    ``pair``: the two causes, ``joint`` where the first is; ``overlap``: share of the first that
    the second explains in these data; ``margin``: log-likelihood that separates them here,
    ``needed`` what would do; ``trajectory``: a name for ``sosml trajectory``, or None;
    ``condition``: what to change instead, or ''; ``duration_s``, ``predicted_overlap`` and
    ``predicted_margin``: with these data and those of what is recommended together; NaN where
    the joint sensors do not take part. ``options``: all that was weighed, best first.
    """

    pair: tuple[str, str]
    joint: str
    overlap: float
    margin: float
    needed: float
    trajectory: str | None = None
    duration_s: float = np.nan
    predicted_overlap: float = np.nan
    predicted_margin: float = np.nan
    condition: str = ''
    options: tuple[Option, ...] = ()

    @property
    def sentence(self) -> str:
        """Return it for a person."""
        one, other = (name.replace('_', ' ') for name in self.pair)
        where = '' if self.joint == ALL_JOINTS else f' ({self.joint})'
        text = (
            f'{one} and {other}{where} are {100 * self.overlap:.1f} % the same in these data '
            f'(margin {self.margin:.2g}, needed {self.needed:g})'
        )
        predicted = ''
        if np.isfinite(self.predicted_margin):
            predicted = (
                f'{100 * self.predicted_overlap:.1f} % the same with both recordings, margin '
                f'{self.predicted_margin:.2g}'
            )
        if self.trajectory is not None:
            return (
                f'{text}: run {self.trajectory} ({self.duration_s:.0f} s; predicted {predicted})'
            )
        if self.condition and predicted:
            return (
                f'{text}, and no trajectory separates them: {self.condition} '
                f'({self.duration_s:.0f} s; predicted {predicted})'
            )
        if self.condition:
            return f'{text}, and no trajectory separates them: {self.condition}'
        return f'{text}: nothing on the menu separates them; change the load or the posture'

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {**asdict(self), 'sentence': self.sentence}
