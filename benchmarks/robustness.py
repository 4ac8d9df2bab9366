# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What is left of an observer's advantage where its assumptions do not hold.

Every observer has one gain set, by recipe, for all of it: a friction jump of 2.2 and 1.1 Nm every
second, measured by the study's 16-bit encoder. The plant, its friction and the motion change; what
a Kalman observer with the law in its state believes does not. RMSE of the shoulder in mNm after
the first half second, mean over seeds. Run with ``make robustness`` (a minute on two cores).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.laws import make_friction_law
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.recipe import gains_for_conditions
from sosml_friction.observers.registry import OBSERVERS, make_observer
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.table import print_table, terminal_table
from sosml_friction.study.condition import encoder_noise, observe
from sosml_friction.study.motion import POSTURE, Reference, reversal, slow
from sosml_friction.study.parallel import run_all, workers
from sosml_friction.study.plant import (
    PERIOD,
    SMOOTHING_VELOCITY,
    TRUTH,
    simulate,
    study_robot,
)

SEEDS, BITS = range(1, 6), 16
#: The explicit step is there to be compared with SOSML's own, in the study.
NAMES = tuple(name for name in OBSERVERS if name != 'sosml_explicit')
FloatArray = NDArray[np.float64]


class World(NamedTuple):
    """Say what is different: motion and its duration [s], friction of joint 1, extra torque."""

    name: str
    motion: Callable[[float], Reference]
    duration: float = 12.0
    friction: tuple[tuple[str, float], ...] = ()
    disturbance: Callable[[float, FloatArray], FloatArray] | None = None


def swing(amplitude: float, hertz: float, elbow: float, t: float) -> Reference:
    """Return sinusoids of joint 1, and of joint 2 at 0.7 of the frequency."""
    size, w = np.array([amplitude, elbow]), 2.0 * np.pi * hertz * np.array([1.0, 0.7])
    return Reference(
        POSTURE + size * np.sin(w * t), size * w * np.cos(w * t), -size * w**2 * np.sin(w * t)
    )


def push(t: float, q: FloatArray) -> FloatArray:
    """Return a hand that pushes joint 1 with 2 Nm for a second and a half."""
    return np.array([2.0 if 3.0 < t < 4.5 else 0.0, 0.0])


def cogging(t: float, q: FloatArray) -> FloatArray:
    """Return 0.1 Nm of ripple, 60 periods in 2 pi."""
    return np.array([0.1 * np.sin(60.0 * q[0]), 0.0])


WORLDS = (
    World('slow', slow),
    World('reversal', reversal),
    World('reversal, 2 Hz', partial(swing, 0.15, 2.0, 0.0)),
    World('reversal, 0.1 Hz', partial(swing, 0.2, 0.1, 0.0), 20.0),
    World('both joints move', partial(swing, 0.35, 0.5, 0.5)),
    World('reversal, no Stribeck', reversal, friction=(('stribeck', 0.0),)),
    World('reversal, knee 0.1 rad/s', reversal, friction=(('stribeck_velocity', 0.1),)),
    World('reversal, C +-20 % by direction', reversal, friction=(('bias', 0.16),)),
    World('slow, cogging 0.1 Nm', slow, disturbance=cogging),
    World('reversal, cogging 0.1 Nm', reversal, disturbance=cogging),
    World('slow, pushed with 2 Nm', slow, disturbance=push),
    World('reversal, pushed with 2 Nm', reversal, disturbance=push),
)


def errors(world: World) -> dict[str, tuple[float, float]]:
    """Return mean and standard deviation of the RMSE [mNm] by observer."""
    robot = study_robot()
    laws = [
        make_friction_law(
            'stribeck', {**truth, **dict(world.friction if i == 0 else ())}, SMOOTHING_VELOCITY
        )
        for i, truth in enumerate(TRUTH)
    ]
    run = simulate(robot, world.motion, world.duration, laws=laws, disturbance=world.disturbance)
    noise = encoder_noise(BITS)
    conditions = Conditions.of(
        robot,
        POSTURE,
        [noise] * 2,
        [np.sqrt(2.0) * noise / PERIOD] * 2,
        [2.2, 1.1],
        [1.0, 1.0],
        [1.1, 0.5],
    )
    gains = gains_for_conditions(conditions)
    observations = observe(run, robot, 'noise', BITS, SEEDS)
    found = {}
    for name in NAMES:
        rmse = []
        for observation in observations:
            error = observation.estimate(make_observer(name, gains[name])) - observation.friction
            rmse.append(1e3 * np.sqrt(np.mean(error[observation.time > 0.5, 0] ** 2)))
        found[name] = (float(np.mean(rmse)), float(np.std(rmse, ddof=1)))
    return found


def main() -> None:
    """Print the table."""
    with workers(2) as pool:
        results = run_all(pool, errors, WORLDS)
    print(
        f'RMSE of the shoulder [mNm], one gain set by recipe: mean (std) over {len(SEEDS)} seeds'
    )
    half = (len(NAMES) + 1) // 2
    for names in (NAMES[:half], NAMES[half:]):
        columns = {'motion and plant': 'w'}
        columns |= {observer_label(name).replace(' ', '\n'): 'n w' for name in names}
        rows = [
            [world.name, *(f'{found[n][0]:.0f} ({found[n][1]:.0f})' for n in names)]
            for world, found in zip(WORLDS, results, strict=True)
        ]
        print_table(terminal_table(columns, rows))


if __name__ == '__main__':
    main()
