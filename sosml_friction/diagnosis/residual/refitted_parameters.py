# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The nominal parameters of a diagnosis, before and after the refit."""

from typing import NamedTuple

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.regression.evidence import AT_BOUND


class RefittedParameter(NamedTuple):
    """
    Hold one parameter, in SI units of its joint; ``old`` is NaN where it is a combination.

    ``bound`` of the change is infinite for what is not in the model.
    """

    name: str
    old: float
    change: float
    std_error: float
    bound: float

    @property
    def at_bound(self) -> bool:
        """Tell whether the refit went as far as it may."""
        return bool(np.isfinite(self.bound)) and abs(self.change) >= AT_BOUND * self.bound


def refitted_parameters(diagnosis: Diagnosis) -> list[RefittedParameter]:
    """Return what the refit changed, none where nothing was refitted."""
    laboratory = diagnosis.laboratory
    if laboratory is None or not diagnosis.refit:
        return []
    scales, names = laboratory.signals[0].scales, diagnosis.names
    result = []
    stated = {
        name: float(value)
        for each in laboratory.nominal.stated
        for name, value in zip(each.known.names, each.known.amplitude, strict=True)
    }
    for name, bound in zip(laboratory.nominal.names, laboratory.nominal.bound, strict=True):
        joint, _, what = name.rpartition(' ')
        old = stated.get(name, np.nan)
        if joint in names and hasattr(scales, what):
            old = float(getattr(scales, what)[names.index(joint)])
        if joint in names and what == 'armature':
            old = float(laboratory.robot.armature[names.index(joint)])
        error = diagnosis.refit_errors.get(name, np.nan)
        result.append(RefittedParameter(name, old, diagnosis.refit[name], error, float(bound)))
    return result
