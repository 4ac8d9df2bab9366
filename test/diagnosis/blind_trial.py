# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Draw a hidden effect from a seed, and hide it: what the blind tests ask the diagnosis for."""

from __future__ import annotations

from dataclasses import dataclass

import blind_plant as bp
import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.motion import begin_motion
from sosml_friction.identification.multisine import MultisineSettings, add_multisine
from sosml_friction.identification.rich import rich
from sosml_friction.identification.speed_ladder import speed_ladder
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

JOINTS = ('shoulder', 'elbow')
#: Typical size of each hidden effect, shoulder and elbow.
TYPICAL = {
    'coulomb': (0.24, 0.045), 'viscous': (0.14, 0.024), 'stribeck': (0.32, 0.06),
    'asymmetric_friction': (0.10, 0.02), 'load_dependent_friction': (0.06, 0.06),
    'position_dependent_friction': (0.20, 0.04), 'cogging': (0.12, 0.03),
    'presliding_hysteresis': (3e-3, 3e-3), 'joint_elasticity': (1500.0, 500.0),
    'backlash': (4e-3, 4e-3), 'effort_scale': (0.08, 0.08), 'effort_saturation': (0.06, 0.06),
    'effort_bias': (0.15, 0.06), 'effort_delay': (4e-3, 4e-3), 'gravity': (0.10, 0.10),
    'gravity_tilt': (0.06, 0.06), 'inertia': (0.05, 0.012), 'payload': (0.25, 0.25),
    'joint_coupling': (0.08, 0.08), 'spring': (0.4, 0.15), 'external_contact': (1.5, 0.6),
    'encoder_eccentricity': (4e-3, 4e-3), 'thermal_drift': (0.35, 0.35),
}  # fmt: skip
OUTSIDE = ('root_friction', 'quadratic_drag')
GLOBAL = ('effort_delay', 'gravity_tilt', 'payload')


@dataclass
class Trial:
    """Hold a hidden effect and what it left in the data."""

    effect: str
    joint: str
    size: float
    log: JointLog


def nominal_model() -> RobotModelFile:
    """Return the exoskeleton with the friction the plant has where nothing is hidden."""
    shipped = read_model(share_directory() / 'config/exoskeleton')
    joints = {}
    for i, name in enumerate(JOINTS):
        parameters = {
            'coulomb': Parameter(float(bp.COULOMB[i]), 'Nm'),
            'viscous': Parameter(float(bp.VISCOUS[i]), 'Nm s/rad'),
            'bias': Parameter(0.0, 'Nm'),
        }
        friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
        joints[name] = JointModel(shipped.joints[name].armature, friction)
    return RobotModelFile('blind', joints, shipped.urdf)


def reference(name: str = 'rich', duration: float | None = None):
    """Return position, speed and acceleration (N, 2) at 500 Hz of a trajectory."""
    start = dict(zip(JOINTS, (-0.9, 0.9), strict=True))
    if name == 'rich':
        sines = MultisineSettings(
            amplitude=0.45, peak_speed=2.0, peak_acceleration=9.0, band=(0.1, 1.5), period_s=16.0
        )
        plan = rich(
            start, start, offset=(-0.5, 0.5), speeds=(0.05, 0.12, 0.3, 0.7, 1.4), plateau_s=0.7,
            ramp_s=0.25, amplitude=0.25, frequency=0.5, cycles=8.0, decay=0.04, settings=sines,
            top_speed=1.2,
        )  # fmt: skip
    elif name == 'multisine':
        sines = MultisineSettings(
            amplitude=0.5, peak_speed=1.5, peak_acceleration=8.0, period_s=20.0, periods=6
        )
        motion, _, factor = begin_motion('multisine', start, start, (1.0,))
        plan = add_multisine(motion, sines, factor).build()
    else:
        plan = speed_ladder(start, start, (0.05, 0.1, 0.2, 0.4), plateau_s=1.2, ramp_s=0.3)
    t = np.arange(0.0, duration or plan.duration, bp.PERIOD)
    spline = plan.spline()
    turn = np.mod(t, plan.duration)
    q, v = spline(turn), spline(turn, 1)
    return q, v, np.gradient(v, bp.PERIOD, axis=0)


def nuisance(rng: np.random.Generator, largest: float = 0.03) -> bp.Plant:
    """Return a plant whose every nominal parameter is off by 1 to 3 %."""

    def off(shape=()):
        return 1.0 + rng.uniform(min(0.01, largest), largest, shape) * rng.choice([-1, 1], shape)

    plant = bp.Plant()
    plant.first *= off()
    plant.second *= off()
    plant.inertia = (plant.inertia[0] * off(), plant.inertia[1] * off())
    for name in ('coulomb', 'viscous', 'armature'):
        plant.joint[name] = plant.joint[name] * off(2)
    return plant


