# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The profile of the Stribeck term as it is drawn."""

import dataclasses

import numpy as np
import pytest

from sosml_friction.report.figures.fit.profile import Profile
from sosml_friction.report.fit.joint_view import joint_views


@pytest.fixture(scope='module')
def view(analysis, truth):
    return joint_views(analysis, truth)[0]


def test_the_best_fit_is_among_the_points_and_has_no_excess(view):
    fit = view.fits['sosml'].fit
    v_s, excess, size, half = fit.profile.with_best(fit.drawn)
    assert (np.diff(v_s) > 0.0).all()
    assert len(v_s) == len(excess) == len(size) == len(half) >= len(fit.profile.excess)
    k = int(np.argmin(excess))
    assert v_s[k] == pytest.approx(fit.drawn['stribeck_velocity'], rel=1e-6)
    assert size[k] == pytest.approx(fit.drawn['stribeck'], rel=1e-6)
    assert excess[k] == pytest.approx(0.0, abs=1e-6)


def test_below_the_limit_is_the_95_percent_interval_of_the_profile(view):
    """That of the parameter holds it: another knee may be true as well."""
    fit = view.fits['sosml'].fit
    v_s, excess, _, _ = fit.profile.with_best(fit.drawn)
    low, high = fit.parameters['stribeck_velocity'].interval
    within = v_s[excess <= 1.0]
    assert low <= within.min()
    assert within.max() <= high
    beyond = v_s[excess > 1.0]
    low, high = fit.profile.velocity_interval()
    assert not ((beyond > low) & (beyond < high)).any()


def test_every_observer_with_a_profile_is_drawn_and_none_without(view):
    labels = [text.get_text() for text in Profile().draw(view).legends[0].get_texts()]
    assert {'FO', 'SOSML', 'truth'} <= set(labels)
    fits = {
        observer: dataclasses.replace(fit, fit=dataclasses.replace(fit.fit, profile=None))
        for observer, fit in view.fits.items()
    }
    assert not Profile().applies(dataclasses.replace(view, fits=fits))
