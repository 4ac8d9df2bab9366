# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a candidate has to pass to be named."""

from sosml_friction.diagnosis.decision.finding import Finding


def failed_gates(finding: Finding) -> tuple[str, ...]:
    """Return what speaks against naming a finding."""
    failed = [finding.objection] if finding.objection else []
    gain = finding.score.cv_gain
    if not gain > finding.floor:
        failed.append(
            f'it removes {100 * gain:.1f} % of what is unexplained on data left out, '
            f'within the floor of {100 * finding.floor:.1f} %'
        )
    return tuple(failed)
