# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Write ``docs/terms.md`` from what the terms say of themselves.

``python -m validation.terms_table > docs/terms.md``
"""

import inspect
from collections.abc import Sequence

from sosml_friction.model.laws import FRICTION_LAWS, TERM_LISTS
from sosml_friction.model.terms.kinds.term import TERMS, Term

_HEAD = """\
# Terms

Written by `python -m validation.terms_table > docs/terms.md`; a test compares the two.

A model is a rigid body and a list of terms. A term adds to the effort that the actuator reports,
linear in its amplitudes. `sosml fit BAG --terms NAME,NAME` fits any of them; `sosml diagnose`
looks for those with a yes in the last column, and reports `coulomb` and `viscous` as a `change`;
the list `terms` of `model.yaml` holds them.

q is position, s the sign of motion (-1 to 1), tau the torque of the actuator, tau_load what the
gear passes on: M q'' + C q' + g of the body, without the rotor, which is before the gear. Units
are of a revolute joint; a prismatic one has N for Nm, m for rad and kg for kg m2. Parameters after
"inner:" are those that the effort is not linear in. The kind is the class in
`sosml_friction/model/terms/kinds/` that makes columns and simulation of the equation.
"""
_COLUMNS = ('term', 'equation', 'parameters', 'acts in', 'kind', 'axis', 'looked for')
_LISTS = """\
## Lists with a name

`--terms` takes all of these names; one that is a term's, `stribeck`, is the term. `--law` takes m1
to m6, the same as with `--terms`, and `coulomb_viscous` and `stribeck`: these are functions of
velocity, fitted by the weak form and to observers, with `--alpha 2` the Gaussian, with an exponent
that was found under the names of its terms, with `--asymmetric` by direction.
[identification.md](identification.md) has both ways.
"""


def terms_document() -> str:
    """Return the page: a table of all terms, and one of the lists that have a name."""
    rows = [_row(name, kind) for name, kind in TERMS.classes.items()]
    lists = [
        (f'`{law.identifier}`', _code(law.terms), ', '.join(f'{k} {v:g}' for k, v in fixed))
        for law in FRICTION_LAWS.values()
        for fixed in [law.fixed.items()]
    ]
    lists += [(f'`{name}`', _code(terms), '') for name, terms in TERM_LISTS.items()]
    names = ('name', 'terms', 'fixed')
    return '\n'.join([_HEAD, *_table(_COLUMNS, rows), '', _LISTS, *_table(names, lists)]) + '\n'


def _row(name: str, kind: type[Term]) -> tuple[str, ...]:
    where = 'all joints' if kind.of_robot else 'a joint'
    if kind.counterpart is not None:
        where = 'a joint, or all (`*`)'
    return (
        f'`{name}`',
        (inspect.getdoc(kind) or '').splitlines()[0].replace('``', '`'),
        _parameters(kind),
        where,
        f'`{_kind(kind)}`',
        kind.axis,
        'yes' if kind.searched else '',
    )


def _parameters(kind: type[Term]) -> str:
    amplitudes, inner = (
        ', '.join(f'`{name}` [{kind.unit(name, "Nm")}]' for name in names)
        for names in (kind.amplitudes, kind.inner)
    )
    return f'{amplitudes}; inner: {inner}' if inner else amplitudes


def _kind(kind: type[Term]) -> str:
    """Return the name of the base class that makes the columns of a term."""
    bases = (base for base in kind.__mro__ if 'identifier' not in vars(base))
    return next(base.__name__ for base in bases if 'columns' in vars(base))


def _code(names: tuple[str, ...]) -> str:
    return ', '.join(f'`{name}`' for name in names)


def _table(names: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    lines = [names, ('---',) * len(names), *rows]
    return ['| ' + ' | '.join(cell.replace('|', '\\|') for cell in line) + ' |' for line in lines]


if __name__ == '__main__':
    print(terms_document(), end='')
