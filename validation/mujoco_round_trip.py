# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What is left of a model in MuJoCo: its effort beside that of the package's plant, along T1.

    python -m validation.mujoco_round_trip [--plateau 3]

A pendulum with Stribeck friction under PD control with feed-forward of inertia and gravity, the
same controller in both. The error is that of the commanded effort, as a share of friction, both
root mean squares over the motion. Least is what the best constants leave that a search in
MuJoCo itself finds, which begins at those that are written. Creep is the speed under half of
Coulomb friction at rest. The last columns are the time of a step, the module included.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from scipy.optimize import minimize

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.export.common.motion import recorded_motion
from sosml_friction.export.mjcf import MjcfTarget
from sosml_friction.model.known_terms import known_terms, model_friction
from sosml_friction.model.model_folder import (
    EffectTerm,
    FrictionParameters,
    JointModel,
    RobotModelFile,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.mujoco import apply_friction
from sosml_friction.simulation.forward_drive import Drive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import Start, simulate

#: Friction and body of the bench [SI]; sampling of the controller [s]; displacement over which
#: friction of the plant builds up [rad].
C, B, S, V_S, MASS, LENGTH = 0.8, 0.35, 0.5, 0.03, 2.6, 0.25
PERIOD, STICK = 2e-3, 2e-6
KP, KD = 400.0, 25.0
T1 = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7)
#: T1's own plateau [s].
PLATEAU = 0.8


class RoundTrip(NamedTuple):
    """
    Hold errors along the motion, as shares of friction, and what was measured beside them.

    ``slow`` is the share of the squared error of constants that is made below ``V_S``, and
    ``slow_time`` the share of time that is spent there.
    """

    stated: float
    shares: dict[str, float]
    least: float
    slow: float
    slow_time: float
    creep: float
    cost_us: dict[str, float]


def bench_model(effects: tuple[EffectTerm, ...] = ()) -> RobotModelFile:
    """Return the pendulum with Stribeck friction."""
    values = {'coulomb': (C, 'Nm'), 'viscous': (B, 'Nm s/rad'), 'stribeck': (S, 'Nm'),
              'stribeck_velocity': (V_S, 'rad/s'), 'bias': (0.0, 'Nm')}  # fmt: skip
    parameters = {name: Parameter(x, unit, 0.01 * x) for name, (x, unit) in values.items()}
    friction = FrictionParameters('stribeck', 0.0, parameters)
    bare = pendulum_model(MASS, LENGTH, 0.002, 0.005)
    joints = {'joint': JointModel(bare.joints['joint'].armature, friction)}
    return RobotModelFile('bench', joints, bare.urdf, effects=effects)


