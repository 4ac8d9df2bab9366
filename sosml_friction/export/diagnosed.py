# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis of an MJCF, back in MuJoCo: the extended model as MJCF, and what it is worth."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.bag_diagnosis import BagDiagnosis
from sosml_friction.diagnosis.decision.forward_gain import HORIZON_S
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.extended_model.simulator_gain import SimulatorGain
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.holding import CONSTANTS
from sosml_friction.export.common.motion import KnownMotion
from sosml_friction.export.mjcf import MjcfTarget
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.mujoco.engine import compiled
from sosml_friction.mujoco.friction import Friction
from sosml_friction.mujoco.replay import Replay
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare

#: Windows that are simulated, at most: the standard error falls with their root.
_WINDOWS = 60
#: A row that sees a reversal by more than this share of the most that one can be seen by is left
#: out.
_TOUCHED = 0.05


def trust_of_a_simulation(said: Mapping[str, float]) -> dict[str, float]:
    """Return by how much of itself each group may be off: friction of a simulator is a guess."""
    return {'friction': inf, **said}


def with_simulator(found: BagDiagnosis, mjcf: Path) -> BagDiagnosis:
    """
    Return a diagnosis with its gain in MuJoCo, and the extended model in ``simulator.document``.

    On its ``holdout``, or on what was diagnosed where there is none. Effort is that of inverse
    dynamics with friction, along the smoothed motion; position is simulated forward.
    """
    diagnosis, nominal, holdout = found.diagnosis, found.nominal, found.holdout
    laboratory = diagnosis.laboratory
    if laboratory is None:
        return found
    stretches: Sequence[Signals] = laboratory.signals
    if holdout is not None:
        log = CleanSamples.of(holdout.select(laboratory.robot.names)).log
        settings = replace(DiagnosisSettings(), band=diagnosis.band_hz)
        stretches = laboratory.seen_alike(
            prepare([log], nominal, laboratory.robot, settings, laboratory.signals[0].scales)
        )
    extended = extended_model(nominal, diagnosis, found.provenance)
    on = (found.provenance['holdout'] or found.provenance['bags'][0])['bag']
    motion = KnownMotion(f'the motion in {on}', tuple(stretches))
    target, unwritten = MjcfTarget(motion, mjcf, nominal), list[str]()
    try:
        document = target.text(extended)
    except ConfigurationError as error:
        # MuJoCo asks more of a body than that it has a mass.
        target, unwritten = MjcfTarget(motion, mjcf), [f'the changed bodies ({error})']
        document = target.text(extended)
    names = nominal.joint_names
    before = Replay(compiled(mjcf), names, nominal.locked)
    model = compiled(document)
    friction = Friction(model)
    after = Replay(model, names, nominal.locked, friction)
    inverse = [_inverse(replay, stretches) for replay in (before, after)]
    forward = [_forward(replay, stretches) for replay in (before, after)]
    gain = SimulatorGain(
        'MuJoCo',
        on,
        holdout is None,
        {x: (float(a), float(b)) for x, a, b in zip(names, *inverse, strict=True)},
        {x: (float(a), float(b)) for x, a, b in zip(names, *forward, strict=True)},
        {x: stretches[0].length_unit(i) for i, x in enumerate(names)},
        _friction(nominal, extended),
        HORIZON_S,
        target.file,
        document,
        [*friction.left_out, *unwritten],
    )
    sentence = f'{diagnosis.sentence} {gain.sentence}'
    return replace(found, diagnosis=replace(diagnosis, simulator=gain, sentence=sentence))


def _friction(
    before: RobotModelFile, after: RobotModelFile
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return the constants of friction before, 0 where there was none, and after."""
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for name, joint in after.joints.items():
        old = before.joints[name].friction
        for key in CONSTANTS if joint.friction is not None else ():
            assert joint.friction is not None
            was = old.parameters[key].value if old is not None else 0.0
            found.setdefault(name, {})[key] = (was, joint.friction.parameters[key].value)
    return found


def _inverse(replay: Replay, stretches: Sequence[Signals]) -> FloatArray:
    """
    Return the error of effort as a share of the measured effort (n,) [%], in the band.

    Away from reversals, where friction is what holds.
    """
    wrong, whole, away = [], [], []
    for s in stretches:
        expected = replay.effort(s.time, s.q, s.v, s.a)
        wrong.append(s.in_band(s.tau - expected - s.shaken))
        whole.append(s.in_band(s.tau))
        # While a joint turns around it sticks: what it takes then is no function of its motion.
        turns = np.zeros_like(s.v)
        turns[1:] = np.diff(np.sign(s.v), axis=0) != 0.0
        peak = 2.0 * s.band.cutoff * s.band.step
        away.append(np.abs(s.band.apply(turns)) < _TOUCHED * peak)
    clear = np.concatenate(away)
    sizes = [
        np.sqrt(np.sum(np.concatenate(x) ** 2 * clear, axis=0) / np.maximum(clear.sum(axis=0), 1))
        for x in (wrong, whole)
    ]
    with np.errstate(all='ignore'):
        # Of a joint without effort nothing is known.
        return np.where(sizes[1] > 0.0, 100.0 * sizes[0] / sizes[1], np.nan)


def _forward(replay: Replay, stretches: Sequence[Signals]) -> FloatArray:
    """Return the root mean square error of position (n,) over windows that do not overlap."""
    squares = []
    whole = sum(len(s.q) for s in stretches)
    for s in stretches:
        samples = round(HORIZON_S / s.band.step)
        edge = s.band.half
        room = len(s.q) - 2 * edge - samples
        count = min(round(_WINDOWS * len(s.q) / whole), room // samples)
        for at in np.linspace(edge, edge + room, max(count, 0)).astype(int):
            rows = slice(at, at + samples)
            q = replay.motion(s.q[at], s.v[at], s.time[rows], s.tau[rows])
            squares.append(np.mean((q - s.q[rows]) ** 2, axis=0))
    if not squares:
        return np.full(stretches[0].robot.n, np.nan)
    result = np.sqrt(np.mean(squares, axis=0))
    result[list(stretches[0].silent)] = np.nan
    return np.asarray(result)
