# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From recordings and a model to a verdict."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.adequacy import AXES, Leftover, leftovers
from sosml_friction.diagnosis.confusability import Confusability, confusability
from sosml_friction.diagnosis.data_checks import Check, check_log, velocity_lag
from sosml_friction.diagnosis.effect import ALL_JOINTS, Effect, Inner
from sosml_friction.diagnosis.evidence import Target, fit_baseline
from sosml_friction.diagnosis.experiment import Recommendation, recommend
from sosml_friction.diagnosis.forward_gain import HORIZON_S, ForwardGain, gets_worse
from sosml_friction.diagnosis.gain import Gain, make_gain
from sosml_friction.diagnosis.laboratory import Laboratory
from sosml_friction.diagnosis.library import DATA_CAUSES, EFFECTS, library_hash, make_library
from sosml_friction.diagnosis.model_effects import known_effects, with_known
from sosml_friction.diagnosis.selection import Finding, Selection, Selector
from sosml_friction.diagnosis.settings import DiagnosisSettings
from sosml_friction.diagnosis.signals import Signals, prepare
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Parameter

FloatArray = NDArray[np.float64]

VERDICTS = ('named', 'ambiguous', 'nothing_above_floor', 'unknown_structure', 'bad_data')
#: Where axes without physics predict more than half of all that is predictable, the named causes
#: are the smaller part.
_REST = 0.5
#: Share of the residual's energy that a burst's episodes hold at least to be a cause.
_BURST = 0.02
#: Faults of the data that leave nothing in the residual.
_NO_EXCUSE = ('velocity_lag', 'dropped_samples')
#: Numbers that a sentence does without: a switch between forms, and what a data check looks at.
_NOT_TOLD = ('by_speed', 'step_s', 'jitter_s', 'lag_std_error_s')
#: What is said of a cause that the forward simulation does not bear out.
_FORWARD_WORSE = 'the forward simulation of data left out gets worse'


@dataclass(frozen=True)
class Cause:
    """
    Hold one cause.

    ``joint``: its name, or '*' for all; ``evidence``: delta_bic, p_adjusted, cv_gain, cv_gain_se,
    folds_improved, floor; None where a data check and not the model shows it. ``rivals``: causes
    that explain as much. ``terms``: inner parameters and amplitudes of each harmonic.
    """

    effect: str
    joint: str
    parameters: Mapping[str, Parameter]
    evidence: Mapping[str, float | None]
    rivals: tuple[str, ...] = ()
    terms: tuple[tuple[Inner, FloatArray], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'effect': self.effect,
            'joint': self.joint,
            'parameters': {
                name: {'value': p.value, 'std_error': p.std_error, 'unit': p.unit}
                for name, p in self.parameters.items()
            },
            'evidence': dict(self.evidence),
            'rivals': list(self.rivals),
        }


