# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Wrong reports of an effort of which the friction is found beside them."""

from collections.abc import Sequence
from dataclasses import replace

from sosml_friction.diagnosis.decision.in_torque import in_torque
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.regression.estimate import Placed, equations_of
from sosml_friction.regression.refitted_friction import with_friction
from sosml_friction.regression.whitened import WhitenedRegression

#: Rounds in which friction and what is wrong with its report settle: a report is wrong by a tenth,
#: so that each leaves a tenth of what the one before did.
_ROUNDS = 3


def fitted_to_found_friction(
    laboratory: WhitenedRegression, placed: Sequence[Placed]
) -> tuple[WhitenedRegression, list[Placed]]:
    """
    Return the regression and the terms with the friction of the torque, not of the report.

    As they are where the model knows friction, or no term is made from all of the effort.
    """
    placed, found = list(placed), laboratory.signals[0].found_friction
    follows = [
        k
        for k, each in enumerate(placed)
        if isinstance(each.term, MeasurementTerm) and each.term.of_all_effort
    ]
    if not follows or not found:
        return laboratory, placed
    names = laboratory.nominal.names
    for _ in range(_ROUNDS):
        x, _ = equations_of(laboratory, placed).solve()
        values, _ = in_torque(laboratory, placed, x)
        found = {name: float(values[names.index(name)]) for name in found}
        signals = tuple(with_friction(s, found) for s in laboratory.signals)
        laboratory = replace(laboratory, rows=replace(laboratory.rows, signals=signals))
        for k in follows:
            placed[k] = placed[k].with_inner(laboratory, placed[k].inner)
    return laboratory, placed
