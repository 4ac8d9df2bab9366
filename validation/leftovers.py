# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What curves and ripples explain of recordings without an effect, on three plants: floors' origin.

    python -m validation.leftovers --seed 1

The plants are those of ``axis_campaign``, ``campaign`` and ``mujoco_campaign``. Of each joint: the
energy of its largest curve and of its largest further curve (of two quantities, or of time back
and forth) as a share of that of noise, the share of what is left that all of its curves explain
together, and the energy of its largest ripple, of its bursts and of friction by the next joint's
position or speed over their floors (:mod:`sosml_friction.diagnosis.decision.remainder`); the
largest mean of what is left, in usual ones (:mod:`sosml_friction.regression.contacts`).
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.decision.leftover import AT_ONCE, FRICTION_BY
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.export.diagnosed import trust_of_a_simulation
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.mujoco.reading import read_mjcf
from sosml_friction.regression.curves.axes import BACK_AND_FORTH, NEIGHBOURS
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.common.table import print_table, terminal_table
from validation import axis_campaign, axis_plant, mujoco_plant
from validation.motion import reference
from validation.plan import make_plan
from validation.trial import build, nominal_model

#: A recording, its nominal model and how it is looked at.
Null = tuple[JointLog, RobotModelFile, DiagnosisSettings]


def axes(seed: int, count: int) -> Iterator[Null]:
    """Yield recordings of the linear axis, with double noise in every second."""
    nominal = axis_plant.Axis()
    model = axis_campaign.model(nominal.coulomb, nominal.viscous)
    motion = axis_plant.moves(axis_campaign.MOTION, axis_campaign.LONG_S)
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        axis = axis_plant.make_axis(rng)
        log = axis_campaign.recorded(axis, motion, rng, 1.0 + k % 2)
        yield log, model, DiagnosisSettings()


def arms(seed: int, count: int) -> Iterator[Null]:
    """Yield recordings of the arm along its motions, with noise of all kinds."""
    # There are four nulls in a plan for five single effects.
    nulls = [spec for spec in make_plan(seed, 5 * count // 4 + 1) if spec.kind == 'null']
    for spec in nulls[:count]:
        yield build(spec).log, nominal_model(), DiagnosisSettings()


def mujoco_arms(seed: int, count: int) -> Iterator[Null]:
    """Yield recordings of MuJoCo's arm, with double noise in every second."""
    settings = DiagnosisSettings(trust=trust_of_a_simulation({}))
    nominal = mujoco_plant.Arm()
    with tempfile.TemporaryDirectory() as folder:
        mjcf = Path(folder) / 'robot.xml'
        mjcf.write_text(nominal.xml((nominal.coulomb, nominal.viscous)))
        model = read_mjcf(mjcf)
        for k in range(count):
            rng = np.random.default_rng([seed, k])
            arm = mujoco_plant.make_arm(rng)
            yield mujoco_plant.simulate(arm, reference('rich'), rng, 1.0 + k % 2), model, settings


PLANTS: dict[str, Callable[[int, int], Iterator[Null]]] = {
    'linear axis': axes,
    'arm': arms,
    'arm of MuJoCo': mujoco_arms,
}


#: Friction that no cause of the catalogue is.
_BY_THE_NEXT = tuple(f'{FRICTION_BY}{axis}' for axis in NEIGHBOURS)
HEADS = {
    'plant': '', 'recordings': 'n', 'largest curve': 'n', 'largest further curve': 'n',
    'largest ripple': 'n', 'bursts': 'n', 'all together': 'n', 'friction by the next joint': 'n',
    'largest mean': 'n',
}  # fmt: skip


def largest(found: Diagnosis) -> tuple[float, ...]:
    """Return the largest of all joints, in the order of :data:`HEADS`."""
    assert found.selection is not None
    assert found.laboratory is not None
    left, rows = found.selection.remainder, found.laboratory.known
    curves = [x for x in left.found if x.form == 'free curve' and not x.together]
    further = [x for x in curves if x.axis.endswith((AT_ONCE, BACK_AND_FORTH))]
    curves = [x for x in curves if x not in further]
    ripples = [x for x in left.found if x.period]
    bursts = [x for x in left.found if x.form == 'bursts']
    curve, second = (
        max((x.energy / rows[x.joint] for x in some), default=0.0) for some in (curves, further)
    )
    beside = [x for x in curves if x.axis in _BY_THE_NEXT]
    ripple, burst, beside = (
        max((x.energy / x.floor for x in some), default=0.0) for some in (ripples, bursts, beside)
    )
    mean = float(found.laboratory.contacts.largest.max())
    return curve, second, ripple, burst, float(left.explained.max()), beside, mean


def main() -> None:
    """Print the largest of each plant."""
    parser = argparse.ArgumentParser(prog='python -m validation.leftovers', description=__doc__)
    parser.add_argument('--seed', type=int, required=True, help='of all that is drawn')
    parser.add_argument('--recordings', type=int, default=14, help='of each plant')
    given = parser.parse_args()
    rows = []
    for name, nulls in PLANTS.items():
        each = [
            largest(diagnose([log], model, settings=settings))
            for log, model, settings in nulls(given.seed, given.recordings)
        ]
        rows.append((name, f'{len(each)}', *(f'{x:.4f}' for x in np.max(each, axis=0))))
    print_table(terminal_table(HEADS, rows))


if __name__ == '__main__':
    main()
