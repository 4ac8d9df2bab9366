# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis in words, for a person."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.leftover import (
    AT_ONCE,
    BURSTS,
    FRICTION_BY,
    REST,
    SLOW,
    TONE,
    TORQUE_BY,
    Leftover,
)
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.verdict import contradicted_by_simulation, not_shown
from sosml_friction.diagnosis.extended_model.carry_over import NOT_RECURRING
from sosml_friction.diagnosis.extended_model.gain import Gain
from sosml_friction.diagnosis.extended_model.uncertain import Uncertain
from sosml_friction.identification.number_text import plus_minus, words
from sosml_friction.identification.term_parameters import size_text
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Z_95, Parameter
from sosml_friction.model.terms.cogging import PERIODS
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, DATA_CAUSES, TERMS
from sosml_friction.regression.curves.axes import NEIGHBOURS, POSITION

#: Numbers of data checks that a sentence does without; those of a term are the term's to say.
_NOT_TOLD = ('step_s', 'jitter_s', 'lag_std_error_s')
#: Most numbers of a data check, or episodes, that a description has; of a term all but harmonics.
_MOST_NUMBERS = 3
#: What is said in the place of numbers of a cause whose size would be wrong beyond its error.
SIZE_UNKNOWN = 'present; its size is not known from these data'
#: Forms of what is left that are no curve.
_NO_CURVE = ('tone', 'ripple', 'bursts', SLOW)
#: The sentence in the place of the gain.
_NOT_MODELLED = (
    'The model is not extended: these data do not give numbers that would predict more.'
)


def _where(cause: Cause) -> str:
    return 'all joints' if cause.joint == ALL_JOINTS else cause.joint


def describe(cause: Cause, names: Sequence[str] = ()) -> str:
    """Return a cause in words, with its numbers; ``names``: of all joints."""
    where = _where(cause)
    numbers = []
    kind = TERMS.classes.get(cause.effect)
    if not cause.size_known:
        return f'{where}: {words(cause.effect)} ({SIZE_UNKNOWN})'
    if 'episodes' in cause.parameters:
        return f'{where}: {words(cause.effect)} ({_episodes(cause)})'
    unspoken = _NOT_TOLD if kind is None else kind.unspoken
    told = [
        (name, p)
        for name, p in cause.parameters.items()
        if name not in unspoken and not _unfelt(p)
    ]
    most = _MOST_NUMBERS if kind is None else len(kind.amplitudes) + len(kind.inner)
    for name, p in told[:most]:
        if p.unit == 'joint' and names:
            numbers.append(f'{words(name)} {names[int(p.value)]}')
            continue
        # The names of what data checks found end in their unit.
        name = name.removesuffix(f'_{p.unit}')
        unit = '' if p.unit == '1' else f' {p.unit}'
        more = _of_harmonics(cause, name)
        if name in cause.stated:
            unit += f' and not {cause.stated[name]:.4g}'
        numbers.append(f'{words(name)} {size_text(p)}{more}{unit}')
    reasons = {p.reason for _, p in told if NOT_IDENTIFIABLE in p.flags and p.experiment}
    why = ''.join(f'; known together only, as {reason}' for reason in sorted(reasons))
    off = ' as stated is off' if cause.stated else ''
    return f'{where}: {words(cause.effect)}{off} ({", ".join(numbers)}{why})'


def _unfelt(p: Parameter) -> bool:
    """Tell whether it is a size that nothing in the recordings feels: exactly 0, for no reason."""
    return p.value == 0.0 and math.isfinite(p.std_error)


def _episodes(cause: Cause) -> str:
    """Return how many contacts there were, the first of them, and of what size."""
    numbers = cause.parameters
    count = round(numbers['episodes'].value)
    told = []
    for k in range(1, count + 1):
        if k > _MOST_NUMBERS or f'start_{k}' not in numbers:
            told.append('...')
            break
        start, end = (numbers[f'{name}_{k}'].value for name in ('start', 'end'))
        told.append(f'{start:.2f} to {end:.2f} s')
    text = f'{count} episode{"" if count == 1 else "s"}: {", ".join(told)}'
    if 'level' in numbers:
        level, left_out = numbers['level'], numbers['share_left_out'].value
        text += f'; level {size_text(level)} {level.unit}, {100.0 * left_out:.0f} % left out'
    return text


