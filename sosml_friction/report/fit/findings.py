# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an analysis says, in sentences."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import lost_share, pauses, pauses_text
from sosml_friction.identification.body_refit import BodyRefit
from sosml_friction.identification.friction_fit import REGRESSION
from sosml_friction.identification.law.law_checks import KNEE
from sosml_friction.identification.law.law_fit import DERIVED, STRIBECK_AT_SLOWEST, LawFit
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.number_text import (
    format_number,
    plus_minus,
    range_text,
    rounded,
    value_text,
    with_interval,
)
from sosml_friction.identification.parameter_interval import (
    covers,
    excluding,
    half_width,
    missed_truths,
)
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common.labels import observer_label, symbols_of
from sosml_friction.report.fit.joint_view import JointView

#: In the place of an observer: what is said of two of them.
BETWEEN = 'between'
#: Share of lost samples that is told. Chosen, no measurement.
_LOST = 0.02
#: A law that leaves more of friction than this [%, root mean squares] explains the smaller part.
_HALF = 50.0


def joint_sentence(view: JointView) -> str:
    """Return the result of one joint in a sentence with its numbers."""
    if view.model is None or view.preferred is None:
        return f'{view.name}: its friction is not available, because {view.unavailable}.'
    fit = view.model.fit
    text = law_sentence(view.name, fit.parameters, fit.law, fit.slowest)
    if view.load is not None and view.preferred == REGRESSION:
        share = plus_minus(100.0 * view.load.value, 100.0 * half_width(view.load), '%')
        text += f'; {share} of its load is friction besides'
    return f'{text} ({observer_label(view.preferred)}, ± is half of the 95 % interval).'


def law_sentence(
    joint: str, parameters: Mapping[str, Parameter], law: str, slowest: float = math.nan
) -> str:
    """
    Return what the friction of a joint is, in a sentence without its full stop.

    What is not identifiable is a range, never a number, and nothing is said of speeds below those
    of the data.

    :param slowest: the slowest speed of the data [rad/s or m/s], NaN if not known.
    """
    parts = [
        _quantity('coulomb', parameters['coulomb'], 'Coulomb friction'),
        _quantity('viscous', parameters['viscous'], 'viscous friction'),
    ]
    if 'power' in parameters:
        bend = f'friction that grows as |v|^{parameters["power"].value:.3g}'
        parts.append(f'{_with_error(parameters["nonlinear_viscous"])} at unit speed of {bend}')
    stribeck = parameters['stribeck']
    told = 'stribeck' in law_definition(law).terms
    # Below zero it cannot be: a range that begins above it is extra friction all the same.
    seen = stribeck.interval is not None and stribeck.interval[0] > 0.0
    if told or seen:
        exponent = parameters.get('exponent')
        parts.append(_stribeck(stribeck, parameters['stribeck_velocity'], exponent))
    text = f'{joint}: {", ".join(parts[:-1])} and {parts[-1]}'
    bias = parameters['bias']
    if NOT_IDENTIFIABLE in bias.flags:
        text += f', on {_quantity("bias", bias, "a bias")}'
    elif not covers(bias, 0.0):
        text += f', on a bias of {_with_error(bias)} that does not change with direction'
    if not (told or seen):
        text += '; extra friction near standstill (Stribeck) is not identifiable from this motion'
        allowed = _range('stribeck', stribeck)
        if not allowed and not math.isnan(slowest):
            speed = unit_of('stribeck_velocity', stribeck.unit)
            allowed = f', whose speeds begin at {format_number(slowest)} {speed}'
        text += allowed
    return text


def law_remarks(fit: LawFit) -> list[str]:
    """
    Return what to know before a law is used.

    Whether it leaves more than it explains, which checks failed, what its knee is like, and where
    S is left open what there is of it at the slowest speed.
    """
    remarks = []
    if fit.relative_error > _HALF:
        remarks.append(
            f'The law leaves {rounded(fit.relative_error)} % of the effort beside the rigid body, '
            'more than half: something else acts, and sosml diagnose looks for what.'
        )
    remarks += [check.sentence for check in fit.checks if not check.passed or check.name == KNEE]
    if STRIBECK_AT_SLOWEST in fit.derived:
        speed = unit_of('stribeck_velocity', fit.derived[STRIBECK_AT_SLOWEST].unit)
        remarks.append(
            f'{derived_sentence(fit, STRIBECK_AT_SLOWEST)[:-1]} '
            f'(w = {format_number(fit.slowest)} {speed}).'
        )
    return remarks


