# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The law as a curve, and its confidence band."""

import dataclasses
import math

import numpy as np
import pytest
from fitted_law import fit_law
from scipy.stats import binom
from scipy.stats import t as t_distribution

from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.model.parameter import NOT_IDENTIFIABLE


def made(seed, law=lambda v: np.sign(v) * 0.8 + 0.4 * v + 0.05, form=None):
    rng = np.random.default_rng(seed)
    v = np.repeat([-0.7, -0.4, -0.2, -0.05, 0.05, 0.2, 0.4, 0.7], 4)
    return fit_law(v, law(v) + rng.normal(0.0, 0.02, len(v)), np.arange(len(v)), 'Nm', form=form)


#: The form that leaves no other law open.
ASYMMETRIC = LawForm('coulomb_viscous', symmetric=False)


def test_the_band_of_a_linear_law_is_that_of_its_covariance():
    fit = made(0, form=ASYMMETRIC)
    v = np.array([-0.5, -0.1, 0.3])
    columns = {'coulomb': np.sign(v), 'viscous': v, 'bias': np.ones(3)}
    columns['viscous_asymmetry'] = np.abs(v)
    X = np.column_stack([columns[name] for name in fit.covariance_of])
    freedom = fit.clusters - len(fit.covariance_of)
    expected = t_distribution.ppf(0.975, freedom) * np.sqrt(np.diag(X @ fit.covariance @ X.T))
    assert np.allclose(band(fit, v), expected, rtol=1e-6)


def test_the_band_covers_the_true_law_about_as_often_as_it_says():
    """At least as often, of 100 fits, as a coverage of 95 % gives but once in a million."""
    v = np.array([0.3])
    fits = [made(seed, form=LawForm('coulomb_viscous')) for seed in range(100)]
    inside = sum(
        abs(fitted_law(fit).torque(v)[0] - (0.8 + 0.12 + 0.05)) <= band(fit, v)[0] for fit in fits
    )
    assert binom.ppf(1e-6, 100, 0.95) <= inside < 100


def test_a_law_whose_parameters_are_open_is_drawn_as_it_fits():
    fit = made(1, lambda v: np.sign(v) * (0.8 + 0.5 * np.exp(-np.abs(v) / 0.012)) + 0.4 * v)
    stribeck = fit.parameters['stribeck']
    assert NOT_IDENTIFIABLE in stribeck.flags
    assert math.isnan(stribeck.value)
    v = np.array([0.2, 0.7])
    assert np.allclose(fitted_law(fit).torque(v), 0.8 + 0.4 * v, atol=0.03)


def test_a_law_without_numbers_or_covariance_has_no_curve_or_band():
    fit = made(2)
    assert band(dataclasses.replace(fit, covariance=None), np.ones(1)) is None
    lost = dataclasses.replace(fit, drawn={}, parameters={})
    assert fitted_law(lost) is None
    assert band(lost, np.ones(1)) is None


@pytest.mark.parametrize('name', ['coulomb', 'bias'])
def test_the_band_is_that_of_the_parameter_where_the_law_is_that_parameter(name):
    fit = made(3, form=ASYMMETRIC)
    k = fit.covariance_of.index(name)
    alone = dataclasses.replace(
        fit, covariance=fit.covariance[k : k + 1, k : k + 1], covariance_of=(name,)
    )
    p = fit.parameters[name]
    quantile = t_distribution.ppf(0.975, fit.clusters - 1)
    assert np.allclose(band(alone, np.array([0.2])), quantile * p.std_error, rtol=1e-6)
