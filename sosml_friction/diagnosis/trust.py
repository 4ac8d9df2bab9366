# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How far each group of nominal parameters is trusted."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.regression.whitened import WhitenedRegression

#: Groups of nominal parameters. The torque constant is no column of the refit: a scale of effort
#: is a candidate, tolerated within its share, and a column beside free curves.
TORQUE_CONSTANT = 'torque_constant'
GROUPS = ('masses', 'armature', 'friction', 'terms', TORQUE_CONSTANT)
#: A bias is the sensor's and not friction: who guesses a friction says nothing of it.
_FRICTION = ('coulomb', 'viscous')


def parse_trust(entries: Iterable[str]) -> dict[str, float]:
    """
    Read entries ``GROUP=SHARE``.

    :raises ConfigurationError: if one is none, or :func:`check_trust` refuses it.
    """
    trust = {}
    for entry in entries:
        group, _, share = entry.partition('=')
        try:
            trust[group] = float(share)
        except ValueError:
            raise ConfigurationError(
                f'{entry!r} says no trust: write GROUP=SHARE, such as friction=inf'
            ) from None
    check_trust(trust)
    return trust


def check_trust(trust: Mapping[str, float]) -> None:
    """
    Refuse groups that there are not, and shares that are none.

    :raises ConfigurationError: if there is one.
    """
    for name, share in trust.items():
        if name not in GROUPS:
            raise ConfigurationError(f'{name!r} cannot be trusted: use {", ".join(GROUPS)}')
        if not share >= 0.0:
            raise ConfigurationError(
                f'the trust in {name} is {share:g}: give a share, such as 0.5, or inf'
            )


def trusting(laboratory: WhitenedRegression) -> WhitenedRegression:
    """
    Return the regression whose nominal parameters may be off by what their group is trusted to.

    A group that is not in ``settings.trust`` keeps the tolerance; an infinite share is no bound.
    """
    trust, tolerance = laboratory.settings.trust, laboratory.settings.tolerance
    nominal = laboratory.nominal
    stated = [(each.known.term, each.known.names) for each in nominal.stated]
    groups = {name: own.trusted_as for own, names in stated for name in names}
    share = [trust.get(groups.get(name) or _group(name), tolerance) for name in nominal.names]
    factor = np.array(share) / tolerance
    # What the model does not know has no tolerance, and one of nothing stays.
    changed = (factor != 1.0) & np.isfinite(nominal.bound) & (nominal.bound > 0.0)
    # The bound of a rotor that is fitted freely is none of the tolerance.
    free = [f'{joint} armature' for joint in laboratory.settings.free_inertia]
    changed &= ~np.isin(nominal.names, free)
    if not changed.any():
        return laboratory
    bound, prior = (
        np.where(changed, x * np.where(changed, factor, 1.0), x)
        for x in (nominal.bound, nominal.prior)
    )
    nominal = replace(nominal, bound=bound, prior=prior)
    rows = replace(laboratory.rows, nominal=nominal)
    system = replace(laboratory.system, bound=bound, prior=prior)
    return replace(laboratory, rows=rows, system=system)


def _group(name: str) -> str:
    """Return the group of a nominal parameter, '' for what is in none."""
    # A joint's name may have blanks, and so may the words of a body's parameter.
    what = name.rsplit(' ', 1)[-1]
    if what in _FRICTION:
        return 'friction'
    if what == 'armature':
        return 'armature'
    return 'masses' if ' body ' in name else ''


def scale_tolerance(laboratory: WhitenedRegression) -> float:
    """Return by how much a torque constant may be off and be no cause."""
    settings = laboratory.settings
    return settings.trust.get(TORQUE_CONSTANT, settings.tolerance)