def derived_sentence(fit: LawFit, name: str) -> str:
    """Return what the data tell beside the parameters, a sentence with its full stop."""
    parameter = fit.derived[name]
    known = _with_error(parameter)
    if NOT_IDENTIFIABLE in parameter.flags:
        known = f'{value_text("stribeck", parameter)} {parameter.unit}'
    elif not math.isfinite(parameter.std_error):
        # From a profile, lopsided: half of it is no error of the value.
        known = f'{range_text("stribeck", parameter)} {parameter.unit}'
    text = DERIVED.get(name, name.replace('_', ' '))
    return f'{text[:1].upper()}{text[1:]}: {known}.'


def model_questions(view: JointView) -> list[str]:
    """Return :func:`open_questions` of the law of the model alone."""
    if view.model is None or view.preferred is None:
        return []
    return open_questions(replace(view, fits={view.preferred: view.model}))


def open_questions(view: JointView) -> list[str]:
    """Return for each flag why it is there and what to record, flags of one cause together."""
    subjects: dict[tuple[str, str], dict[str, list[str]]] = {}
    for observer, fit in view.fits.items():
        for name, parameter in fit.fit.parameters.items():
            why = (parameter.reason, parameter.experiment)
            if parameter.flags and any(why):
                subjects.setdefault(why, {}).setdefault(name, []).append(observer_label(observer))
    result = []
    symbols = symbols_of(*(fit.fit.parameters for fit in view.fits.values()))
    for (reason, experiment), names in subjects.items():
        observers = list(dict.fromkeys(label for labels in names.values() for label in labels))
        which = f' ({", ".join(observers)})' if len(observers) < len(view.fits) else ''
        told = '; '.join(part for part in (reason, experiment) if part)
        result.append(f'{", ".join(symbols[name] for name in names)}{which}: {told}.')
    return result


def body_sentences(body: BodyRefit | None) -> list[str]:
    """Return which bodies and rotors were refitted, and why."""
    return [f'{x[:1].upper()}{x[1:]}.' for x in body.sentences()] if body else []


def caveats(views: Sequence[JointView]) -> list[str]:
    """
    Return :func:`notes`, then what is to be known of the law of the model.

    These are its numbers by direction, and what it leaves open, with how to learn it.
    """
    lines = notes(views)
    for view in views:
        if view.model is not None and view.preferred is not None:
            told = [
                derived_sentence(view.model.fit, name)
                for name in view.model.fit.derived
                if name.endswith(('_positive', '_negative'))
            ]
            lines += [f'{view.name}: {text}' for text in [*told, *model_questions(view)]]
    return lines


def notes(views: Sequence[JointView], beside: bool | None = None) -> list[str]:
    """
    Return what a reader should know before using the numbers.

    It names laws that are no friction; methods or observers whose 95 % intervals exclude each
    other, or the truth; and joints that only some observers could be fitted for. Where a parameter
    is left open, it says what the data tell instead.

    :param beside: True for what is said of observers whose fit is not the model, False for what
        is said of the model, None for both.
    """
    subjects: dict[str, dict[str, list[str]]] = {}
    for view in views:
        for observer, text in _remarks(view):
            own = observer in ('', view.preferred)
            if beside is own:
                continue
            labels = subjects.setdefault(text, {}).setdefault(view.name, [])
            if observer not in ('', BETWEEN):
                labels.append(observer_label(observer))
    result = []
    for text, joints in subjects.items():
        who = [f'{name} ({", ".join(them)})' if them else name for name, them in joints.items()]
        result.append(f'{", ".join(who)}: {text}')
    return result


def data_remarks(analysis: BagAnalysis) -> list[str]:
    """Return what is wrong with the recording and the model of it, sentences with full stops."""
    checks = analysis.data_checks
    remarks = []
    if checks is not None:
        remarks = [f'{sentence.rstrip(".")}.' for sentence in checks.sentences]
    elif analysis.model.provenance.get('recovered'):
        remarks = ['The recording is cut off or damaged: only its readable part was used.']
    return remarks + [
        f'{joint}: the model has no friction for it, because {reason.rstrip(".")}.'
        for joint, reason in analysis.unmodelled.items()
    ]


def shared_sentences(said: Mapping[str, Iterable[str]]) -> list[str]:
    """Return sentences on recordings by label, before each the labels if it is not of all."""
    labels: dict[str, list[str]] = {}
    for label, sentences in said.items():
        for sentence in sentences:
            labels.setdefault(sentence, []).append(label)
    return [
        text if len(whose) == len(said) else f'{", ".join(whose)}: {text}'
        for text, whose in labels.items()
    ]


