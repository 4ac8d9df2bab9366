# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What gears pass on once terms have changed the bodies behind them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.regression.estimate import equations_of
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.whitened import WhitenedRegression

#: Rounds in which bodies and friction by their load settle: a gear loses a tenth of its load, so
#: that each leaves a tenth of what the one before did.
_ROUNDS = 3
_LOAD = 'load'


def with_carried_load(
    signals: Sequence[Signals], placed: Sequence[Placed], x: FloatArray, nominal: int
) -> list[Signals]:
    """
    Return stretches whose load is that of the bodies with what terms change of them.

    :param x: all fitted parameters, the ``nominal`` ones first, then those of ``placed`` in order.
    """
    result = []
    for s in signals:
        more = np.zeros_like(s.q)
        for each, part in with_amplitudes(placed, nominal):
            if isinstance(each.term, BodyTerm):
                more += each.term.carried(s, each.joint, each.inner) @ x[part]
        result.append(replace(s, more_load=more, cache={}))
    return result


def fitted_to_carried_load(
    laboratory: WhitenedRegression, placed: Sequence[Placed]
) -> tuple[WhitenedRegression, list[Placed]]:
    """Return both with friction by the load of the bodies that terms have changed, if any."""
    placed = list(placed)
    follows = [k for k, each in enumerate(placed) if each.term.axis == _LOAD]
    if not follows or not any(isinstance(each.term, BodyTerm) for each in placed):
        return laboratory, placed
    count = len(laboratory.nominal.bound)
    for _ in range(_ROUNDS):
        x, _ = equations_of(laboratory, placed).solve()
        signals = with_carried_load(laboratory.signals, placed, x, count)
        rows = replace(laboratory.rows, signals=tuple(signals))
        laboratory = replace(laboratory, rows=rows)
        for k in follows:
            placed[k] = placed[k].with_inner(laboratory, placed[k].inner)
    return laboratory, placed
