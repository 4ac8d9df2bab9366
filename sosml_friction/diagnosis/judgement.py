# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fourth step of a diagnosis: what the causes are worth on data that their fit did not see."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.diagnosis.decision.forward_gain import HORIZON_S, ForwardGain
from sosml_friction.diagnosis.decision.forward_gate import forward_gate
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.extended_model.carry_over import (
    Key,
    cause_gains,
    what_carries_over,
    what_recurs,
)
from sosml_friction.diagnosis.extended_model.cause_gain import CauseGain
from sosml_friction.diagnosis.extended_model.effort_error import (
    HeldOut,
    another_recording,
    folds_left_out,
)
from sosml_friction.diagnosis.extended_model.gain import Gain, make_gain
from sosml_friction.diagnosis.search import Search
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.carried_load import with_carried_load


@dataclass(frozen=True)
class Judgement:
    """
    Hold the causes that stay, and their gain.

    ``selection``: what no simulation of data left out contradicts; ``kept``: those of them that
    the extended model has. ``gains``: of each cause by itself. ``folds``: the data left out of
    each fit of the recordings.
    """

    selection: Selection
    kept: Selection
    gain: Gain
    gains: Mapping[Key, CauseGain]
    folds: HeldOut

    @classmethod
    def of(cls, search: Search, model: RobotModelFile, keep_all: bool) -> 'Judgement':
        """
        Judge what was found by the data that a fit did not see.

        :param keep_all: keep causes in the extended model that another recording contradicts.
        """
        laboratory, selection = search.laboratory, search.selection
        others = search.design.others
        if others is not None and np.any(laboratory.signals[0].more_load):
            count = len(laboratory.nominal.bound)
            placed = [finding.placed for finding in selection.accepted]
            others = tuple(with_carried_load(others, placed, selection.after.x, count))
        folds = folds_left_out(laboratory)
        selection = what_recurs(laboratory, selection, folds)
        held = folds if others is None else another_recording(laboratory, others)
        forward = judge = ForwardGain(laboratory, model, others)
        contradicted = False
        if others is not None:
            carried, _ = what_carries_over(laboratory, selection, held)
            contradicted = carried is not selection
        if contradicted:
            # What another recording contradicts may be right in these: their folds judge it.
            judge = ForwardGain(laboratory, model)
        selection, before, after = forward_gate(judge, laboratory, selection)
        if len(selection.accepted) < len(search.selection.accepted):
            # What is left is more without it, and may have a structure.
            selection = selection.with_remainder(laboratory)
        kept, gains = selection, cause_gains(laboratory, selection, held)
        if others is not None:
            carried, gains = what_carries_over(laboratory, selection, held)
            kept = selection if keep_all else carried
        if contradicted:
            before = forward.squares((), selection.before.x, selection.before.fold_x)
            after = forward.squares(kept.accepted, kept.after.x, kept.after.fold_x)
        gain = make_gain(
            held.error(selection.before, ()),
            held.error(kept.after, kept.accepted),
            held.measured,
            before,
            after,
            HORIZON_S,
            held.on,
        )
        return cls(selection, kept, gain, gains, folds)
