# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an analysis says, in sentences."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.joint_view import JointView
from sosml_friction.report.labels import SYMBOLS, observer_label
from sosml_friction.report.number_text import allowed_range, format_interval, format_number


def joint_sentence(view: JointView) -> str:
    """Return the result of one joint in a sentence with its numbers."""
    if view.preferred is None:
        return f'{view.name}: its friction is not available, because {view.unavailable}.'
    fit = view.fits[view.preferred].fit
    parameters = fit.parameters
    parts = [
        f'{_with_error(parameters["coulomb"])} of Coulomb friction',
        f'{_with_error(parameters["viscous"])} of viscous friction',
    ]
    if fit.law == 'stribeck':
        parts.append(_stribeck(parameters['stribeck'], parameters['stribeck_velocity']))
    text = f'{view.name}: {", ".join(parts[:-1])} and {parts[-1]}'
    bias = parameters['bias']
    if not _covers(bias, 0.0):
        text += f', on a bias of {_with_error(bias)} that does not change with direction'
    if fit.law != 'stribeck':
        text += '; extra friction near standstill (Stribeck) is not identifiable from this motion'
    return f'{text} ({observer_label(view.preferred)}, ± is half of the 95 % interval).'


def notes(views: Sequence[JointView]) -> list[str]:
    """
    Return what a reader should know before using the numbers.

    Methods or observers whose 95 % intervals exclude each other, a truth outside of them, and
    joints that only some observers could be fitted for.
    """
    subjects: dict[str, dict[str, list[str]]] = {}
    for view in views:
        for observer, text in _remarks(view):
            labels = subjects.setdefault(text, {}).setdefault(view.name, [])
            if observer:
                labels.append(observer_label(observer))
    result = []
    for text, joints in subjects.items():
        who = [f'{name} ({", ".join(them)})' if them else name for name, them in joints.items()]
        result.append(f'{", ".join(who)}: {text}')
    return result


def methods_disagree(view: JointView) -> bool:
    """Tell whether segments and samples exclude each other in a parameter of an observer."""
    return any(_apart(fit, view.alternatives.get(o)) for o, fit in view.fits.items())


def _remarks(view: JointView) -> Iterator[tuple[str, str]]:
    """Yield (observer or '', sentence)."""
    for observer, fit in view.fits.items():
        other = view.alternatives.get(observer)
        apart = _apart(fit, other)
        if apart and other is not None:
            yield (
                observer,
                f'{fit.method} (used here) and {other.method} differ by more than their 95 % '
                f'intervals in {", ".join(apart)}, so one of them is biased: compare both with '
                'the S-curve.',
            )
    for observer, fit in view.fits.items():
        known = view.truth.parameters if view.truth else {}
        missed = [
            name
            for name, truth in known.items()
            if name in SYMBOLS and _misses(fit.fit.parameters[name], truth.value)
        ]
        if missed:
            yield observer, f'the truth is outside the 95 % interval of {", ".join(missed)}.'
    for first, second in itertools.pairwise(view.fits.values()):
        apart = _apart(first, second)
        if apart:
            yield (
                '',
                f'{observer_label(first.observer)} and {observer_label(second.observer)} differ '
                f'by more than their 95 % intervals in {", ".join(apart)}.',
            )
    if view.fits and view.unavailable:
        yield '', f'{view.unavailable}.'


def _apart(first: JointFit, second: JointFit | None) -> list[str]:
    """Return the parameters in which two fits exclude each other."""
    if second is None:
        return []
    one, two = first.fit.parameters, second.fit.parameters
    return [name for name in SYMBOLS if _disjoint(one[name], two[name])]


def _with_error(parameter: Parameter) -> str:
    half = parameter.std_error
    if parameter.interval is not None:
        half = 0.5 * (parameter.interval[1] - parameter.interval[0])
    number = format_number(parameter.value, half)
    if not math.isfinite(half):
        return f'{number} {parameter.unit} (uncertainty unknown)'
    return f'{number} ± {format_number(half, half)} {parameter.unit}'


def _stribeck(stribeck: Parameter, velocity: Parameter) -> str:
    if NOT_IDENTIFIABLE not in stribeck.flags:
        return f'{_with_error(stribeck)} more near standstill, fading over {_with_error(velocity)}'
    allowed = allowed_range('stribeck', stribeck)
    size = '' if allowed is None else f' ({format_interval(*allowed)} {stribeck.unit})'
    return f'more near standstill, whose size this motion leaves open{size}'


def _interval(parameter: Parameter) -> tuple[float, float] | None:
    if NOT_IDENTIFIABLE in parameter.flags or parameter.interval is None:
        return None
    return parameter.interval if all(map(math.isfinite, parameter.interval)) else None


def _covers(parameter: Parameter, value: float) -> bool:
    interval = _interval(parameter)
    return interval is not None and interval[0] <= value <= interval[1]


def _misses(parameter: Parameter, value: float) -> bool:
    return _interval(parameter) is not None and not _covers(parameter, value)


def _disjoint(first: Parameter, second: Parameter) -> bool:
    a, b = _interval(first), _interval(second)
    return a is not None and b is not None and (a[0] > b[1] or b[0] > a[1])


def sampling_text(log: JointLog) -> str:
    """Return how much was recorded, how fast, and what share of the samples is missing."""
    count, span = len(log), float(log.time[-1])
    if not span > 0.0:
        return f'{count} samples'
    text = f'{count} samples over {span:.1f} s, {(count - 1) / span:.4g} Hz'
    missing = 1.0 - (count - 1) * float(np.median(np.diff(log.time))) / span
    if missing > 0.02:
        text += f'; {100.0 * missing:.0f} % of them are missing: the computer was too busy'
    return text
