# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The gate of the numbers: no cause stays that may as well be nothing beside the others."""

from dataclasses import replace

from sosml_friction.diagnosis.decision.model_causes import model_causes
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.verdict import not_shown
from sosml_friction.regression.whitened import WhitenedRegression

#: Why a cause is taken back.
NOT_SHOWN = 'its interval has 0 in it'


def shown_gate(laboratory: WhitenedRegression, selection: Selection) -> None:
    """
    Take back, the last first, causes whose intervals beside the others all have 0 in them.

    One that is alone stays: it explains more than its floor, so that something is there that it
    only looks like, as a drag bends friction like the far end of a Stribeck term.
    """
    names = laboratory.robot.names
    while len(selection.accepted) > 1:
        hidden = {
            (cause.effect, cause.joint)
            for cause in model_causes(laboratory, selection)
            if not_shown(cause)
        }
        at = [k for k, f in enumerate(selection.accepted) if f.reported(names) in hidden]
        if not at:
            return
        taken = selection.accepted.pop(at[-1])
        selection.rejected = replace(taken, failed=(NOT_SHOWN,))
        selection.masked = None
        selection.refit(laboratory)
        selection.judge_remainder(laboratory)