def hide(plant: bp.Plant, effect: str, i: int, scale: float, rng: np.random.Generator,
         duration: float) -> float:  # fmt: skip
    """Put an effect of ``scale`` times its typical size into joint i, and return its size."""
    sign = float(rng.choice([-1.0, 1.0]))
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    size = scale * (TYPICAL[effect][i] if effect in TYPICAL else 1.0)
    joint = plant.joint
    if effect == 'coulomb':
        joint['coulomb'][i] += sign * min(size, 0.7 * bp.COULOMB[i])
    elif effect == 'viscous':
        joint['viscous'][i] += sign * min(size, 0.7 * bp.VISCOUS[i])
    elif effect == 'stribeck':
        joint['stribeck'][i] = size
        joint['stribeck_velocity'][i] = rng.uniform(0.05, 0.25)
        joint['stribeck_exponent'][i] = rng.uniform(0.8, 1.8)
    elif effect == 'asymmetric_friction':
        joint['asymmetry_viscous'][i] = sign * size
    elif effect == 'load_dependent_friction':
        joint['load'][i] = size
    elif effect == 'position_dependent_friction':
        joint['position'][i], joint['position_phase'][i] = size, phase
        joint['position_cycles'][i] = rng.choice([1.0, 2.0])
    elif effect == 'cogging':
        joint['cogging'][i], joint['cogging_phase'][i] = size, phase
        joint['cogging_cycles'][i] = rng.uniform(12.0, 100.0)
    elif effect == 'presliding_hysteresis':
        joint['slip'][i] = size
    elif effect == 'joint_elasticity':
        plant.two_mass = True
        joint['stiffness'][i] = TYPICAL[effect][i] / scale
    elif effect == 'backlash':
        plant.two_mass = True
        joint['gap'][i], joint['stiffness'][i] = size, 1e4
    elif effect == 'effort_scale':
        plant.scale[i] += sign * size
    elif effect == 'effort_saturation':
        plant.saturation[i] = (9.0, 2.5)[i] / np.sqrt(size)
    elif effect == 'effort_bias':
        plant.bias[i] = sign * size
    elif effect == 'effort_delay':
        plant.delay = size
    elif effect == 'gravity':
        if i == 0:
            plant.first *= 1.0 + sign * 2.0 * size
        else:
            plant.second *= 1.0 + sign * size
    elif effect == 'gravity_tilt':
        plant.tilt = sign * size
    elif effect == 'inertia':
        joint['armature'][i] = max(joint['armature'][i] + size, 1e-3)
    elif effect == 'payload':
        plant.payload, plant.payload_distance = size, rng.uniform(0.18, 0.30)
    elif effect == 'joint_coupling':
        plant.coupling = sign * size
    elif effect == 'spring':
        joint['spring'][i], joint['spring_zero'][i] = size, rng.uniform(-1.0, 1.0)
    elif effect == 'external_contact':
        for start in np.sort(rng.uniform(10.0, duration - 10.0, 4)):
            push = float(rng.choice([-1.0, 1.0]) * size)
            plant.contacts.append((i, float(start), float(rng.uniform(0.3, 1.2)), push))
    elif effect == 'encoder_eccentricity':
        plant.eccentricity[i], plant.eccentricity_phase[i] = size, phase
    elif effect == 'thermal_drift':
        joint['warm_viscous'][i], joint['warm_coulomb'][i] = -size, -0.4 * size
        joint['warm_time'][i] = duration * rng.uniform(0.25, 0.6)
    elif effect == 'root_friction':
        joint['power_gain'][i], joint['power'][i] = size * 0.4 * bp.COULOMB[i], 0.5
    elif effect == 'quadratic_drag':
        joint['quadratic'][i] = size * 0.3 * bp.VISCOUS[i]
    else:
        raise ValueError(effect)
    return size


def make_trial(seed: int, effect: str | None = None, trajectory: str = 'rich',
               scale: float | None = None, joint: int | None = None, noise: float = 1.0,
               duration: float | None = None, second: str | None = None) -> Trial:  # fmt: skip
    """Return a trial; ``effect`` None hides nothing, ``draw`` one at random."""
    rng = np.random.default_rng([seed, 20261121])
    q, v, a = reference(trajectory, duration)
    plant = nuisance(rng)
    if effect == 'draw':
        names = [name for name in TYPICAL if name not in ('encoder_eccentricity', 'thermal_drift')]
        effect = str(rng.choice(names))
    i = int(rng.integers(2)) if joint is None else joint
    if effect == 'joint_coupling':
        i = 0
    size = 0.0
    where = '*' if effect in GLOBAL else JOINTS[i]
    drawn = float(np.exp(rng.uniform(np.log(0.4), np.log(1.6))))
    if effect is not None:
        size = hide(plant, effect, i, scale or drawn, rng, len(q) * bp.PERIOD)
    if second is not None:
        hide(plant, second, int(rng.integers(2)), scale or drawn, rng, len(q) * bp.PERIOD)
    t, measured, effort = bp.simulate(plant, q, v, a, rng, noise)
    t_ns = np.rint(t * 1e9).astype(np.int64)
    log = JointLog(JOINTS, t_ns, measured, np.full_like(measured, np.nan), effort)
    return Trial(effect or 'none', where, size, log)