@dataclass(frozen=True)
class Diagnosis:
    """
    Hold a verdict and what it rests on.

    ``stages``: relative effort error [%] on folds left out, refitted and after each cause.
    ``refit``, ``refit_errors``: deviations of nominal parameters, and their standard errors.
    ``ranking``: the first round's candidates, best first; ``rejected``: the best that failed a
    gate, and which; ``laboratory`` and ``selection`` are what the report draws from, None where
    the data were too bad. ``confusability``: which candidates look alike along this motion.
    """

    verdict: str
    causes: tuple[Cause, ...]
    checks: tuple[Check, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    library_hash: str
    sentence: str
    gain: Gain | None = None
    recommendation: Recommendation | None = None
    ranking: tuple[dict[str, Any], ...] = ()
    rejected: dict[str, Any] | None = None
    refit: Mapping[str, float] = field(default_factory=dict)
    refit_errors: Mapping[str, float] = field(default_factory=dict)
    structure: Mapping[str, Any] = field(default_factory=dict)
    stages: tuple[dict[str, Any], ...] = ()
    band_hz: float = float('nan')
    laboratory: Laboratory | None = None
    selection: Selection | None = None
    confusability: Confusability | None = None
    residual_before: FloatArray | None = None
    residual_after: FloatArray | None = None


def diagnose(
    logs: Sequence[JointLog],
    model: RobotModelFile,
    holdout: JointLog | None = None,
    settings: DiagnosisSettings | None = None,
    without: tuple[str, ...] = (),
    step: Callable[[str], None] = lambda text: None,
) -> Diagnosis:
    """
    Say what a model gets wrong about recordings, and why.

    :param logs: recordings; their joints include the model's.
    :param holdout: another recording, on which the gain is measured; None for folds of ``logs``.
    :param without: effects not to look for.
    :param step: called with what is being done.
    :raises DataError: if a joint of the model is not in a recording.
    :raises ConfigurationError: if ``holdout`` is of no use.
    """
    settings = settings or DiagnosisSettings()
    robot = model.make_robot()
    logs = [log.select(robot.names) for log in logs]
    library = make_library(without)
    known_effects(model)
    digest = library_hash(library)
    step('checking the data')
    checks = [check for log in logs for check in check_log(log)]
    bad = next((check for check in checks if check.severity == 'bad'), None)
    if bad is not None:
        return Diagnosis(
            'bad_data', (), tuple(checks), robot.names, robot.effort_units, digest, bad.sentence
        )
    try:
        signals = with_known(prepare(logs, model, robot, settings), model)
        for i in range(robot.n):
            lag = velocity_lag(logs[0], signals[0], i)
            if lag is not None:
                checks.append(lag)
        others = None if holdout is None else _prepared(holdout, model, signals[0], settings)
        laboratory = Laboratory(signals, library, settings, step)
    except DataError as error:
        return Diagnosis(
            'bad_data', (), tuple(checks), robot.names, robot.effort_units, digest, str(error)
        )
    selector = Selector(laboratory, step)
    selection = selector.run()
    step('measuring the gain')
    squares = _forward_gate(ForwardGain(laboratory, model, others), laboratory, selection)
    if selection.rejected is not None and selection.rejected.failed == (_FORWARD_WORSE,):
        selector.judge_structure(selection)
        selection.leftovers = leftovers(laboratory, selection.accepted, selector.credible)
    gain, before, after = _gain(laboratory, selection, others, squares)
    if holdout is not None:
        # The pictures show the recording that was diagnosed, the numbers the other one.
        _, before, after = _gain(laboratory, selection, None, squares)
    causes = _data_causes(checks, laboratory, without, selection)
    causes += _model_causes(laboratory, selection)
    verdict = _verdict(causes, selection)
    recommendation = None
    if verdict == 'ambiguous':
        step('looking for an experiment that separates the rivals')
        recommendation = recommend(laboratory, selection, model)
    assert selection.after is not None
    structure = {
        'cv_gain': [float(x) for x in selection.structure_gain],
        'floor': [float(x) for x in selection.structure_floor],
        'axes': [
            {
                'axis': x.axis,
                'joint': robot.names[x.joint],
                'energy': x.gain,
                'floor': x.floor,
                'share': x.share,
                'unknown': x.significant(settings.axis_share),
            }
            for x in selection.leftovers
        ],
    }
    refit = dict(zip(laboratory.nominal.names, selection.after.x.tolist(), strict=False))
    sentence = _sentence(verdict, causes, gain, selection, robot.names, robot.effort_units)
    return Diagnosis(
        verdict,
        tuple(causes),
        tuple(checks),
        robot.names,
        robot.effort_units,
        digest,
        sentence,
        gain=gain,
        recommendation=recommendation,
        ranking=tuple(_entry(f, robot.names) for f in selection.ranking),
        rejected=None if selection.rejected is None else _entry(selection.rejected, robot.names),
        refit=refit,
        refit_errors=dict(
            zip(laboratory.nominal.names, _standard_errors(selection).tolist(), strict=False)
        ),
        structure=structure,
        stages=tuple(_stages(laboratory, selection)),
        band_hz=signals[0].band.cutoff,
        laboratory=laboratory,
        selection=selection,
        confusability=confusability(laboratory, selection.accepted),
        residual_before=before,
        residual_after=after,
    )


def _prepared(
    holdout: JointLog, model: RobotModelFile, first: Signals, settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the signals of the recording the gain is measured on, seen as ``first`` is.

    :raises ConfigurationError: if it is of no use.
    """
    log = holdout.select(first.robot.names)
    bad = next((check for check in check_log(log) if check.severity == 'bad'), None)
    if bad is not None:
        raise ConfigurationError(f'the recording left out (holdout): {bad.sentence}')
    band = replace(settings, band=first.band.cutoff)
    try:
        return with_known(prepare([log], model, first.robot, band, first.scales), model)
    except DataError as error:
        raise ConfigurationError(f'the recording left out (holdout): {error}') from None


def _entry(finding: Finding, names: tuple[str, ...]) -> dict[str, Any]:
    return {
        'effect': finding.effect.identifier,
        'joint': joint_name(finding.effect, finding.joint, names),
        'delta_bic': finding.delta_bic,
        'cv_gain': finding.score.cv_gain,
        'cv_gain_se': finding.score.cv_se,
        'floor': finding.floor,
        'objection': finding.objection,
        'failed': list(finding.failed),
    }


def joint_name(effect: Effect, joint: int, names: tuple[str, ...]) -> str:
    """Return the name under which a cause is reported."""
    return ALL_JOINTS if effect.of_robot else names[joint]


def _data_causes(
    checks: Sequence[Check],
    laboratory: Laboratory,
    without: tuple[str, ...],
    selection: Selection,
) -> list[Cause]:
    """Return the causes that are faults of the data, impacts of teeth, and bursts."""
    causes = []
    nothing: dict[str, float | None] = dict.fromkeys(
        ('delta_bic', 'p_adjusted', 'cv_gain', 'cv_gain_se', 'folds_improved')
    )
    units = {'s': 's', 'share': '1', 'stamps': '1', 'scale': '1', 'error': 's'}
    for check in checks:
        if check.severity == 'warning' and check.kind in ('velocity_lag', 'dropped_samples'):
            if check.kind in without:
                continue
            parameters = {
                name: Parameter(value, units.get(name.rpartition('_')[2], '1'))
                for name, value in check.values.items()
            }
            causes.append(Cause(check.kind, check.joint, parameters, nothing))
    names = laboratory.robot.names
    for impacts in laboratory.bursts.impacts:
        if 'backlash' in without:
            continue
        parameters = {
            **_gap(laboratory, selection, impacts.joint),
            'load_changes': Parameter(float(impacts.changes), '1'),
            'impact_share': Parameter(impacts.share, '1'),
            'impact_ratio': Parameter(impacts.ratio, '1'),
        }
        rivals = () if 'joint_elasticity' in without else ('joint_elasticity',)
        causes.append(Cause('backlash', names[impacts.joint], parameters, nothing, rivals))
    if 'external_contact' in without:
        return causes
    for i, name in enumerate(names):
        episodes = [e for e in laboratory.bursts.episodes if e.joint == i]
        share = sum(e.energy for e in episodes) / (len(laboratory.y) + 1e-9)
        if not episodes or share < _BURST:
            continue
        parameters = {'episodes': Parameter(float(len(episodes)), '1')}
        for k, e in enumerate(episodes[:20], 1):
            parameters[f'start_{k}'] = Parameter(e.start_s, 's')
            parameters[f'end_{k}'] = Parameter(e.end_s, 's')
        causes.append(Cause('external_contact', name, parameters, nothing))
    return causes


def _gap(laboratory: Laboratory, selection: Selection, joint: int) -> dict[str, Parameter]:
    """
    Return the parameters of the gear with a gap that leaves least of the impacts.

    Amplitude 1, as simulated; their waveform is hardly predicted, so that they are rough and have
    no standard errors.
    """
    assert selection.after is not None
    effect, first = EFFECTS['backlash'](), laboratory.signals[0]
    y, Z, _ = laboratory.unwhitened()
    left = y - Z @ selection.after.x[: Z.shape[2]]
    rows = laboratory.bursts.mask[:, joint]
    size = np.maximum(np.std(left[~rows], axis=0), 1e-300)
    grid = effect.grid(first, joint)
    energies = [
        float(
            (((left - laboratory.own_columns(effect, joint, inner)[:, :, 0])[rows] / size) ** 2)
            .sum()
        )
        for inner in grid
    ]  # fmt: skip
    inner = grid[int(np.argmin(energies))]
    one, unknown = np.ones(1), np.full(1, np.nan)
    return effect.parameters(first, joint, inner, one, unknown)


def _model_causes(laboratory: Laboratory, selection: Selection) -> list[Cause]:
    """Return accepted findings as causes; several of one effect and joint are its harmonics."""
    names = laboratory.robot.names
    errors = _standard_errors(selection)
    assert selection.after is not None
    p = len(laboratory.nominal.bound)
    causes: dict[tuple[str, int], Cause] = {}
    first = p
    for finding in selection.accepted:
        k = finding.columns.C.shape[3]
        amplitude = selection.after.x[first : first + k]
        error = errors[first : first + k]
        first += k
        parameters = finding.effect.parameters(
            laboratory.signals[0], finding.joint, finding.inner, amplitude, error
        )
        inseparable = finding.effect.inseparable
        rivals = list(inseparable)
        for rival in finding.rivals:
            label = rival.effect.identifier
            where = joint_name(rival.effect, rival.joint, names)
            if where != joint_name(finding.effect, finding.joint, names):
                label = f'{label}@{where}'
            if label not in rivals:
                rivals.append(label)
        term = ((dict(finding.inner), np.array(amplitude)),)
        if finding.key in causes:
            old = causes[finding.key]
            number = len(old.terms) + 1
            more = {f'{name}_{number}': value for name, value in parameters.items()}
            causes[finding.key] = replace(
                old, parameters={**old.parameters, **more}, terms=old.terms + term
            )
            continue
        evidence: dict[str, float | None] = {
            'delta_bic': finding.delta_bic,
            'p_adjusted': finding.p_adjusted,
            'cv_gain': finding.score.cv_gain,
            'cv_gain_se': finding.score.cv_se,
            'folds_improved': finding.score.improved,
            'floor': finding.floor,
        }
        causes[finding.key] = Cause(
            finding.effect.identifier,
            joint_name(finding.effect, finding.joint, names),
            parameters,
            evidence,
            tuple(rivals),
            term,
        )
    return list(causes.values())


def _standard_errors(selection: Selection) -> FloatArray:
    """Return standard errors (p,) from the whitened equations, scaled by what is left."""
    assert selection.system is not None
    assert selection.after is not None
    system = selection.system
    G = system.G.sum(axis=(0, 1)) + np.diag(system.penalty())
    scale = 1.0 / np.sqrt(np.diag(G))
    covariance = np.linalg.pinv(G * scale * scale[:, None]) * scale * scale[:, None]
    rows = system.Z.shape[0] * system.Z.shape[1]
    left = max(selection.after.cost / rows, 1.0)
    return np.asarray(np.sqrt(np.maximum(np.diag(covariance) * left, 0.0)))


def _gain(
    laboratory: Laboratory,
    selection: Selection,
    others: Sequence[Signals] | None,
    squares: tuple[FloatArray, FloatArray],
) -> tuple[Gain, FloatArray, FloatArray]:
    """Return the gain on data left out, and effort errors (rows, n) before and after there."""
    assert selection.before is not None
    assert selection.after is not None
    accepted = selection.accepted
    if others is None:
        y, Z, _ = laboratory.unwhitened()
        more = [laboratory.own_columns(f.effect, f.joint, f.inner) for f in accepted]
        wide = np.concatenate([Z, *more], axis=2) if more else Z
        before, after = y.copy(), y.copy()
        blocks = laboratory.blocks
        for b, (first, last) in enumerate(itertools.pairwise(blocks.edges)):
            f = int(blocks.fold[b])
            before[first:last] -= Z[first:last] @ selection.before.fold_x[f]
            after[first:last] -= wide[first:last] @ selection.after.fold_x[f]
        measured = np.concatenate(
            [s.band.apply(s.tau)[-len(part) :] for s, part in zip(
                laboratory.signals, laboratory.split(y), strict=True)]
        )  # fmt: skip
        gain = make_gain(before, after, measured, *squares, HORIZON_S, 'folds left out')
        return gain, before, after
    parts: list[list[FloatArray]] = [[], [], []]
    for s in others:
        y = s.in_band(s.tau - s.torque)
        Z = s.in_band(laboratory.nominal.columns(s))
        more = [s.in_band(f.effect.columns(s, f.joint, f.inner)) for f in accepted]
        wide = np.concatenate([Z, *more], axis=2) if more else Z
        parts[0].append(y - Z @ selection.before.x)
        parts[1].append(y - wide @ selection.after.x)
        parts[2].append(s.band.apply(s.tau))
    before, after, measured = (np.concatenate(part) for part in parts)
    gain = make_gain(before, after, measured, *squares, HORIZON_S, 'another recording')
    return gain, before, after


def _stages(laboratory: Laboratory, selection: Selection) -> list[dict[str, Any]]:
    """Return the relative effort error [%] by joint on folds left out, after each cause."""
    y, Z, _ = laboratory.unwhitened()
    measured = np.concatenate(
        [
            s.band.apply(s.tau)[-len(part) :]
            for s, part in zip(laboratory.signals, laboratory.split(y), strict=True)
        ]
    )
    size = np.linalg.norm(measured, axis=0)
    blocks = laboratory.blocks
    names = laboratory.robot.names
    result = []
    wide = Z
    for k in range(len(selection.accepted) + 1):
        done = selection.accepted[:k]
        if done:
            f = done[-1]
            wide = np.concatenate(
                [wide, laboratory.own_columns(f.effect, f.joint, f.inner)], axis=2
            )
        system = laboratory.system.extended([f.columns for f in done])
        fold_x = fit_baseline(system, Target.make(system, laboratory.y)).fold_x
        left = y.copy()
        for b, (first, last) in enumerate(itertools.pairwise(blocks.edges)):
            left[first:last] -= wide[first:last] @ fold_x[int(blocks.fold[b])]
        error = 100.0 * np.linalg.norm(left, axis=0) / size
        result.append(
            {
                'effect': done[-1].effect.identifier if done else None,
                'joint': joint_name(done[-1].effect, done[-1].joint, names) if done else None,
                'relative_error_percent': dict(zip(names, error.tolist(), strict=True)),
            }
        )
    return result


def _forward_gate(
    forward: ForwardGain, laboratory: Laboratory, selection: Selection
) -> tuple[FloatArray, FloatArray]:
    """
    Take back the last causes while they make the simulation of data left out worse.

    Worse than that of the refitted nominal, or than without the last one. Returns the mean squares
    of the windows (W, n), refitted and with the causes that stay.
    """
    assert selection.before is not None
    assert selection.after is not None
    before = forward.squares((), selection.before.x, selection.before.fold_x)
    if not selection.accepted:
        return before, before
    after = forward.squares(selection.accepted, selection.after.x, selection.after.fold_x)
    while selection.accepted:
        *fewer, last = selection.accepted
        system = laboratory.system.extended([f.columns for f in fewer])
        target = Target.make(system, laboratory.y)
        refit = fit_baseline(system, target)
        without = forward.squares(fewer, refit.x, refit.fold_x) if fewer else before
        rows = last.columns.rows
        if not (gets_worse(before, after, rows) or gets_worse(without, after, rows)):
            break
        selection.accepted = fewer
        selection.rejected = replace(last, failed=(_FORWARD_WORSE,))
        selection.system, selection.target, selection.after = system, target, refit
        after = without
    return before, after


def _more_along_axis(selection: Selection) -> list[Leftover]:
    """Return where a free curve explains what the causes of its axis leave."""
    assert selection.settings is not None
    return [x for x in selection.leftovers if x.significant(selection.settings.axis_share)]


def _verdict(causes: Sequence[Cause], selection: Selection) -> str:
    over = selection.structure_gain > selection.structure_floor
    rest = float(np.maximum(selection.structure_energy, 0.0)[over].sum())
    whole = max(selection.named_energy, 0.0) + rest
    # The recorded velocity takes no part and short holes are bridged: what is left is not theirs.
    if any(cause.effect not in _NO_EXCUSE for cause in causes):
        if selection.accepted and rest > _REST * whole:
            return 'unknown_structure'
        more = _more_along_axis(selection)
        if any(x.instead or x.foreign for x in more):
            return 'unknown_structure'
        on_axis = all(f.effect.identifier in AXES for f in selection.accepted)
        if selection.accepted and on_axis and more:
            return 'unknown_structure'
        return 'ambiguous' if any(cause.rivals for cause in causes) else 'named'
    if over.any():
        return 'unknown_structure'
    rejected = selection.rejected
    if (
        selection.masked is not None
        and rejected is not None
        and rejected.score.cv_gain > rejected.floor
    ):
        return 'unknown_structure'
    return 'named' if causes else 'nothing_above_floor'


def describe(cause: Cause) -> str:
    """Return a cause in words, with its first numbers."""
    words = cause.effect.replace('_', ' ')
    where = 'all joints' if cause.joint == ALL_JOINTS else cause.joint
    numbers = []
    told = [(name, p) for name, p in cause.parameters.items() if name not in _NOT_TOLD]
    for name, p in told[:3]:
        # The names of what data checks found end in their unit.
        name = name.removesuffix(f'_{p.unit}')
        error = f' ± {p.std_error:.2g}' if np.isfinite(p.std_error) and p.std_error > 0 else ''
        unit = '' if p.unit == '1' else f' {p.unit}'
        numbers.append(f'{name.replace("_", " ")} {p.value:.4g}{error}{unit}')
    return f'{where}: {words} ({", ".join(numbers)})'


def _sentence(
    verdict: str,
    causes: Sequence[Cause],
    gain: Gain,
    selection: Selection,
    names: tuple[str, ...],
    units: tuple[str, ...],
) -> str:
    """Return the verdict with its numbers, for a person."""
    if verdict == 'nothing_above_floor':
        return _nothing(selection)
    gains = '; '.join(
        f'{name}: effort error {gain.inverse_before[i]:.3g} -> {gain.inverse_after[i]:.3g} '
        f'{units[i]} ({gain.relative_before[i]:.2f} -> {gain.relative_after[i]:.2f} %), position '
        f'after {gain.horizon_s:g} s {1e3 * gain.forward_before[i]:.3g} -> '
        f'{1e3 * gain.forward_after[i]:.3g} {"mrad" if units[i] == "Nm" else "mm"}'
        for i, name in enumerate(names)
    )
    if verdict == 'unknown_structure':
        causes = [cause for cause in causes if cause.effect not in _NO_EXCUSE]
    told = '; '.join(
        describe(cause) + (f', or {", or ".join(r.replace("_", " ") for r in cause.rivals)}'
                           if cause.rivals else '')
        for cause in causes
    )  # fmt: skip
    if verdict == 'unknown_structure':
        text = 'The model misses something that no cause of the catalogue explains'
        if causes:
            text += f'; in part it looks like {told}'
        return f'{text}. {_where_unknown(selection, names)}On {gain.on}: {gains}.'
    lead = 'Named' if verdict == 'named' else 'These data leave a choice'
    if all(cause.effect in DATA_CAUSES for cause in causes):
        rest = _rest(selection, names).lstrip() or _nothing(selection)
        return f'Named, of the data: {told}. {rest}'
    return f'{lead}: {told}. On {gain.on}: {gains}.{_rest(selection, names)}'


def _nothing(selection: Selection) -> str:
    """Return why no cause of the catalogue is named, as a sentence."""
    best = selection.rejected or next(iter(selection.ranking), None)
    if best is not None and best.failed == (_FORWARD_WORSE,):
        return (
            f'No cause is named: {best.effect.identifier.replace("_", " ")} removes '
            f'{100 * best.score.cv_gain:.1f} % of the error, but with it {_FORWARD_WORSE}.'
        )
    text = (
        'The refitted model explains the data: no cause removes more of the error than chance '
        'would'
    )
    if best is not None:
        text += (
            f' (closest: {best.effect.identifier.replace("_", " ")}, '
            f'{100 * best.score.cv_gain:.1f} %)'
        )
    return text + '.'


def _where_unknown(selection: Selection, names: tuple[str, ...]) -> str:
    """Return along which axis something is missing, as a sentence with a blank after it."""
    found = []
    for x in _more_along_axis(selection):
        how = (
            f'one power of {x.axis} explains more than what is named'
            if x.instead
            else f'a free curve of {x.axis} explains {100.0 * x.share:.0f} % of what the two '
            'explain together'
        )
        found.append(f'{names[x.joint]} depends on {x.axis} in another way: {how}')
    if found:
        return '; '.join(found) + '. '
    return (_rest(selection, names) + ' ').lstrip()


def _rest(selection: Selection, names: tuple[str, ...]) -> str:
    """Return what free curves predict of the rest, as a sentence with a blank before it."""
    parts = [
        f'{name} {100.0 * gain:.0f} %'
        for name, gain, floor in zip(
            names, selection.structure_gain, selection.structure_floor, strict=True
        )
        if gain > floor
    ]
    if not parts:
        return ''
    return (
        ' Free curves of speed, position, acceleration and load still predict some of what is '
        f'left ({", ".join(parts)} of its whitened energy), so the catalogue is not the whole.'
    )
