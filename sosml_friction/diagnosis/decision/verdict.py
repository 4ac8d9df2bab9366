# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The verdict: what the causes, and what is left beside them, amount to."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.data_causes import FAULTS
from sosml_friction.diagnosis.decision.leftover import SPEED, Leftover
from sosml_friction.diagnosis.decision.selection import Selection

VERDICTS = ('named', 'ambiguous', 'nothing_above_floor', 'unknown_structure', 'bad_data')
#: If free curves predict more than this share of what they and the causes predict together, the
#: causes are the smaller part.
_REST = 0.5


def verdict_of(causes: Sequence[Cause], selection: Selection) -> str:
    """Return one of :data:`VERDICTS`; that data are bad is found before there is a selection."""
    if _causes_are_not_all(selection):
        return 'unknown_structure'
    # A fault of the data leaves no residual: it does not explain one.
    if any(cause.effect not in FAULTS for cause in causes):
        return 'ambiguous' if any(cause.rivals for cause in causes) else 'named'
    over = selection.structure_gain > selection.structure_floor
    if over.any() or _an_impossible_one_explains_more(selection):
        return 'unknown_structure'
    return 'named' if causes else 'nothing_above_floor'


def more_along_axis(selection: Selection) -> list[Leftover]:
    """Return where a free curve explains what the causes of its axis leave."""
    return [x for x in selection.leftovers if x.significant]


def _causes_are_not_all(selection: Selection) -> bool:
    """Tell whether the accepted are the smaller part, or not the whole of their axis."""
    over = selection.structure_gain > selection.structure_floor
    rest = float(np.maximum(selection.structure_energy, 0.0)[over].sum())
    whole = max(selection.named_energy, 0.0) + rest
    if selection.accepted and rest > _REST * whole:
        return True
    more = more_along_axis(selection)
    if any(x.instead or x.foreign for x in more):
        return True
    on_axis = all(f.effect.free_axis == SPEED for f in selection.accepted)
    return bool(selection.accepted and on_axis and more)


def _an_impossible_one_explains_more(selection: Selection) -> bool:
    """Tell whether one that is possible was refused for an impossible one that explains more."""
    rejected = selection.rejected
    return (
        selection.masked is not None
        and rejected is not None
        and rejected.score.cv_gain > rejected.floor
    )
