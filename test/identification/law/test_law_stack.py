# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several recordings as one regression: nothing that a fit was asked for is lost on the way."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import RowNoise, joined, stack_rows

FORM = LawForm(law='coulomb_viscous')


def recording(bias, inertia=None):
    """Return exact rows of C 0.8, B 0.35, and inertia times an acceleration of its own."""
    t = np.arange(400) * 0.05
    v = np.where(t < 10.0, 0.1 + 0.04 * t, -0.1 - 0.04 * (t - 10.0))
    acceleration = np.cos(1.7 * t)[:, None]
    y = 0.8 * np.sign(v) + 0.35 * v + bias
    if inertia is not None:
        y = y + inertia * acceleration[:, 0]
    return LawRows(
        v,
        y,
        (t / 0.5).astype(np.int64),
        np.ones(len(v), dtype=bool),
        v,
        lambda column: column,
        find_smoothing=True,
        form=FORM,
        extra=None if inertia is None else acceleration,
    )


@pytest.mark.parametrize('mean', [False, True])
def test_inertia_form_and_the_search_for_v0_are_passed_on(mean):
    parts = [recording(0.1, 0.2), recording(-0.1, 0.2)]
    if mean:
        parts = [joined(rows, RowNoise(1.0, np.sqrt(5.0))) for rows in parts]
        assert len(parts[0].y) < 100
    rows = stack_rows(parts, [1.0, 2.0]).own(('bias',)).rows
    assert rows.find_smoothing
    assert rows.form is FORM
    fit = rows.fit('Nm')
    assert fit.law == 'coulomb_viscous'
    assert fit.extra[0].value == pytest.approx(0.2, rel=1e-6)
    assert fit.parameters['coulomb'].value == pytest.approx(0.8, rel=1e-6)
    assert fit.parameters['viscous'].value == pytest.approx(0.35, rel=1e-6)


def test_recordings_with_and_without_inertia_are_not_joined():
    with pytest.raises(DataError, match='fit all of them with it, or none'):
        stack_rows([recording(0.0, 0.2), recording(0.0)], [1.0, 1.0])