def _of_harmonics(cause: Cause, name: str) -> str:
    """Return an inner parameter of a cause's further harmonics, after a comma each."""
    kind = TERMS.classes.get(cause.effect)
    if kind is None or name not in kind.inner:
        return ''
    others = (cause.parameters.get(f'{name}_{k}') for k in range(2, len(cause.parameters) + 1))
    return ''.join(f', {size_text(p)}' for p in others if p is not None)


def sentence_of(
    verdict: str,
    causes: Sequence[Cause],
    gain: Gain,
    selection: Selection,
    names: tuple[str, ...],
    units: tuple[str, ...],
    tolerated: Sequence[Cause] = (),
    unstated: Sequence[str] = (),
    untold: Sequence[str] = (),
    untried: Mapping[str, str] | None = None,
) -> str:
    """
    Return the verdict with its numbers, for a person.

    :param unstated: friction that the model does not state, in words with the fitted numbers.
    :param untold: joints whose inertia the effort contradicts.
    :param untried: by term that was not looked for, what recordings need for it.
    """
    end = f' Not stated in the model, and fitted: {"; ".join(unstated)}.' if unstated else ''
    end += (
        f' Off within the tolerance, and refitted: {_told(tolerated, names)}.' if tolerated else ''
    )
    if verdict == 'nothing_above_floor':
        return _nothing(selection, gain, names) + end
    modelled = any(cause.in_model for cause in (*causes, *tolerated))
    gains = f'On {gain.on}: {_gains(gain, names, units)}.' if modelled else _NOT_MODELLED
    if verdict == 'unknown_structure':
        # A fault of the data leaves no residual, and a contact is found beside what is left: they
        # are no part of what is missing.
        own = [cause for cause in causes if not cause.is_fault]
        contacts = [cause for cause in own if cause.effect in DATA_CAUSES]
        told = [cause for cause in own if cause.effect not in DATA_CAUSES]
        text = 'The model misses something that no cause of the catalogue explains'
        if contacts:
            text += f', beside {_told(contacts, names)}'
        if told:
            text += f'; in part it looks like {_told(told, names)}'
        where = _where_unknown(selection, names, units) or _refused(selection, names)
        if untold and not where:
            where = f'The effort of {", ".join(untold)} contradicts the inertia of the model. '
        where += _instead(selection, names) + _worse(selection, names)
        last = _unsaid(gain, names)
        for name, needs in (untried or {}).items():
            last += f' {words(name).capitalize()} is not looked for, which needs {needs}.'
        return (
            f'{text}. {where}{_not_shown(causes)}{gains}'
            f'{_contradicted((*causes, *tolerated))}{end}{last}'
        )
    if all(cause.effect in DATA_CAUSES or cause.is_fault for cause in causes):
        rest = _rest(selection, names, units).lstrip() or _nothing(selection, gain, names)
        return f'Named, of the data: {_told(causes, names)}. {rest}{end}'
    lead = 'Named' if verdict == 'named' else 'These data leave a choice'
    return (
        f'{lead}: {_told(causes, names)}. {gains}{_contradicted((*causes, *tolerated))}'
        f'{_outside(causes)}{_rest(selection, names, units)}{end}'
    )


def _not_shown(causes: Sequence[Cause]) -> str:
    """Return which terms may be nothing, a sentence each with a blank after it."""
    return ''.join(
        f'{_where(cause)}: {words(cause.effect)} may be nothing: {why}. '
        for cause in causes
        if (why := not_shown(cause))
    )


def _contradicted(causes: Sequence[Cause]) -> str:
    """Return what does not carry over to data left out, with a blank before each sentence."""
    return ''.join(f' {line}' for cause in causes for line in carry_over_lines(cause))


def carry_over_lines(cause: Cause) -> list[str]:
    """Return what contradicts a cause on data left out, as one sentence; none for no such."""
    gain = cause.gain
    if gain is None or gain.carries_over:
        return []
    worse = ', '.join(
        plus_minus(-removed.value, Z_95 * removed.std_error, unit)
        for removed, unit in zip(gain.removed, gain.units, strict=True)
    )
    if gain.size_recurs:
        how = (
            f'its amplitude recurs ({_number(gain.size)} of what was found), '
            f'its phase does not (off by {gain.phase:.0f} degrees: an incremental encoder '
            'that has another zero would do so)'
        )
    else:
        how = f'{_number(gain.recurs)} of what it predicts is there, and it helps from 0.5 on'
    where = '' if cause.in_model else '; the extended model is without it'
    name = words(cause.effect).capitalize()
    return [
        f'{name} ({cause.joint}) does not carry over: it made the effort error there larger by '
        f'{worse}; {how}{where}.'
    ]


