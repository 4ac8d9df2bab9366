# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An observer that is no part of the package: one class, and nothing else says that it exists."""

from __future__ import annotations

import sys

import numpy as np

from sosml_friction.observers.observer import Observer
from sosml_friction.observers.search_space import SearchRange, SearchSpace


def define_observer() -> type[Observer]:
    """Define it: a low-pass of the residual by backward Euler."""

    class Leaky(Observer):
        identifier = 'leaky'
        label = 'Leaky'
        place = 99.0
        gain_units = {'time_constant': 's'}  # noqa: RUF012
        positive_gains = ('time_constant',)
        causal = True
        study = {  # noqa: RUF012
            'leaky': SearchSpace(
                {'time_constant': SearchRange(1e-4, 1.0)}, ('time_constant', -1.0)
            ),
            'leaky_slow': SearchSpace(
                {'time_constant': SearchRange(0.1, 1.0)},
                ('time_constant', -1.0),
                label='Leaky, slow',
                remark='a tenth of a second at least',
            ),
        }

        @classmethod
        def recipe(cls, conditions):
            return {'time_constant': 1.0 / conditions.first_order_cutoff}

        @classmethod
        def bandwidth_recipe(cls, w, momentum_noise):
            return {'time_constant': 1.0 / w}

        def start(self, p):
            self._p, self._r = p.copy(), np.zeros(self.n)

        def run(self, samples):
            estimate = np.empty_like(samples.p)
            for k, h in enumerate(samples.h):
                share = h / (h + self.gains['time_constant'])
                residual = (samples.p[k] - self._p) / h - samples.forcing[k]
                self._r = self._r + share * (residual - self._r)
                self._p = samples.p[k]
                estimate[k] = np.where(np.isfinite(self._r), self._r, np.nan)
                self._r = np.where(np.isfinite(self._r), self._r, 0.0)
            return estimate

        def lag_filter(self, h, joint):
            share = h / (h + self.gains['time_constant'][joint])
            return np.array([share]), np.array([1.0, share - 1.0])

    return Leaky


if __name__ == '__main__':
    define_observer()
    # Only now: the class is there before the node looks for observers.
    from sosml_friction.nodes.observer_node import main

    sys.exit(main())