def reference(
    speeds: tuple[float, ...], plateau_s: float = PLATEAU
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, speed and acceleration (N,) of the ladder."""
    plan = speed_ladder({'joint': 0.0}, {'joint': 0.5}, speeds, plateau_s)
    t = np.arange(0.0, plan.duration, PERIOD)
    spline = plan.spline()
    return spline(t, 0)[:, 0], spline(t, 1)[:, 0], spline(t, 2)[:, 0]


class _Controlled(Drive):
    """PD control of the position and its difference, with feed-forward, as each plant has it."""

    def __init__(self, model: RobotModelFile, motion: tuple[np.ndarray, ...]) -> None:
        robot = model.make_robot()
        self.motion = motion
        self.ahead = [robot.inverse_dynamics(*np.array(x)[:, None])[0]
                      for x in zip(*motion, strict=True)]  # fmt: skip
        self.last = float(motion[0][0])
        self.efforts: list[float] = []

    def begin(self, k: int, q: np.ndarray) -> None:
        now = float(np.ravel(q)[0])
        error = KP * (self.motion[0][k] - now)
        error += KD * (self.motion[1][k] - (now - self.last) / PERIOD)
        self.last = now
        self.efforts.append(float(self.ahead[k] + error))

    def torque(self, begin: float, end: float) -> tuple[np.ndarray, np.ndarray]:
        held = np.array([[self.efforts[-1]]])
        return held, held


def in_plant(model: RobotModelFile, motion: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """Return position, speed and command (N,) of the package's simulation, which sticks."""
    robot = model.make_robot()
    terms = [known.simulated(robot) for known in known_terms(model)]
    plant = ForwardModel(robot, model_friction(model), np.array([STICK]), terms)
    drive = _Controlled(model, motion)
    q = motion[0][:, None]
    nothing = np.zeros((1, 1))
    start = Start(q[:1], nothing, nothing, nothing, q, np.zeros(1, dtype=np.int64),
                  np.arange(len(q)) * PERIOD, np.full_like(q, np.nan))  # fmt: skip
    found = simulate(plant, start, drive, PERIOD, len(q), np.array([10.0]))
    return found.q[0, :-1, 0], found.v[0, :-1, 0], np.array(drive.efforts)


def in_mujoco(
    model: RobotModelFile,
    motion: tuple[np.ndarray, ...],
    xml: str,
    module: bool,
    h: float,
    constants: np.ndarray | None = None,
) -> tuple[np.ndarray, float]:
    """Return the command (N,) in MuJoCo, and the time of a step [us]; None: constants of xml."""
    m = mujoco.MjModel.from_xml_string(xml)
    if constants is not None:
        m.dof_frictionloss[0], m.dof_damping[0] = constants
    d = mujoco.MjData(m)
    d.qpos[0] = motion[0][0]
    drive = _Controlled(model, motion)
    many, spent = round(PERIOD / h), 0.0
    for k in range(len(motion[0]) - 1):
        drive.begin(k, d.qpos)
        start = time.process_time()
        for _ in range(many):
            d.qfrc_applied[0] = 0.0
            if module:
                apply_friction(m, d)
            d.qfrc_applied[0] += drive.efforts[-1]
            mujoco.mj_step(m, d)
        spent += time.process_time() - start
    return np.array(drive.efforts), 1e6 * spent / (many * len(motion[0]))


def creep(xml: str) -> float:
    """Return the speed [rad/s] under half of Coulomb friction, with the module."""
    m = mujoco.MjModel.from_xml_string(xml)
    m.opt.gravity[:] = 0.0
    d = mujoco.MjData(m)
    for _ in range(500):
        apply_friction(m, d)
        d.qfrc_applied[0] += 0.5 * C
        mujoco.mj_step(m, d)
    return abs(float(d.qvel[0]))


def with_step(xml: str, h: float) -> str:
    """Return the MJCF for another time step; the constraint follows it."""
    if h == PERIOD:
        return xml
    text = xml.replace('solreffriction="0.004 1"', f'solreffriction="{2.0 * h!r} 1"')
    return text.replace('<worldbody>', f'<option timestep="{h!r}"/><worldbody>', 1)


def round_trip(
    h: float = PERIOD,
    speeds: tuple[float, ...] = T1,
    plateau_s: float = PLATEAU,
    rounds: int = 40,
) -> RoundTrip:
    """
    Return the errors of MuJoCo with the module, and with constants alone.

    :param rounds: runs of MuJoCo in the search of the best constants, beside those stated.
    """
    model = bench_model()
    motion = reference(speeds, plateau_s)
    q, v, u = in_plant(model, motion)
    robot = model.make_robot()
    a = np.gradient(v, PERIOD)
    friction = u - [robot.inverse_dynamics(*np.array(x)[:, None])[0]
                    for x in zip(q, v, a, strict=True)]  # fmt: skip
    size = float(np.sqrt(np.mean(friction**2)))
    t = np.rint(np.arange(len(q)) * PERIOD * 1e9).astype(np.int64)
    log = JointLog(('joint',), t, q[:, None], v[:, None], u[:, None])
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        write_joint_log(log, bag, model.urdf)
        target = MjcfTarget(recorded_motion(model, bag))
    held: Any = target.held(model)['joint']
    xml = with_step(target.text(model), h)

    def missing(module: bool, constants: np.ndarray | None = None) -> tuple[np.ndarray, float]:
        found, cost = in_mujoco(model, motion, xml, module, h, constants)
        return (found - u) / size, cost

    (alone, alone_us), (whole, whole_us) = missing(False), missing(True)
    shares = {name: float(np.sqrt(np.mean(x**2)))
              for name, x in (('constants', alone), ('module', whole))}  # fmt: skip
    start = np.array([held.constants[name] for name in ('coulomb', 'viscous')])
    best = minimize(
        lambda x: float(np.sqrt(np.mean(missing(False, np.abs(x))[0] ** 2))), start,
        method='Nelder-Mead',
        options={'initial_simplex': start + 0.05 * np.array([[0, 0], [1, 0], [0, 1]]),
                 'maxfev': rounds},
    )  # fmt: skip
    slow = np.abs(motion[1][: len(alone)]) < V_S
    at_slow = float((alone[slow] ** 2).sum() / (alone**2).sum())
    cost = {'constants': alone_us, 'module': whole_us}
    return RoundTrip(held.error / size, shares, float(best.fun), at_slow, float(slow.mean()),
                     creep(xml), cost)  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m validation.mujoco_round_trip', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument('--plateau', type=float, default=PLATEAU, help='of T1 [s]; default: 0.8')
    plateau_s = parser.parse_args().plateau
    print(f'MuJoCo {mujoco.__version__}, T1 with plateaus of {plateau_s:g} s')
    head = ['step ms', 'stated', 'constants', 'least', 'module', 'creep rad/s', 'us constants',
            'us module']  # fmt: skip
    print(f'| {" | ".join(head)} |')
    print(f'|{"---|" * len(head)}')
    for h in (1e-3, 2e-3):
        one = round_trip(h, plateau_s=plateau_s)
        shares = (one.stated, one.shares['constants'], one.least, one.shares['module'])
        row = [f'{1e3 * h:g}', *(f'{100 * x:.2f} %' for x in shares), f'{one.creep:.1e}']
        row += [f'{one.cost_us[name]:.1f}' for name in ('constants', 'module')]
        print(f'| {" | ".join(row)} |')
    print(
        f'Below v_s, {V_S:g} rad/s: {100 * one.slow_time:.0f} % of the time and '
        f'{100 * one.slow:.0f} % of the squared error of constants.'
    )
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
