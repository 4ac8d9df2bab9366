# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Hide effects in a linear axis and ask ``sosml diagnose``, which sees a nominal model and the bag.

    python -m validation.axis_campaign --seed 1 --out OUT

One file per trial in OUT: a run that was stopped goes on. Kinds: ``single``, one effect;
``null``, none; ``outside``, what the catalogue does not have; ``guess``, both parameters of the
nominal friction off by 10 to 200 %, every second with a Stribeck effect besides. A nominal
parameter that is named and truly beyond its tolerance is right, and no cause to be judged.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.diagnosis.bag_diagnosis import diagnose_bags
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.model.model_folder import FrictionParameters, JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.diagnosis.document import diagnosis_document
from validation.axis_plant import (
    CATALOGUE,
    LEAST,
    OUTSIDE,
    Axis,
    hide,
    make_axis,
    moves,
    signal_to_noise,
    simulate,
)
from validation.judge import judge, named
from validation.kept_trials import kept_trials, outcomes, parser_of
from validation.losses import with_losses
from validation.trial import Truth

#: Number of the motion that is diagnosed, and of that on which gains are measured; their length
#: [s]; the range in which SNR is drawn.
MOTION, OTHER, LONG_S, OTHER_S, SNR = 1, 2, 70.0, 40.0, (0.7, 3.0)
#: Share of itself by which a nominal parameter may be off and be no cause, as the package says.
TOLERANCE = 0.035


def model(coulomb: float, viscous: float) -> RobotModelFile:
    """Return the nominal axis with a friction [N, N s/m]."""
    axis = Axis()
    parameters = {
        'coulomb': Parameter(coulomb, 'N'),
        'viscous': Parameter(viscous, 'N s/m'),
        'bias': Parameter(0.0, 'N'),
    }
    friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
    joint = JointModel(Parameter(axis.motor, 'kg'), friction)
    return RobotModelFile('axis', {'axis': joint}, axis.urdf())


@dataclass(frozen=True)
class Hidden:
    """
    Hold what was hidden in an axis, and what was recorded of it.

    ``row``: kind, effect, number, SNR and size; ``plain``: the axis without the effect; ``guess``:
    the nominal friction [N, N s/m]; ``logs``: the recording and the one that is left out.
    """

    row: dict[str, Any]
    plain: Axis
    guess: FloatArray
    logs: tuple[JointLog, JointLog]


def trial(seed: int, kind: str, effect: str, k: int, *, lossy: bool = False) -> dict[str, Any]:
    """Return what was hidden, what was answered, and what that is worth."""
    this = hidden(seed, kind, effect, k)
    if lossy:
        rng = np.random.default_rng([seed, k, 1])
        recording, other = (with_losses(log, rng) for log in this.logs)
        this = replace(this, logs=(recording, other))
    return asked(this)


def hidden(seed: int, kind: str, effect: str, k: int) -> Hidden:
    """Return an axis with an effect, recorded."""
    rng = np.random.default_rng([seed, k, *f'{kind} {effect}'.encode()])
    noise = 2.0 if kind == 'null' and k % 2 else 1.0
    axis = plain = make_axis(rng)
    reference, snr, size = moves(MOTION, LONG_S), None, 0.0
    if effect:
        wanted = float(np.exp(rng.uniform(*np.log(SNR))))
        typical = {**CATALOGUE, **OUTSIDE}[effect]
        number, size = int(rng.integers(2**31)), typical
        for _ in range(4):
            axis = hide(plain, effect, size, np.random.default_rng(number), LONG_S)
            snr = signal_to_noise(axis, plain, reference, noise)
            size = float(np.clip(size * wanted / snr, LEAST * typical, 6.0 * typical))
        axis = hide(plain, effect, size, np.random.default_rng(number), LONG_S)
        snr = signal_to_noise(axis, plain, reference, noise)
    guess = np.array([Axis().coulomb, Axis().viscous])
    if kind == 'guess':
        share = 1.0 + np.exp(rng.uniform(np.log(0.1), np.log(2.0), 2))
        guess = guess * share ** rng.choice([-1.0, 1.0], 2)
    row: dict[str, Any] = {'kind': kind, 'effect': effect, 'k': k, 'snr': snr, 'size': size}
    logs = [recorded(axis, way, rng, noise) for way in (reference, moves(OTHER, OTHER_S))]
    return Hidden(row, plain, guess, (logs[0], logs[1]))


