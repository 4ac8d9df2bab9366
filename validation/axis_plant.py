# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
A linear axis on a ball screw as a plant that hides effects: the third judge.

One prismatic joint with cascade control: position P, velocity PI at 2 kHz, current loop of first
order that saturates. Two masses, motor through the screw and carriage, stiff or with a gap; guides
with bristles (LuGre's, integrated exactly over a step), steps of 25 us. Recorded at 500 Hz:
position in encoder counts at the motor, effort from the current. It shares no code with the
package nor with the other plants. Every nominal parameter is off by a Gaussian of 2 %.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from sosml_friction.compiled import compiled

STEP, CONTROL, RECORD = 25e-6, 20, 80
PERIOD = RECORD * STEP
#: Counts of the encoder [m], noise of the current as force and its quanta [N].
COUNT, NOISE, LSB = 10e-3 / 65536, 0.8, 0.25
#: Position loop [1/s], velocity loop [N s/m, s], lag of current [s], largest force [N].
KV, KP, TI, LAG, MOST = 40.0, 2e4, 0.02, 4e-4, 900.0
TRAVEL, PITCH = 0.4, 10e-3
#: Deflection at which bristles slip [m], and their damping ratio.
BRISTLE, DAMPED = 5e-6, 0.3
#: Stiffness of a screw with a gap [N/m], and its damping ratio.
SCREW, SCREW_DAMPED = 2e7, 0.1
NUISANCE = 0.02
#: Band in which SNR is stated [Hz].
BAND = 30.0

#: Effects and typical sizes: N, N s/m as a share, kg, s, m, N/m, N s2/m2, N (s/m)^0.5.
CATALOGUE = {
    'stribeck': 6.0, 'asymmetric_friction': 0.12, 'position_dependent_friction': 5.0,
    'cogging': 2.0, 'effort_scale': 0.08, 'effort_bias': 4.0, 'effort_delay': 5e-3,
    'inertia': 14.0, 'backlash': 8e-5, 'spring': 40.0,
}  # fmt: skip
OUTSIDE = {'quadratic_drag': 60.0, 'friction_step': 5.0, 'hum': 2.5, 'root_friction': 20.0}
SIGNED = ('asymmetric_friction', 'effort_scale', 'effort_bias')
#: Smallest share of a typical size: less is within what a nominal may be off by, 3.5 % and half a
#: sampling interval of effort, beside its nuisance.
LEAST = 0.5

#: What the integrator is given, in this order.
_NAMES = (
    'motor', 'carriage', 'coulomb', 'viscous', 'asymmetry', 'stribeck', 'stribeck_velocity',
    'tight', 'root', 'drag', 'step', 'step_time', 'cogging', 'cogging_phase', 'spring',
    'spring_zero', 'gap', 'hum', 'hum_hertz',
)  # fmt: skip


@dataclass
class Axis:
    """Hold the numbers of an axis; the defaults are the nominal ones [kg, N, N s/m, m, s]."""

    motor: float = 35.0
    carriage: float = 60.0
    coulomb: float = 25.0
    viscous: float = 180.0
    asymmetry: float = 0.0
    stribeck: float = 0.0
    stribeck_velocity: float = 0.02
    tight: float = 0.0
    root: float = 0.0
    drag: float = 0.0
    step: float = 0.0
    step_time: float = 0.0
    cogging: float = 0.0
    cogging_phase: float = 0.0
    spring: float = 0.0
    spring_zero: float = 0.0
    gap: float = 0.0
    hum: float = 0.0
    hum_hertz: float = 5.0
    scale: float = 0.0
    bias: float = 0.0
    delay: float = 0.0
    shape: tuple[float, float] = field(default=(0.5, 0.5))

    def urdf(self) -> str:
        """Return the carriage on its rail."""
        return (
            '<robot name="axis"><link name="rail"/><joint name="axis" type="prismatic">'
            '<parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>'
            f'<limit lower="-{TRAVEL}" upper="{TRAVEL}" effort="{MOST}" velocity="2"/></joint>'
            f'<link name="carriage"><inertial><mass value="{self.carriage}"/><inertia ixx="1" '
            'ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>'
        )


def make_axis(rng: np.random.Generator, size: float = NUISANCE) -> Axis:
    """Return an axis whose every nominal parameter is off."""
    names = ('motor', 'carriage', 'coulomb', 'viscous')
    off = 1.0 + size * rng.standard_normal(len(names))
    return Axis(**{n: getattr(Axis(), n) * x for n, x in zip(names, off.tolist(), strict=True)})


def hide(axis: Axis, effect: str, size: float, rng: np.random.Generator, end: float) -> Axis:
    """Return the axis with an effect of a size; all else of it comes from ``rng``."""
    x, y = rng.uniform(size=2).tolist()
    size *= float(rng.choice([-1.0, 1.0])) if effect in SIGNED else 1.0
    changes = {
        'stribeck': {'stribeck': size, 'stribeck_velocity': 0.01 + 0.04 * x},
        'asymmetric_friction': {'asymmetry': size},
        'position_dependent_friction': {'tight': min(size, 0.8 * axis.coulomb)},
        'cogging': {'cogging': size, 'cogging_phase': 6.28 * x},
        'effort_scale': {'scale': size},
        'effort_bias': {'bias': size},
        'effort_delay': {'delay': size},
        'inertia': {'carriage': axis.carriage + size},
        'backlash': {'gap': size},
        'spring': {'spring': size, 'spring_zero': 0.2 * (x - 0.5)},
        'quadratic_drag': {'drag': size},
        'friction_step': {'step': size, 'step_time': (0.3 + 0.4 * x) * end},
        'hum': {'hum': size, 'hum_hertz': 2.0 + 12.0 * x},
        'root_friction': {'root': size},
    }[effect]
    return replace(axis, shape=(x, y), **changes)


def moves(seed: int, duration: float = 70.0) -> np.ndarray:
    """Return the reference (N,) at the rate of control: quintic moves of all speeds, and rests."""
    rng = np.random.default_rng(seed)
    dt, here, parts, count = CONTROL * STEP, 0.0, [], 0
    while sum(map(len, parts)) * dt < duration:
        speed = (0.4, 0.01, 0.15, 0.03, 0.4, 0.08)[count % 6] * rng.uniform(0.7, 1.3)
        # Of a quintic, the peak speed is 1.875 times the mean, the peak acceleration 5.77.
        far = TRAVEL * 0.5 * rng.uniform(0.3, 1.0) * (-1.0 if here > 0.0 else 1.0)
        far = far if speed > 0.1 else float(np.clip(here + 25.0 * speed * (far - here), -0.2, 0.2))
        length = abs(far - here)
        time = max(1.875 * length / speed, np.sqrt(5.77 * length / 3.5), 0.1)
        s = np.linspace(0.0, 1.0, max(int(time / dt), 2))
        parts.append(here + (far - here) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
        parts.append(np.full(int(rng.uniform(0.1, 0.4) / dt), far))
        here, count = far, count + 1
    return np.concatenate(parts)[: int(duration / dt)]


@compiled
def _run(reference: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, velocity and force of the motor at the rate of recording."""
    (motor, carriage, coulomb, viscous, asymmetry, stribeck, slow, tight, root, drag, more, when,
     ripple, phase, spring, zero, gap, hum, hertz) = number  # fmt: skip
    stiff = gap > 0.0
    moved = motor if stiff else motor + carriage
    bristle = coulomb / BRISTLE
    held = 2.0 * DAMPED * np.sqrt(bristle * moved)
    damped = 2.0 * SCREW_DAMPED * np.sqrt(SCREW * motor * carriage / (motor + carriage))
    count = len(reference) * CONTROL // RECORD
    out = np.empty((3, count))
    x = y = v = w = z = force = wanted = total = filtered = 0.0
    last = 0.0
    for k in range(count * RECORD):
        t = k * STEP
        if k % RECORD == 0:
            j = k // RECORD
            out[0, j], out[1, j], out[2, j] = x, v, force
        if k % CONTROL == 0:
            j, dt = k // CONTROL, CONTROL * STEP
            seen = COUNT * np.round(x / COUNT)
            filtered += 0.25 * ((seen - last) / dt - filtered)
            last = seen
            ahead = (reference[min(j + 1, len(reference) - 1)] - reference[j]) / dt
            error = KV * (reference[j] - seen) + ahead - filtered
            total = min(max(total + KP / TI * error * dt, -MOST), MOST)
            wanted = min(max(KP * error + total, -MOST), MOST)
        force += STEP / LAG * (wanted - force)
        speed = abs(v)
        level = coulomb + stribeck / (1.0 + (v / slow) ** 2)
        level += tight * (1.0 - 3.0 * (x / (0.5 * TRAVEL)) ** 2 / 2.0) + root * np.sqrt(speed)
        if t > when:
            level += more
        level = max(level, 0.1 * coulomb)
        z = np.sign(v) + (z - np.sign(v)) * np.exp(-bristle * speed * STEP / level)
        friction = level * z + held * (1.0 - min(abs(z), 1.0)) * v
        friction += viscous * (1.0 + (asymmetry if v > 0.0 else -asymmetry)) * v
        friction += drag * v * speed
        push = ripple * np.cos(2.0 * np.pi * x / PITCH + phase)
        push += spring * (x - zero) + hum * np.sin(2.0 * np.pi * hertz * t)
        given = 0.0
        if stiff:
            apart = x - y
            deep = apart - 0.5 * gap if apart > 0.5 * gap else min(apart + 0.5 * gap, 0.0)
            if deep != 0.0:
                given = SCREW * deep + damped * (v - w)
            # A tenth of the friction is the carriage's.
            w += STEP * (given - 0.1 * coulomb * np.tanh(w / 1e-3)) / carriage
            y += STEP * w
            friction -= 0.1 * coulomb * z
        v += STEP * (force - friction - push - given) / moved
        x += STEP * v
    return out[0], out[1], out[2]


def simulate(axis: Axis, reference: np.ndarray, rng: np.random.Generator | None = None,
             noise: float = 1.0) -> tuple[np.ndarray, ...]:  # fmt: skip
    """Return time, position, velocity, effort (N,) as recorded; without noise if no ``rng``."""
    numbers = np.array([float(asdict(axis)[name]) for name in _NAMES])
    x, v, force = _run(reference, numbers)
    t = PERIOD * np.arange(len(x))
    effort = np.interp(t - axis.delay, t, force) * (1.0 + axis.scale) + axis.bias
    if rng is None:
        return t, x, v, effort
    effort = effort + noise * NOISE * rng.standard_normal(len(t))
    return t, COUNT * np.round(x / COUNT), v, LSB * np.round(effort / LSB)


def signal_to_noise(axis: Axis, plain: Axis, reference: np.ndarray, noise: float = 1.0) -> float:
    """Return rms of what the effect adds to the effort over that of noise, in the band."""
    with_it, without = (simulate(one, reference)[3] for one in (axis, plain))
    sos = butter(4, BAND, fs=1.0 / PERIOD, output='sos')
    added = sosfiltfilt(sos, with_it - without)
    return float(np.std(added) if not axis.bias else np.sqrt(np.mean(added**2))) / (
        noise * NOISE * np.sqrt(2.0 * BAND * PERIOD)
    )
