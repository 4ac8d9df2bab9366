# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The best constants that a target has in the place of terms it cannot hold, and their error."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, nnls

from sosml_friction.arrays import FloatArray
from sosml_friction.export.common.motion import KnownMotion
from sosml_friction.export.common.tracking import follow
from sosml_friction.model.known_terms import KnownTerm, known_terms, read_term
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.term import TERMS

#: Most simulations in the search of the best constants.
_ROUNDS = 80
#: Weight of the model's own C and B against one sample, as a share: where speeds do not tell one
#: from the other they stay, and where they do this moves them by a thousandth or so.
_OWN = 1e-3
#: What every target has a field for.
CONSTANTS = ('coulomb', 'viscous')


@dataclass(frozen=True)
class HeldJoint:
    """
    Hold what a target is given for a joint.

    ``constants``: ``coulomb`` and ``viscous``. ``error``: root mean square of the effort that is
    missing all the same, and ``friction`` that of all friction [Nm or N], None where the motion
    does not tell them. ``standing``: friction from standstill, the model's.
    """

    constants: Mapping[str, float]
    standing: float
    unit: str
    error: float | None = None
    friction: float | None = None
    lost: tuple[str, ...] = ()

    def sentence(self, joint: str, on: str) -> str:
        """Return what the loss costs, '' where nothing is lost."""
        if not self.lost:
            return ''
        terms = ', '.join(self.lost)
        if self.error is None or not self.friction:
            return (
                f'{joint}: what {terms} would cost is not known, as it takes the motion: give '
                'a recording'
            )
        return (
            f'{joint}: without {terms} the effort is wrong by {self.error:.3g} {self.unit} rms, '
            f'{100.0 * self.error / self.friction:.2g} % of its friction, on {on}, with constants '
            'refitted there'
        )


def joint_terms(model: RobotModelFile) -> dict[str, list[KnownTerm]]:
    """Return the terms of each joint that are an effort of its own, those of its law first."""
    found: dict[str, list[KnownTerm]] = {name: [] for name in model.joints}
    own = [known for entry in model.law_terms() for known in read_term(entry, model)]
    for known in own + known_terms(model):
        if isinstance(known.term, EffortTerm):
            found[model.joint_names[known.joint]].append(known)
    return found


def hold(
    model: RobotModelFile, motion: KnownMotion, holds: Callable[[str, str], bool]
) -> dict[str, HeldJoint]:
    """
    Return what a target is given for each joint.

    Where a recording tells the motion, each joint is simulated along it, once with all of its
    friction and once with what the target holds; C and B are those whose effort is nearest, and
    the error is what is left. Where velocities are all that is known, it is that of the law.

    :param holds: tells whether the target holds a term, by joint and identifier.
    """
    result = {}
    for i, (name, terms) in enumerate(joint_terms(model).items()):
        unit = 'Nm' if model.joints[name].armature.unit == 'kg m2' else 'N'
        own = dict.fromkeys(CONSTANTS, 0.0)
        for known in terms:
            if known.term.identifier in own:
                own[known.term.identifier] += float(known.amplitude[0])
        own = {key: max(value, 0.0) for key, value in own.items()}
        standing = sum(
            float(t.amplitude[0]) for t in terms if t.term.identifier in ('coulomb', 'stribeck')
        )
        lost = [t for t in terms if not holds(name, t.term.identifier) and t.amplitude.any()]
        # The same of each, as of harmonics.
        names = tuple(dict.fromkeys(t.term.identifier for t in lost))
        result[name] = HeldJoint(own, max(standing, own['coulomb']), unit, lost=names)
        if not lost or not motion.knows(name):
            continue
        units = [KnownTerm(TERMS[key](), i, {}, np.ones(1)) for key in CONSTANTS]
        gone = {id(t) for t in lost}
        kept = [t for t in terms if id(t) not in gone and t.term.identifier not in own]
        found = (_along if motion.stretches else _steady)(motion, i, name, terms, kept, units, own)
        if found is not None:
            constants, error, friction = found
            values = dict(zip(CONSTANTS, map(float, constants), strict=True))
            most = max(standing, values['coulomb'])
            result[name] = HeldJoint(values, most, unit, error, friction, names)
    return result


_Found = tuple[FloatArray, float, float] | None


def _steady(
    motion: KnownMotion, i: int, name: str, terms: list[KnownTerm], kept: list[KnownTerm],
    units: list[KnownTerm], own: Mapping[str, float],
) -> _Found:  # fmt: skip
    """Return constants, error and friction at velocities alone."""
    columns = motion.steady(name, [*units, *terms, *kept])
    if columns is None:
        return None
    whole = columns[:, 2 : 2 + len(terms)].sum(axis=1)
    held = columns[:, 2 + len(terms) :].sum(axis=1)
    # Each unknown in units of the effort that it makes.
    rows = np.sqrt(_OWN) * np.diag(np.linalg.norm(columns[:, :2], axis=0))
    start = np.array([own[key] for key in CONSTANTS])
    constants, _ = nnls(
        np.vstack([columns[:, :2], rows]), np.concatenate([whole - held, rows @ start])
    )
    left = whole - held - columns[:, :2] @ constants
    return constants, float(np.sqrt(np.mean(left**2))), float(np.sqrt(np.mean(whole**2)))


def _along(
    motion: KnownMotion, i: int, name: str, terms: list[KnownTerm], kept: list[KnownTerm],
    units: list[KnownTerm], own: Mapping[str, float],
) -> _Found:  # fmt: skip
    """Return constants, error and friction along recorded stretches."""
    paths = motion.paths(i, name)
    whole = [follow(p, law) for p, law in zip(paths, motion.laws(i, terms), strict=True)]
    wanted = np.concatenate([effort for effort, _ in whole])
    rest = motion.laws(i, kept)
    unit = [motion.laws(i, [one]) for one in units]

    def error(constants: FloatArray) -> float:
        found = []
        for path, base, C, B in zip(paths, rest, *unit, strict=True):
            level = base.level_v + abs(constants[0]) * C.level_v
            both = base.both_v + abs(constants[1]) * B.both_v
            found.append(follow(path, base._replace(level_v=level, both_v=both))[0])
        return float(np.sqrt(np.mean((np.concatenate(found) - wanted) ** 2)))

    size = np.concatenate([friction for _, friction in whole])
    start = np.array(list(own.values()))
    scale = float(np.sqrt(np.mean(size**2)))
    speed = np.concatenate([p.v for p in paths])
    steps = 0.1 * scale * np.diag([1.0, 1.0 / max(float(np.sqrt(np.mean(speed**2))), 1e-12)])
    simplex = np.vstack([start, start + steps])
    best = minimize(
        error, start, method='Nelder-Mead',
        options={'initial_simplex': simplex, 'maxfev': _ROUNDS, 'xatol': 1e-4 * scale,
                 'fatol': 1e-4 * scale},
    )  # fmt: skip
    return np.abs(best.x), float(best.fun), scale
