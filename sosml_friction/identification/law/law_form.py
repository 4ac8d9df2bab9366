# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which friction law is fitted."""

from dataclasses import dataclass

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.laws import TERM_LISTS, law_of
from sosml_friction.model.terms.kinds.fading_term import EXPONENTS

LAWS = ('auto', 'coulomb_viscous', 'stribeck')
#: The exponents that are published: exponential and Gaussian; the paper has those between, too.
ALPHAS = (1.0, 2.0)


@dataclass(frozen=True)
class LawForm:
    """
    Choose the form of the law.

    ``law``: ``coulomb_viscous`` is equation (9), ``stribeck`` equation (17), ``auto`` the second
    where the data show its extra term. ``symmetric``: False lets C, B and S differ with direction.
    ``alpha``: exponent of equation (10), None for 1 unless the data show another, which is then
    fitted; without speeds below v_s it is collinear with S and v_s, which are then what they may
    be with any exponent from 1 to 2. ``ridge``: the
    paper's light regularisation of v_s and bias, 0 for none. It draws the bias to zero with that
    share of its own information. A v_s that is a factor e away from the geometric mean of the
    slowest and the fastest speed costs that share of the residuals' squares. The intervals do not
    contain the systematic error that this causes.
    """

    law: str = 'auto'
    symmetric: bool = True
    alpha: float | None = None
    ridge: float = 0.0

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            known = ', '.join((*LAWS, *TERM_LISTS))
            raise ConfigurationError(f'law is {self.law!r}: use one of {known}')
        low, high = EXPONENTS
        if self.alpha is not None and not low <= self.alpha <= high:
            raise ConfigurationError(
                f'alpha is {self.alpha}: use 1, 2 or another from {low:g} to {high:g}, or leave '
                'it out: it is then found'
            )
        if not 0.0 <= self.ridge < 1.0:
            raise ConfigurationError(f'ridge is {self.ridge}: give a share from 0 to below 1')

    @property
    def usual(self) -> float:
        """Return the exponent that is taken where the data show no other."""
        return ALPHAS[0] if self.alpha is None else self.alpha

    def identifier(self, alpha: float | None) -> str:
        """Return the law's name in a model file; ``alpha`` of its Stribeck term, None without."""
        knee = alpha is not None
        terms = ['coulomb', 'viscous', *(['stribeck'] if knee else []), 'bias']
        if not self.symmetric:
            terms += ['viscous_asymmetry', *(['stribeck_asymmetry'] if knee else [])]
        return law_of(terms, {} if alpha is None else {'exponent': alpha}).identifier
