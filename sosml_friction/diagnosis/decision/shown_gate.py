# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The gate of the numbers: no cause stays that may as well be nothing beside the others."""

from dataclasses import replace

from sosml_friction.diagnosis.decision.model_causes import model_causes
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.selector import Selector
from sosml_friction.diagnosis.decision.verdict import not_shown


def shown_gate(selector: Selector, selection: Selection) -> Selection:
    """
    Take back, the last first, causes that beside the others may be nothing.

    One that is alone stays, for :func:`~.verdict.verdict_of`: it explains more than its floor, so
    that something is there. What is within its tolerance is no other cause.
    """
    names = selector.laboratory.robot.names
    while len(selection.accepted) > 1:
        causes = model_causes(selection.laboratory or selector.laboratory, selection)
        told = [cause for cause in causes if not cause.tolerated]
        hidden = {(cause.effect, cause.joint): why for cause in told if (why := not_shown(cause))}
        at = [k for k, f in enumerate(selection.accepted) if f.reported(names) in hidden]
        if len(told) < 2 or not at:
            break
        last = at[-1]
        finding = selection.accepted[last]
        taken = replace(finding, failed=(f'it may be nothing: {hidden[finding.reported(names)]}',))
        fewer = replace(selection, accepted=selection.others(last), rejected=taken)
        selection = selector.settled(fewer)
    return selection