def gain_line(cause: Cause) -> str:
    """Return what a cause removes by itself on data left out; '' where that is not known."""
    gain = cause.gain
    if gain is None:
        return ''
    parts = [
        f'{joint} {gain.without[i]:.3g} -> {gain.with_it[i]:.3g} {gain.units[i]} '
        f'({_number(gain.removed[i], gain.units[i])} removed)'
        for i, joint in enumerate(gain.joints)
    ]
    return f'{words(cause.effect)} ({cause.joint}): {", ".join(parts)}'


def _outside(causes: Sequence[Cause]) -> str:
    """Return which causes the extended model lacks, as a sentence with a blank before it."""
    if not any(cause.in_model for cause in causes):
        return ''
    left = [
        f'{words(cause.effect)} ({cause.joint})'
        for cause in causes
        if not cause.in_model and cause.effect not in DATA_CAUSES and not carry_over_lines(cause)
    ]
    return f' The extended model has no {", ".join(left)}.' if left else ''


def _told(causes: Sequence[Cause], names: Sequence[str]) -> str:
    """Return causes in words; one fault of the data in several joints is told once."""
    alike: dict[object, list[Cause]] = {}
    for k, cause in enumerate(causes):
        together = cause.is_fault and cause.joint != ALL_JOINTS
        alike.setdefault(cause.effect if together else k, []).append(cause)
    return '; '.join(
        _with_rivals(same[0], names) if len(same) == 1 else _in_joints(same)
        for same in alike.values()
    )


def _in_joints(same: Sequence[Cause]) -> str:
    """Return a fault of several joints in words, with the range of the number it begins with."""
    name = next(name for name in same[0].parameters if name not in _NOT_TOLD)
    sizes = sorted((cause.parameters[name] for cause in same), key=lambda p: p.value)
    number = size_text(sizes[0])
    if sizes[-1].value > sizes[0].value:
        number = f'{sizes[0].value:.4g} to {sizes[-1].value:.4g}'
    unit = '' if sizes[0].unit == '1' else f' {sizes[0].unit}'
    where = ', '.join(dict.fromkeys(cause.joint for cause in same))
    what = words(name.removesuffix(f'_{sizes[0].unit}'))
    return f'{where}: {words(same[0].effect)} ({what} {number}{unit})'


def _with_rivals(cause: Cause, names: Sequence[str]) -> str:
    """
    Return a cause and its rivals; these first where a size of its own may be nothing.

    They explain as much without that size. Of a cosine and a sine one may be nothing.
    """
    own, rivals = describe(cause, names), [words(rival) for rival in cause.rivals]
    kind = TERMS.classes.get(cause.effect)
    sizes = () if kind is None else [kind.reported_as.get(x, x) for x in kind.amplitudes]
    found = [cause.parameters[name] for name in sizes if name in cause.parameters]
    if rivals and 'cosine' not in sizes and any(p.may_be(0.0) for p in found if not _unfelt(p)):
        where, _, own = own.partition(': ')
        return f'{where}: {", or ".join([*rivals, own])}'
    return ', or '.join([own, *rivals])


def _gains(gain: Gain, names: tuple[str, ...], units: tuple[str, ...]) -> str:
    return '; '.join(
        f'{name}: effort error {gain.inverse_before[i]:.3g} -> {gain.inverse_after[i]:.3g} '
        f'{units[i]} ({gain.relative_before[i]:.2f} -> {gain.relative_after[i]:.2f} %)'
        f'{_forward(gain, i, "mrad" if units[i] == "Nm" else "mm")}'
        for i, name in enumerate(names)
        if np.isfinite(gain.relative_before[i])
    )


def _forward(gain: Gain, i: int, unit: str) -> str:
    """Return how far a simulation goes astray, after a comma; '' where none was made."""
    both = gain.forward_before[i], gain.forward_after[i]
    if np.isnan(both).any():
        return ''
    if np.isfinite(both).all():
        before, after = (1e3 * x for x in both)
        chance = ' (chance)' if gain.forward_by_chance[i] else ''
        return f', position after {gain.horizon_s:g} s {before:.3g} -> {after:.3g} {unit}{chance}'
    when = ' and '.join(
        name for name, x in zip(('before', 'after'), both, strict=True) if np.isinf(x)
    )
    return f', a simulation of {gain.horizon_s:g} s runs away {when}'


