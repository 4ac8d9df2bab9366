# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that the model does not know, in the effort that columns are made from."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.nominal import Nominal, friction_columns, make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, silent_throughout

#: Added to the normal equations of columns of norm 1, of which some are collinear.
_RIDGE = 1e-8


def with_refitted_friction(
    signals: Sequence[Signals], settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return stretches that know the friction that a fit of the nominal alone has, where it is free.

    What is wrong with the report of an effort is a function of all of it: of a joint whose
    friction is not stated, the bodies alone are the smaller part. How large friction is is fitted
    anew beside every cause.
    """
    first = signals[0]
    silent = silent_throughout(signals)
    nominal = make_nominal(first, settings.tolerance, silent)
    trusted = settings.trust.get('friction', settings.tolerance) <= settings.tolerance
    free = [
        name
        for i, joint in enumerate(first.robot.names)
        if i not in silent
        for name in (f'{joint} {own}' for own in friction_columns(first, i))
        if np.isinf(nominal.bound[nominal.names.index(name)])
        or (not trusted and not name.endswith(' bias'))
    ]
    if not free:
        return list(signals)
    x = _fitted(signals, nominal, [nominal.names.index(name) for name in free])
    found = {name: float(x[nominal.names.index(name)]) for name in free}
    return [with_friction(s, found) for s in signals]


def with_friction(signals: Signals, found: Mapping[str, float]) -> Signals:
    """Return a stretch with friction that was found, by the names of nominal parameters."""
    more = np.zeros_like(signals.q)
    for i, joint in enumerate(signals.robot.names):
        for name, column in friction_columns(signals, i).items():
            more[:, i] += found.get(f'{joint} {name}', 0.0) * column
    return replace(signals, found_friction=found, refitted=more, cache={})


def _fitted(signals: Sequence[Signals], nominal: Nominal, free: Sequence[int]) -> FloatArray:
    """Return the deviations of the nominal (p,), of which some are free, beside no cause."""
    X = np.concatenate([s.in_band(nominal.columns(s)) for s in signals])
    y = np.concatenate([s.in_band(s.unexplained) for s in signals])
    prior = nominal.prior.copy()
    prior[free] = np.inf
    G, r = np.diag(1.0 / prior**2), np.zeros(len(prior))
    for i in range(y.shape[1]):
        own, *_ = np.linalg.lstsq(X[:, i], y[:, i], rcond=None)
        noise = float(np.mean((y[:, i] - X[:, i] @ own) ** 2))
        if noise > 0.0:
            G, r = G + X[:, i].T @ X[:, i] / noise, r + X[:, i].T @ y[:, i] / noise
    size = np.sqrt(np.where(np.diag(G) > 0.0, np.diag(G), 1.0))
    G = G / size / size[:, None] + _RIDGE * np.eye(len(size))
    return np.asarray(np.linalg.solve(G, r / size) / size)
