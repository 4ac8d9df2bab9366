# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Every effect of the catalogue, and some outside of it, put into the independent plant."""

from __future__ import annotations

import numpy as np

from validation import plant as bp

#: Typical size of each hidden effect, shoulder and elbow. Of an elasticity it is the stiffness,
#: which is divided by the scale: a larger effect is a softer gear.
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
    'hysteresis': (0.12, 0.03),
}  # fmt: skip
#: What no name of the catalogue is right for, typical sizes.
OUTSIDE = {
    # Friction with the root of speed; drag with its square [Nm (s/rad)^0.5, Nm (s/rad)^2].
    'root_friction': (0.32, 0.06), 'quadratic_drag': (0.105, 0.018),
    # A cable that is taut beyond 0.15 rad; a torque in time, as of a hum of the mains that
    # sampling folds down; friction that follows where the other joint is [Nm].
    'saturating_spring': (0.3, 0.1), 'beat': (0.15, 0.05), 'cross_friction': (0.20, 0.04),
}  # fmt: skip
#: The other things that are hidden: twins, see :func:`hide`.
TWINS = {'asymmetric_level': (0.15, 0.06), 'common_scale': (0.08, 0.08)}
#: Faults of the data, which have a size of their own: lag [s], share of samples.
FAULTS = {'velocity_lag': (6e-3, 6e-3), 'dropped_samples': (0.03, 0.03)}
GLOBAL = ('effort_delay', 'gravity_tilt', 'payload', 'common_scale', 'dropped_samples')
TRANSMISSION = ('joint_elasticity', 'backlash')
#: Efforts at which a saturation is its size, shoulder and elbow [Nm].
RATED = (9.0, 2.5)


def typical(effect: str, joint: int) -> float:
    """Return the typical size of an effect."""
    return {**TYPICAL, **OUTSIDE, **TWINS, **FAULTS}[effect][joint]


def hide(
    plant: bp.Plant, effect: str, i: int, scale: float, rng: np.random.Generator, duration: float
) -> float:
    """
    Put an effect of ``scale`` times its typical size into joint i, and return its size.

    Sign, phase, exponent and all other choices come from ``rng``. Each effect draws the same
    numbers from it at every ``scale``.
    """
    sign = float(rng.choice([-1.0, 1.0]))
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    size = scale * typical(effect, i)
    joint = plant.joint
    if effect in ('coulomb', 'viscous'):
        # Some friction remains.
        size = min(size, 0.7 * {'coulomb': bp.COULOMB, 'viscous': bp.VISCOUS}[effect][i])
        joint[effect][i] += sign * size
    elif effect == 'stribeck':
        joint['stribeck'][i] = size
        joint['stribeck_velocity'][i] = rng.uniform(0.05, 0.25)
        joint['stribeck_exponent'][i] = rng.uniform(0.8, 1.8)
    elif effect == 'asymmetric_friction':
        joint['asymmetry_viscous'][i] = sign * size
    elif effect == 'asymmetric_level':
        size = min(size, 0.7 * bp.COULOMB[i])
        joint['asymmetry'][i] = sign * size
    elif effect == 'load_dependent_friction':
        joint['load'][i] = size
    elif effect == 'position_dependent_friction':
        size = min(size, 0.8 * bp.COULOMB[i])
        joint['position'][i], joint['position_phase'][i] = size, phase
        joint['position_cycles'][i] = rng.choice([1.0, 2.0])
    elif effect == 'cogging':
        joint['cogging'][i], joint['cogging_phase'][i] = size, phase
        joint['cogging_cycles'][i] = rng.uniform(12.0, 100.0)
    elif effect == 'presliding_hysteresis':
        joint['slip'][i] = bp.SLIP + size
    elif effect == 'hysteresis':
        joint['hose'][i], joint['hose_slip'][i] = size, rng.uniform(0.1, 0.25)
    elif effect == 'joint_elasticity':
        plant.two_mass = True
        size = typical(effect, i) / scale
        joint['stiffness'][i] = size
    elif effect == 'backlash':
        plant.two_mass = True
        joint['gap'][i], joint['stiffness'][i] = size, rng.uniform(1e4, 2e4)
    elif effect == 'effort_scale':
        plant.scale[i] += sign * size
    elif effect == 'common_scale':
        plant.scale += sign * size
    elif effect == 'effort_saturation':
        # e artanh(x / e) exceeds x by the share x^2 / (3 e^2).
        plant.saturation[i] = RATED[i] / np.sqrt(3.0 * size)
    elif effect == 'effort_bias':
        plant.bias[i] = sign * size
    elif effect == 'effort_delay':
        plant.delay = size
    elif effect == 'gravity':
        if i == 0:
            size *= 2.0
            plant.first *= 1.0 + sign * size
        else:
            plant.second *= 1.0 + sign * size
    elif effect == 'gravity_tilt':
        plant.tilt = sign * size
    elif effect == 'inertia':
        # A rotor only has its nominal inertia to lose; the shoulder can lose the upper arm's.
        if i == 0 and sign < 0.0:
            size = min(size, 0.6 * bp.I1)
            plant.inertia = (plant.inertia[0] - size, plant.inertia[1])
        else:
            joint['armature'][i] += size
    elif effect == 'payload':
        plant.payload, plant.payload_distance = size, rng.uniform(0.18, 0.30)
    elif effect == 'joint_coupling':
        plant.coupling = sign * size
    elif effect == 'spring':
        joint['spring'][i], joint['spring_zero'][i] = size, rng.uniform(-1.0, 1.0)
    elif effect == 'external_contact':
        for start in np.sort(rng.uniform(0.07, 0.93, 4)) * duration:
            push = float(rng.choice([-1.0, 1.0]) * size)
            plant.contacts.append((i, float(start), float(rng.uniform(0.3, 1.2)), push))
    elif effect == 'encoder_eccentricity':
        plant.eccentricity[i], plant.eccentricity_phase[i] = size, phase
    elif effect == 'thermal_drift':
        size = min(size, 0.7)
        joint['warm_viscous'][i], joint['warm_coulomb'][i] = -size, -0.4 * size
        joint['warm_time'][i] = duration * rng.uniform(0.25, 0.6)
    elif effect == 'root_friction':
        joint['power_gain'][i], joint['power'][i] = size, 0.5
    elif effect == 'quadratic_drag':
        joint['quadratic'][i] = size
    elif effect == 'saturating_spring':
        joint['wire'][i], joint['wire_width'][i] = size / 0.15, 0.15
        joint['wire_zero'][i] = (-0.9, 0.9)[i] + rng.uniform(-0.3, 0.3)
    elif effect == 'beat':
        plant.beats.append((i, size, float(rng.uniform(0.3, 8.0)), phase))
    elif effect == 'cross_friction':
        size = min(size, 0.8 * bp.COULOMB[i])
        joint['cross'][i], joint['cross_phase'][i] = size, phase
    else:
        raise ValueError(effect)
    return size


def where(effect: str, i: int) -> str:
    """Return the joint that a right answer names."""
    if effect in GLOBAL:
        return '*'
    return ('shoulder', 'elbow')[0 if effect == 'joint_coupling' else i]
