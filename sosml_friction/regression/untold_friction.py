# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that a model does not tell, as part of the torque that sensors report."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals


def with_untold_friction(
    stretches: Sequence[Signals], settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the stretches with the friction that they need where the model does not tell it.

    ``untold`` are C and B of C s + B q', by least squares beside a constant in the band, of the
    joints whose friction is not stated or is trusted less than the tolerance says; 0 of others.
    What a report adds follows the whole torque: with a friction that is a guess, a coupling would
    be wrong by as much as it.
    """
    scales, n = stretches[0].scales, stretches[0].robot.n
    is_guess = settings.trust.get('friction', settings.tolerance) > settings.tolerance
    stated = np.isfinite(scales.coulomb) & np.isfinite(scales.viscous)
    joints = [i for i in range(n) if is_guess or not stated[i]]
    if not joints:
        return list(stretches)
    untold = [(0.0, 0.0)] * n
    for i in joints:
        rows = []
        for s in stretches:
            seen = [s.sign[:, i], s.v[:, i], np.ones(len(s.q)), s.unexplained[:, i]]
            rows.append(s.band.apply(np.column_stack(seen)))
        X = np.concatenate(rows)
        (coulomb, viscous, _), *_ = np.linalg.lstsq(X[:, :-1], X[:, -1], rcond=None)
        untold[i] = (float(coulomb), float(viscous))
    return [replace(s, untold=tuple(untold), cache={}) for s in stretches]
