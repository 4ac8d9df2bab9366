# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The last gate: no cause makes the simulation of data left out worse."""

from dataclasses import replace

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.forward_gain import ForwardGain, gets_worse
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.regression.whitened import WhitenedRegression

#: Why a cause is taken back.
FORWARD_WORSE = 'the forward simulation of data left out gets worse with it'


def forward_gate(
    forward: ForwardGain, laboratory: WhitenedRegression, selection: Selection
) -> tuple[Selection, FloatArray, FloatArray]:
    """
    Take back the last causes while they make the simulation of data left out worse.

    Worse than that of the refitted nominal, or than without the last one. Returns what stays, and
    the mean squares of the windows (W, n), refitted and with the causes that stay.
    """
    before = forward.squares((), selection.before.x, selection.before.fold_x)
    if not selection.accepted:
        return selection, before, before
    after = forward.squares(selection.accepted, selection.after.x, selection.after.fold_x)
    while selection.accepted:
        *left, last = selection.accepted
        fewer = selection.refitted(laboratory, left)
        x, fold_x = fewer.after.x, fewer.after.fold_x
        without = forward.squares(left, x, fold_x) if left else before
        rows = last.columns.rows
        if not (gets_worse(before, after, rows) or gets_worse(without, after, rows)):
            break
        taken = replace(last, failed=(FORWARD_WORSE,))
        selection = fewer.taken_back(taken)
        after = without
    return selection, before, after