def methods_disagree(view: JointView) -> bool:
    """Tell whether segments and samples exclude each other in a parameter of an observer."""
    return any(
        excluding(fit.fit.parameters, view.alternatives[o].fit.parameters)
        for o, fit in view.fits.items()
        if o in view.alternatives
    )


def _remarks(view: JointView) -> Iterator[tuple[str, str]]:
    """Yield (observer, '' for the joint or :data:`BETWEEN`, sentence)."""
    for observer, other in view.alternatives.items():
        if observer not in view.fits:
            continue
        fit = view.fits[observer]
        apart = excluding(fit.fit.parameters, other.fit.parameters)
        if apart:
            yield (
                observer,
                f'{fit.method} (used here) and {other.method} differ by more than their 95 % '
                f'intervals in {", ".join(apart)}, so one of them is biased: compare both with '
                'the S-curve.',
            )
    if view.model is not None and view.preferred is not None:
        for remark in law_remarks(view.model.fit):
            yield view.preferred, remark
    for observer, fit in view.fits.items():
        missed = missed_truths(fit.fit.parameters, view.known)
        if missed:
            yield observer, f'the truth is outside the 95 % interval of {", ".join(missed)}.'
    for first, second in itertools.pairwise(view.fits.values()):
        apart = excluding(first.fit.parameters, second.fit.parameters)
        if apart:
            why = ''
            if second.observer == REGRESSION:
                why = ': only the latter has bodies, friction by load or cogging fitted beside it'
            yield (
                BETWEEN,
                f'{observer_label(first.observer)} and {observer_label(second.observer)} differ '
                f'by more than their 95 % intervals in {", ".join(apart)}{why}.',
            )
    if view.fits and view.unavailable:
        yield '', f'{view.unavailable}.'


def _with_error(parameter: Parameter) -> str:
    half = half_width(parameter)
    unknown = '' if math.isfinite(half) else ' (uncertainty unknown)'
    return with_interval(parameter, parameter.unit) + unknown


def _quantity(name: str, parameter: Parameter, what: str) -> str:
    if NOT_IDENTIFIABLE not in parameter.flags:
        return f'{_with_error(parameter)} of {what}'
    return f'{what} that this motion leaves open{_range(name, parameter)}'


def _range(name: str, parameter: Parameter) -> str:
    text = range_text(name, parameter)
    return f' ({text} {parameter.unit})' if text else ''


def _stribeck(stribeck: Parameter, velocity: Parameter, exponent: Parameter | None) -> str:
    if NOT_IDENTIFIABLE not in stribeck.flags:
        fading = (
            f'a speed that it leaves open{_range("stribeck_velocity", velocity)}'
            if NOT_IDENTIFIABLE in velocity.flags
            else _with_error(velocity)
        )
        if exponent is not None:
            fading += f' with the exponent {_with_error(exponent).removesuffix(" 1")}'
        return f'{_with_error(stribeck)} more near standstill, fading over {fading}'
    return (
        f'more near standstill, whose size this motion leaves open{_range("stribeck", stribeck)}'
    )


def sampling_text(log: JointLog) -> str:
    """Return how much was recorded, how fast, and what share of the samples was lost."""
    count, span = len(log), float(log.time[-1] - np.sum(pauses(log.time)))
    if not span > 0.0:
        return f'{count} samples'
    text = f'{count} samples over {span:.1f} s, {(count - 1) / span:.4g} Hz'
    lost = lost_share(log.time)
    if lost > _LOST:
        text += f'; {100.0 * lost:.2g} % more were lost, in steps of two or more usual ones'
    apart = pauses_text(log.time)
    return f'{text}; {apart}' if apart else text


def simulation_lines(analysis: BagAnalysis) -> list[str]:
    """Return how well simulation follows a recording, a line for each joint."""
    found = analysis.output_error
    if found is None:
        return []
    lines = [
        f'{joint}: closed loop simulated with the inverse model and the recorded controller: '
        f'position {check.position_error:.2g} %, effort {check.effort_error:.2f} % of the measured'
        for joint, check in found.closed_loop.items()
    ]
    for joint, fit in found.joints.items():
        controlled = found.modes[joint] == 'controller'
        how = 'under the recorded controller' if controlled else 'by the measured effort'
        effort = '' if np.isnan(fit.effort_error) else f', effort {fit.effort_error:.2f} %'
        lines.append(
            f'{joint}: output error, simulated {how}: position {fit.position_error:.2g} %{effort} '
            'of the measured'
        )
    lines += [f'{joint}: no output error: {why}' for joint, why in found.unavailable.items()]
    return lines
