# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What joints leave where they turn around, on two plants: the origin of when one sticks.

    python -m validation.turns --seed 1

MuJoCo's arm without an effect, which sticks for 0.03 to 0.15 s, read at low rates; the arm of
``campaign`` along ``rich`` without an effect, and with those that act at reversals in their joint.
Of each joint, as :class:`~sosml_friction.regression.turn_residual.TurnResidual`: smallest, median
and largest. What one candidate explains is asked where enough is left.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.band_rows import BandRows
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare, with_rests
from sosml_friction.regression.turn_residual import TurnResidual
from sosml_friction.report.common.table import print_table, terminal_table
from validation.leftovers import mujoco_arms
from validation.plan import make_plan
from validation.trial import JOINTS, build, nominal_model

#: Samples of MuJoCo's arm, recorded at 500 Hz, of which one is kept.
THINNED = (6, 8, 10, 20)
EFFECTS = ('backlash', 'joint_elasticity', 'presliding_hysteresis')
#: What is recorded, a model, and the joints that are asked.
Asked = tuple[str, JointLog, RobotModelFile, tuple[int, ...]]


def recordings(seed: int, count: int) -> Iterator[Asked]:
    """Yield recordings of both plants, ``count`` of each kind."""
    for log, model, _ in mujoco_arms(seed, count):
        for n in THINNED:
            kind = f'arm of MuJoCo, {500 / n:.0f} Hz'
            yield kind, log.rows(np.arange(0, len(log), n)), model, (0, 1)
    plan = [spec for spec in make_plan(seed, 60 * count) if spec.motion == 'rich']
    for effect in (None, *EFFECTS):
        kind = 'single' if effect else 'null'
        specs = [spec for spec in plan if (spec.kind, spec.effect) == (kind, effect)]
        for spec in specs[:count]:
            trial = build(spec)
            own = tuple(JOINTS.index(truth.joint) for truth in trial.truths)
            yield f'arm, {effect or "no effect"}', trial.log, nominal_model(), own or (0, 1)


def residuals(log: JointLog, model: RobotModelFile, joints: tuple[int, ...]) -> list[TurnResidual]:
    """Return what is left of joints where they turn around, of those that tell it."""
    robot, settings = model.make_robot(), DiagnosisSettings()
    signals = tuple(prepare([log], model, robot, settings))
    rows = BandRows.make(signals, make_library(), settings)
    turning = with_rests(signals, turns=range(robot.n))
    found = [TurnResidual.of(rows, i, turning) for i in joints]
    return [own for own in found if own is not None]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog='python -m validation.turns', description=__doc__)
    parser.add_argument('--seed', type=int, required=True, help='of all that is drawn')
    parser.add_argument('--recordings', type=int, default=6, help='of each kind')
    given = parser.parse_args()
    kinds: dict[str, list[TurnResidual]] = {}
    for kind, log, model, joints in recordings(given.seed, given.recordings):
        kinds.setdefault(kind, []).extend(residuals(log, model, joints))
    rows = []
    for kind, found in kinds.items():
        asked = [own for own in found if own.least < own.whole]
        columns = [
            [own.whole for own in found],
            [own.usual for own in found],
            [own.explained for own in asked],
        ]
        told = [f'{min(x):.2f} {np.median(x):.2f} {max(x):.2f}' if x else '-' for x in columns]
        rows.append((kind, f'{len(found)}', *told, f'{sum(own.sticks for own in found)}'))
    heads = {
        'recordings': '', 'joints': 'n', 'all turns': 'n', 'but two': 'n', 'explained': 'n',
        'stick': 'n',
    }  # fmt: skip
    print_table(terminal_table(heads, rows))


if __name__ == '__main__':
    main()
