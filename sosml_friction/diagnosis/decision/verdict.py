# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The verdict: what the causes, and what is left beside them, amount to."""

import math
import re
from collections.abc import Sequence

from scipy.stats import norm

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.forward_gate import FORWARD_WORSE
from sosml_friction.diagnosis.decision.leftover import REST
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.model.parameter import Z_95, Parameter
from sosml_friction.model.terms.kinds.term import TERMS

#: The end of the name of a harmonic's size.
_HARMONIC = re.compile(r'_\d+$')
VERDICTS = ('named', 'ambiguous', 'nothing_above_floor', 'unknown_structure', 'bad_data')


def verdict_of(causes: Sequence[Cause], selection: Selection, untold: Sequence[str] = ()) -> str:
    """
    Return one of :data:`VERDICTS`; that data are bad is found before there is a selection.

    :param untold: joints whose inertia the effort contradicts: no cause is not that all is well.
    """
    # What has no name, a tone or a ripple, explains nothing, unless it is the smaller part: what
    # is left says then what it is.
    best = selection.rejected
    has_no_name = best is not None and bool(best.instead)
    if best is not None and selection.accepted:
        has_no_name &= best.score.gain > selection.before.cost - selection.after.cost
    # What the data show by themselves, a contact or a late velocity, explains nothing of what is
    # left beside it. Neither does what only an impossible cause explains, or one that the
    # simulation contradicts: it is there, and is another.
    left = bool(selection.accepted) and _causes_are_not_all(selection)
    if all(cause.shown_by_data for cause in causes):
        left = left or bool(selection.remainder.beyond_chance) or selection.refused is not None
        left = left or bool(untold) or contradicted_by_simulation(selection)
    if has_no_name or left or any(not_shown(cause) for cause in causes):
        return 'unknown_structure'
    if any(cause.rivals for cause in causes):
        return 'ambiguous'
    return 'named' if causes else 'nothing_above_floor'


def contradicted_by_simulation(selection: Selection) -> bool:
    """Tell whether the best that was not accepted has the evidence, and simulates worse."""
    return selection.rejected is not None and selection.rejected.failed == (FORWARD_WORSE,)


def not_shown(cause: Cause) -> str:
    """
    Return why a term may as well be nothing, as far as its intervals say; '' if it may not.

    What repeats with position any number of times is no line.

    The best of K candidates is beyond its own interval by chance K times as often: where all of
    them together are to be in 5 % of recordings, each is in 5 % / K (Bonferroni). The intervals
    know of what is left beside a term: something is there that it only looks like, as a drag bends
    friction like the far end of a Stribeck term. What is off within its tolerance moves a size
    no further than all of it does at its bounds: z standard errors of a distribution that ends are
    beyond its end. That one of several rivals is there may be sure where each of them is not.
    """
    kind = TERMS.classes.get(cause.effect)
    if kind is None:
        return ''
    line = cause.parameters.get('frequency') if kind.repeats else None
    if line is not None and line.interval is not None and not math.isfinite(line.interval[1]):
        return 'what is left beside it leaves its frequency open'
    if not cause.size_known or cause.rivals:
        return ''
    sizes = {kind.reported_as.get(name, name) for name in kind.amplitudes}
    # Those of a harmonic have its number behind their names.
    own = {
        name: p for name, p in cause.parameters.items() if {name, _HARMONIC.sub('', name)} & sizes
    }
    # Of a term that the model states nothing is missing where it is as stated.
    z = float(norm.isf(norm.sf(Z_95) / cause.tried))

    def may_be_as_stated(name: str, p: Parameter) -> bool:
        spread, most = cause.by_tolerance.get(name, (0.0, 0.0))
        reach = min(z, z * math.sqrt(max(1.0 - spread**2, 0.0)) + most)
        return p.may_be(cause.stated.get(name, 0.0), reach / Z_95)

    if own and all(may_be_as_stated(name, p) for name, p in own.items()):
        return f'of {cause.tried} candidates one has such a size by chance'
    return ''


def _causes_are_not_all(selection: Selection) -> bool:
    """Tell whether the accepted are not the whole of a joint, or the smaller part of all."""
    left = selection.remainder
    acted = {int(row) for finding in selection.accepted for row in finding.columns.rows}
    if any(x.joint in acted for x in left.significant):
        return True
    rest = sum(x.energy for x in left.beyond_chance)
    return rest > REST * (left.named + rest)