def _nothing(selection: Selection, gain: Gain, names: tuple[str, ...]) -> str:
    """Return why no cause of the catalogue is named, as a sentence."""
    best = selection.rejected
    if best is None and not selection.accepted:
        best = next(iter(selection.ranking), None)
    if best is not None and best.failed == (NOT_RECURRING,):
        return f'No cause is named: {_but(best, names)}.'
    text = (
        f'no {"other " if selection.accepted else ""}cause removes more of the error than chance '
        'would'
    )
    if best is not None:
        closest = 100 * best.score.cv_gain
        text += f' (closest: {words(best.effect.identifier)}, {closest:.1f} %)'
    left = [
        (name, share, relative)
        for name, share, relative in zip(
            names, selection.remainder.explained, gain.relative_after, strict=False
        )
        if np.isfinite(relative)
    ]
    noisy = [x for x in left if x[2] > 100.0 * REST]
    clear = [x for x in left if x not in noisy]
    if noisy and not clear:
        text = f'These data are too noisy to tell: {text}.'
    else:
        # A joint whose effort is noise for the larger part is not explained.
        where = f' of {", ".join(name for name, *_ in clear)}' if len(clear) < len(names) else ''
        text = f'The refitted model explains the data{where}: {text}.'
    if noisy:
        parts = ', '.join(f'{relative:.0f} % of that of {name}' for name, _, relative in noisy)
        text += f' Noise is the larger part of effort, {parts}: what is smaller does not show.'
    return text + _unsaid(gain, names) + _noise(clear)


def _unsaid(gain: Gain, names: Sequence[str]) -> str:
    """Return of which joints nothing is known, as a sentence with a blank before it."""
    unsaid = [
        n for n, own in zip(names, gain.relative_after, strict=False) if not np.isfinite(own)
    ]
    if not unsaid:
        return ''
    return f' Of {", ".join(unsaid)} nothing is known: see first what is said of the data.'


def _noise(left: Sequence[tuple[str, float, float]]) -> str:
    """Return what is left of each joint, as a sentence with a blank before it."""
    parts = [
        f'{100.0 * share:.1f} % of the {relative:.2f} % of effort that is left in {name}'
        for name, share, relative in left
    ]
    if not parts:
        return ''
    return (
        f' Free curves of one quantity each explain {", ".join(parts)}, in whitened energy, and '
        'those of two at once no more than chance would: what else is left where joints slide is '
        'noise, or too slow to be told from it.'
    )


def _where_unknown(selection: Selection, names: tuple[str, ...], units: tuple[str, ...]) -> str:
    """Return along which axis something is missing, as a sentence with a blank after it."""
    left = selection.remainder
    more = left.significant or left.beyond_chance
    # Axes share what they explain: the largest of a joint stands for the others.
    most = [max((x for x in more if x.joint == i), key=_excess) for i in _joints(more)]
    found = [_along(x, names[x.joint], units[x.joint]) for x in most]
    text = '; '.join(found) + '. ' if found else ''
    if any(x.axis == POSITION and not x.period for x in most):
        text += (
            f'Effort that repeats with position fewer than {PERIODS:g} times in the range of '
            'motion is not looked for, as gravity or a spring may be the same: move over more. '
        )
    return text


def _refused(selection: Selection, names: tuple[str, ...]) -> str:
    """Return what only an impossible cause explains, as a sentence with a blank after it."""
    best = selection.refused
    if best is None:
        return ''
    effect, joint = best.reported(names)
    where = 'all joints' if joint == ALL_JOINTS else joint
    beside = ' beside reversals' if best.effect.reversals_alone else ''
    return (
        f'It acts in {where}{beside}: only {words(effect)} removes more of the error than chance '
        f'would ({100 * best.score.cv_gain:.1f} %), and that is impossible, as {best.objection}. '
    )


def _worse(selection: Selection, names: tuple[str, ...]) -> str:
    """Return which cause the simulation contradicts, as a sentence with a blank after it."""
    best = selection.rejected
    if best is None or not contradicted_by_simulation(selection):
        return ''
    text = _but(best, names)
    return f'{text[0].upper()}{text[1:]}. '


