# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort less gravity, low-passed: what friction is while nothing accelerates. A baseline."""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.first_order import CUTOFF, FirstOrder
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchSpace


class QuasiStatic(FirstOrder):
    """
    Take the forcing for friction and filter it by w / (s + w), discretised exactly.

    With u = tau + C^T q' - g it is tau_e = -u as long as p' = 0: no velocity is differentiated, so
    there is next to no noise, and whatever the joint accelerates, M q'', is taken for friction.
    It is FO with a momentum of zero. The baseline that every observer has to beat on slow motion;
    of no use in fast.

    The filter is there for noise of the effort. Gain: ``cutoff`` = w [1/s] > 0.
    """

    identifier = 'quasi_static'
    label = 'Quasi-static'
    place = 1.0
    slow_motion_only = True
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'quasi_static': SearchSpace({'cutoff': CUTOFF}, ('cutoff', 1.0))
    }

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return w = 100 1/s: there is no noise of positions to balance."""
        return {'cutoff': 100.0}

    def start(self, p: FloatArray) -> None:
        """Begin afresh with the estimate zero; the momentum is not used."""
        super().start(np.zeros(self.n))

    def run(self, samples: MomentumSamples) -> FloatArray:
        return super().run(replace(samples, p=np.zeros(samples.p.shape)))