def asked(this: Hidden, settings: DiagnosisSettings | None = None) -> dict[str, Any]:
    """Return what was answered of an axis, and what that is worth."""
    row, plain, guess = this.row, this.plain, this.guess
    kind, effect, size = (row[name] for name in ('kind', 'effect', 'size'))
    with tempfile.TemporaryDirectory() as name:
        bags = [Path(name) / 'bag', Path(name) / 'holdout']
        for bag, log in zip(bags, this.logs, strict=True):
            write_joint_log(log, bag)
        try:
            nominal = model(*guess.tolist())
            found = diagnose_bags(bags[:1], nominal, holdout=bags[1], settings=settings)
        except SosmlFrictionError as error:
            return {**row, 'outcome': 'failed', 'said': str(error)}
    document = diagnosis_document(found.diagnosis, found.provenance)
    # Samples that are lost are told whatever else is there.
    document = without(document, ['dropped_samples'])
    off = {
        'coulomb': plain.coulomb - guess[0],
        'viscous': plain.viscous - guess[1],
        'inertia': plain.motor + plain.carriage - Axis().motor - Axis().carriage,
    }
    truths = [Truth(effect, '*' if effect == 'effort_delay' else 'axis', size)] if effect else []
    if kind == 'guess':
        del off['inertia']
        outcome, spurious, true = judge_guess(document, off, effect), 0, []
    else:
        true = truly_off(document, off, effect)
        judged = judge(kind, truths, without(document, true))
        outcome, spurious = judged.outcome, judged.spurious
    return {
        **row,
        'outcome': outcome,
        'spurious': spurious,
        'truly_off': true,
        'verdict': document['verdict'],
        'causes': [[c['effect'], c['joint'], c['rivals']] for c in document['causes']],
        'parameters': [c['parameters'] for c in document['causes']],
        'sentence': document['sentence'],
        'off': {n: getattr(plain, n) / getattr(Axis(), n) - 1.0
                for n in ('motor', 'carriage', 'coulomb', 'viscous')},
        'guess': guess.tolist(),
    }  # fmt: skip


def recorded(axis: Axis, motion: np.ndarray, rng: np.random.Generator, noise: float) -> JointLog:
    """Return what is recorded along a motion."""
    t, *signals = simulate(axis, motion, rng, noise)
    stamps = np.rint(1e9 * t).astype(np.int64)
    return JointLog(('axis',), stamps, *(x[:, None] for x in signals))


def truly_off(document: dict[str, Any], off: dict[str, float], effect: str) -> list[str]:
    """
    Return the nominal parameters that are named, and off by more than the tolerance in truth.

    With their size within three standard errors: the nuisance is a Gaussian, and has tails.
    """
    axis = Axis()
    nominal = {'coulomb': axis.coulomb, 'viscous': axis.viscous,
               'inertia': axis.motor + axis.carriage}  # fmt: skip
    result = []
    for cause in named(document):
        name = cause['effect']
        if name in off and name != effect and abs(off[name]) > TOLERANCE * nominal[name]:
            size = cause['parameters']['change']
            if abs(size['value'] - off[name]) < 3.0 * size['std_error']:
                result.append(name)
    return result


def without(document: dict[str, Any], true: list[str]) -> dict[str, Any]:
    """Return an answer without causes that are right beside what is hidden."""
    causes = [cause for cause in document['causes'] if cause['effect'] not in true]
    silent = true and not causes and document['verdict'] in ('named', 'ambiguous')
    verdict = 'nothing_above_floor' if silent else document['verdict']
    return {**document, 'causes': causes, 'verdict': verdict}


def judge_guess(document: dict[str, Any], off: dict[str, float], effect: str) -> str:
    """
    Return what an answer is worth where both parameters of friction are off.

    ``right``: both are named within three standard errors, Stribeck only where it is, and nothing
    else; ``size``: the names alone are right.
    """
    causes = {cause['effect']: cause['parameters'] for cause in named(document)}
    if not causes:
        return str(document['verdict'])
    if set(causes) != {*off, *filter(None, [effect])}:
        return 'part' if set(causes) < {*off, effect} else 'wrong name'
    change = {name: causes[name]['change'] for name in off}
    held = all(
        abs(change[name]['value'] - true) < 3.0 * change[name]['std_error']
        for name, true in off.items()
    )
    return 'right' if held else 'size'


def main() -> int:
    """Run the trials that are not there yet, and print the table."""
    parser = parser_of('axis_campaign', __doc__)
    parser.add_argument('--guesses', type=int, default=6, help='trials with a guessed friction')
    parser.add_argument('--lossy', action='store_true', help='samples are lost and stamped late')
    given = parser.parse_args()
    plan = [('single', effect, k) for effect in CATALOGUE for k in range(given.singles)]
    plan += [('null', '', k) for k in range(given.nulls)]
    plan += [('guess', 'stribeck' if k % 2 else '', k) for k in range(given.guesses)]
    plan += [('outside', effect, k) for effect in OUTSIDE for k in range(given.outside)]
    rows = kept_trials(plan, partial(trial, given.seed, lossy=given.lossy), given.out)
    print('\n'.join(outcomes(rows)))
    counted = sum(len(row.get('truly_off') or []) for row in rows)
    print(f'\nNominal parameters truly beyond the tolerance, and named so: {counted}.')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