def _but(best: Finding, names: tuple[str, ...]) -> str:
    """Return what a cause that was taken back removes, and why it was."""
    effect, joint = best.reported(names)
    where = 'all joints' if joint == ALL_JOINTS else joint
    removed = 100 * best.score.cv_gain
    return f'{words(effect)} ({where}) removes {removed:.1f} % of the error, but {best.failed[0]}'


def _instead(selection: Selection, names: tuple[str, ...]) -> str:
    """Return what without a name explains more than the best cause, with a blank after it."""
    best = selection.rejected
    if best is None or not best.instead:
        return ''
    effect, joint = best.reported(names)
    where = 'all joints' if joint == ALL_JOINTS else joint
    return f'Of causes {words(effect)} ({where}) comes closest, and {best.instead} explains more. '


def _joints(found: Sequence[Leftover]) -> list[int]:
    return sorted({x.joint for x in found})


def _excess(x: Leftover) -> float:
    return x.energy - x.floor


def _along(x: Leftover, joint: str, unit: str) -> str:
    """Return what is left along an axis, without an end; ``unit``: of the joint's effort."""
    percent, unit = 100.0 * x.share, 'rad' if unit == 'Nm' else 'm'
    number = f'{percent:.0f}' if percent >= 10.0 else f'{percent:.2g}'
    if x.axis == TONE:
        return f'{joint} has {x.axis} of {x.hertz:.3g} Hz: {number} % of what is left'
    if x.axis == SLOW:
        return (
            f'most of what is left of {joint} is too slow for noise, in the lowest tenth of the '
            'band: something acts that lasts'
        )
    if x.axis == BURSTS:
        times = 'a short burst' if x.bursts == 1 else f'{x.bursts} short bursts, the largest'
        held = f' {number} % of what these and the named causes explain' if x.share < 1.0 else ''
        return (
            f'{joint} has {times} at {x.at_s:.2f} s, as of impacts, a touch or wrong values'
            f'{"," if held else ""}{held}'
        )
    if x.instead:
        return (
            f'{joint} depends on {x.axis} in another way: one power of {x.axis} explains more '
            'than what is named'
        )
    what, axis = joint, x.axis
    for by, of in ((FRICTION_BY, 'friction'), (TORQUE_BY, 'the torque constant')):
        if axis.startswith(by):
            what, axis = f'{of} of {joint}', axis.removeprefix(by)
    which = 'which no cause of the catalogue is: ' if axis in NEIGHBOURS else ''
    if x.period:
        explains = (
            f'it explains {number} % of what it and the named causes explain there'
            if x.share < 1.0
            else 'it explains more than noise would'
        )
        return f'{what} has a ripple over {axis}, of period {x.period:.3g} {unit}: {explains}'
    if x.together:
        than = (
            f'{number} % of what they and the named causes do'
            if x.share < 1.0
            else 'more than noise would'
        )
        return (
            f'{what} depends on {axis}, or on something alike: free curves of all quantities '
            f'together explain {than}, though none does alone'
        )
    of_it = 'a free function of both' if axis.endswith(AT_ONCE) else 'a free curve of it'
    if x.share < 1.0:
        return (
            f'{what} depends on {axis} in another way: {which}{of_it} explains '
            f'{number} % of what it and the named causes explain there'
        )
    return f'{what} depends on {axis}: {which}{of_it} explains more than noise would'


def _rest(selection: Selection, names: tuple[str, ...], units: tuple[str, ...]) -> str:
    """Return what free curves explain of the rest, as a sentence with a blank before it."""
    left = selection.remainder
    more = left.beyond_chance
    lines = [x for x in more if x.form in _NO_CURVE]
    text = ''.join(f' {_along(x, names[x.joint], units[x.joint])}.' for x in lines)
    curved = _joints([x for x in more if x.form not in _NO_CURVE])
    if curved:
        parts = [f'{names[i]} {100.0 * left.explained[i]:.0f} %' for i in curved]
        text += (
            ' Free curves of speed, position, acceleration, load, time and the next joint still '
            f'explain some of what is left ({", ".join(parts)} of its whitened energy), so the '
            'catalogue is not the whole.'
        )
    return text


def _number(x: Uncertain, unit: str = '') -> str:
    """Return a number with half of its 95 % interval."""
    return plus_minus(x.value, Z_95 * x.std_error, unit)
