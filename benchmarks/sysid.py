# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Fit one pendulum with mujoco.sysid and with this package, side by side: ``make sysid``.

The pendulum (J .1625 kg m2 with an armature of .004, C .4, B .12) follows a ladder of speeds from
.01 to 2 rad/s for 79 s under a PD, once without and once with Stribeck friction (S .25, v_s .05).
It is simulated here, with friction that sticks, by nothing of either package. Both get the same
samples at 500 Hz and the same body, and both look for the armature. mujoco.sysid also gets the
controller (closed loop), or windows of 0.5 s driven by the measured effort (open); ours gets no
controller. Told are parameters, 95 % intervals, processor time, and what each says.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import logging
import re
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from scipy.signal import savgol_filter

import sosml_friction as sf

ARMATURE, COULOMB, VISCOUS = 0.004, 0.4, 0.12
KNEE, KNEE_SPEED = 0.25, 0.05
MASS, ARM, BODY = 1.0, 0.122324, 0.1585  # kg, m, kg m2 about the axis
GRAVITY = 9.81
KP, KD = 60.0, 4.0  # Nm/rad, Nm s/rad
STEP, FINE, LENGTH = 2e-3, 40, 79.0  # s; steps of the pendulum per sample; s
MUJOCO_STEP = 5e-4  # s; at 2 ms it fits an armature of .0046 without Stribeck friction
NOISE = (1e-5, 1e-3, 0.02)  # rad, rad/s, Nm
SPEEDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)

URDF = f"""<robot name="pendulum"><link name="base"/><link name="arm"><inertial>
<origin xyz="{ARM} 0 0"/><mass value="{MASS}"/>
<inertia ixx="0.1" iyy="{BODY - MASS * ARM**2}" izz="0.13" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="joint" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/><limit effort="20" velocity="10"/></joint></robot>"""


@dataclass(frozen=True)
class Record:
    """Hold what was measured and the target of the PD, all (N,)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    target: np.ndarray


def reference() -> tuple[np.ndarray, np.ndarray]:
    """Return position and velocity of the ladder: each speed both ways, over and over."""
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(0.2 / STEP)) * STEP / 0.2)
    parts: list[np.ndarray] = []
    for speed in SPEEDS:
        one = np.ones(round(min(4.0, max(1.0, 1.2 / speed)) / STEP))
        one[: len(ramp)], one[-len(ramp) :] = ramp, ramp[::-1]
        parts += [speed * one, -speed * one]
    v = np.resize(np.concatenate(parts), round(LENGTH / STEP))
    return np.append(0.0, np.cumsum(0.5 * (v[1:] + v[:-1]))) * STEP, v


def step_of(q: float, v: float, tau: float, knee: float, h: float) -> tuple[float, float]:
    """
    Advance the pendulum by ``h`` [s]: J dv/dt = tau + m g l cos q - friction.

    Viscous friction is implicit. Dry friction takes the effort that stops the joint, up to its
    level at this speed, so that the joint sticks.
    """
    inertia = BODY + ARMATURE
    level = COULOMB + knee * np.exp(-abs(v) / KNEE_SPEED)
    free = (inertia * v + h * (tau + MASS * GRAVITY * ARM * np.cos(q))) / (inertia + h * VISCOUS)
    stop = free * (inertia + h * VISCOUS) / h
    v = free - h * min(max(stop, -level), level) / (inertia + h * VISCOUS)
    return q + h * v, v


def motion(knee: float) -> tuple[np.ndarray, np.ndarray]:
    """
    Return q, v, tau (N, 3) of the pendulum under control, and the target of the PD (N,).

    The drive closes its loop at 20 kHz and interpolates the targets, which come at 500 Hz.
    """
    wanted, speed = reference()
    feed = BODY * np.gradient(speed, STEP) - MASS * GRAVITY * ARM * np.cos(wanted)
    target = wanted + (KD * speed + feed) / KP
    q, v = wanted[0], 0.0
    states = np.empty((len(target), 3))
    for k, goal in enumerate(target):
        states[k] = q, v, KP * (goal - q) - KD * v
        ahead = target[min(k + 1, len(target) - 1)]
        for part in range(FINE):
            tau = KP * (goal + (ahead - goal) * part / FINE - q) - KD * v
            q, v = step_of(q, v, tau, knee, STEP / FINE)
    return states, target


def recording(knee: float, seed: int) -> Record:
    """Return the motion with white noise."""
    states, target = motion(knee)
    noisy = states + NOISE * np.random.default_rng(seed).standard_normal(states.shape)
    return Record(np.arange(len(target)) * STEP, *noisy.T, target)


#: Truth, and what each tool says, by parameter: value, low and high of its 95 % interval.
Found = Mapping[str, tuple[float, float, float]]
NAMES = ('armature', 'viscous', 'coulomb', 'stribeck', 'stribeck_velocity')


@dataclass(frozen=True)
class Answer:
    """Hold what one tool found, in how many seconds of processor time, and what it says."""

    who: str
    found: Found
    seconds: float
    said: str


class Warned(logging.Handler):
    """Keep what mujoco.sysid warns of while it fits."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one warning."""
        self.said.append(record.getMessage())


def simulator(closed: bool) -> Any:
    """Return an MjSpec of the pendulum; its joint's own numbers are guesses."""
    import mujoco

    gains = f'gainprm="{KP}" biastype="affine" biasprm="0 -{KP} -{KD}"' if closed else ''
    sensors = '<jointpos name="q" joint="joint"/><jointvel name="v" joint="joint"/>'
    effort = '<jointactuatorfrc name="tau" joint="joint"/>' if closed else ''
    return mujoco.MjSpec.from_string(f"""<mujoco><compiler angle="radian"/>
<option timestep="{MUJOCO_STEP}" gravity="0 0 -{GRAVITY}"><flag contact="disable"/></option>
<worldbody><body name="arm">
<joint name="joint" type="hinge" axis="0 1 0" armature="0.01" damping="0.3" frictionloss="0.3"
solreffriction="{2 * MUJOCO_STEP} 1" solimpfriction="0.999 0.9999 0.001"/>
<inertial pos="{ARM} 0 0" mass="{MASS}" diaginertia="0.1 {BODY - MASS * ARM**2} 0.13"/>
</body></worldbody><actuator><general joint="joint" {gains}/></actuator>
<sensor>{sensors}{effort}</sensor></mujoco>""")


def writer(name: str) -> Callable[[Any, Any], None]:
    """Return what writes a parameter to the joint of an MjSpec."""

    def write(spec: Any, parameter: Any) -> None:
        joint = spec.joint('joint')
        if name == 'damping':  # an array since MuJoCo 3.7
            joint.damping[0] = parameter.value[0]
        else:
            setattr(joint, name, parameter.value[0])

    return write


def by_mujoco(record: Record, window: int | None = None) -> Answer:
    """
    Fit with mujoco.sysid: the whole record in closed loop, or open windows of so many samples.

    MuJoCo computes sensors before a step and mujoco.sysid stamps them after it, so that the
    measured ones are stamped as much later here: with the true parameters its position is then off
    by 0.02 mrad rms, else by 0.17. Windows begin where the measurement is, smoothed over 22 ms.
    """
    from mujoco import sysid
    from mujoco.sysid.report.sections.insights import AutomatedInsights

    began = time.process_time()
    spec = simulator(window is None)
    model = spec.compile()
    params = sysid.ParameterDict()
    for name, guess, most in (
        ('armature', 0.01, 0.1), ('damping', 0.3, 2.0), ('frictionloss', 0.3, 2.0)
    ):  # fmt: skip
        params.add(sysid.Parameter(name, guess, 0.0, most, modifier=writer(name)))
    closed = np.column_stack([record.q, record.v, record.tau])
    measured, control = (closed, record.target) if window is None else (closed[:, :2], record.tau)
    start = savgol_filter(closed[:, :2], 11, 2, axis=0)
    size = window or len(closed)
    pieces = [slice(k, k + size) for k in range(0, len(closed) - size + 1, size)]
    times = [record.t[piece] - record.t[piece][0] for piece in pieces]
    sequences = sysid.ModelSequences(
        'pendulum',
        spec,
        [str(k) for k in range(len(pieces))],
        [sysid.create_initial_state(model, *start[piece][0][:, None]) for piece in pieces],
        [sysid.TimeSeries(t, control[p][:, None]) for t, p in zip(times, pieces, strict=True)],
        [
            sysid.TimeSeries.from_names(t + MUJOCO_STEP, measured[piece], model)
            for t, piece in zip(times, pieces, strict=True)
        ],
    )
    residual = sysid.build_residual_fn(models_sequences=[sequences], n_threads=1)
    warned = Warned()
    logging.getLogger('absl').addHandler(warned)
    with contextlib.redirect_stdout(io.StringIO()):  # it tells every iteration
        fitted, result = sysid.optimize(params, residual, verbose=False)
    logging.getLogger('absl').removeHandler(warned)
    _, half = sysid.calculate_intervals(residual(result.x, fitted)[0], result.jac)
    seconds = time.process_time() - began
    insights = AutomatedInsights('', fitted).get_context()['insights']
    said = [*warned.said, *(x['message'] for x in insights)]
    found = {
        name: (value, value - width, value + width)
        for name, value, width in zip(NAMES, result.x, half, strict=False)
    }
    how = 'closed loop' if window is None else f'{len(pieces)} open windows'
    return Answer(f'mujoco.sysid, {how}', found, seconds, re.sub('<[^>]*>', '', ' '.join(said)))


def log_of(record: Record) -> sf.JointLog:
    """Return the record as this package takes it."""
    stamps = np.round(1e9 * record.t).astype(np.int64)
    return sf.JointLog(
        ('joint',), stamps, record.q[:, None], record.v[:, None], record.tau[:, None]
    )


def by_fit(record: Record) -> tuple[Answer, sf.Model]:
    """Fit with ``sf.fit``, which is not told the rotor either; return the fitted model too."""
    began = time.process_time()
    fit = sf.fit(log_of(record), sf.Model.from_urdf(URDF))
    seconds = time.process_time() - began
    own, intervals = fit.parameters['joint'], fit.conf_int()['joint']
    found = {name: (own[name].value, *intervals[name]) for name in NAMES}
    return Answer('sf.fit', found, seconds, own['stribeck'].reason), fit.model


def by_diagnosis(record: Record, model: sf.Model) -> Answer:
    """Diagnose, by ``sf.diagnose``, a model on the record."""
    began = time.process_time()
    diagnosis = sf.diagnose(log_of(record), model)
    seconds = time.process_time() - began
    found = {
        name: (p.value, *diagnosis.conf_int()[cause.joint][f'{cause.effect}.{name}'])
        for cause in diagnosis.causes
        for name, p in cause.parameters.items()
        if name in NAMES
    }
    said = ', '.join([diagnosis.verdict, *(cause.effect for cause in diagnosis.causes)])
    return Answer('sf.diagnose of the fit for S = 0', found, seconds, said)


def cell(found: Found, name: str, truth: float) -> str:
    """Return a value and its interval, bold where the interval does not hold the truth."""
    if name not in found:
        return ''
    value, low, high = found[name]
    if np.isnan(low):
        return 'open'
    text = f'{low:.5f} to {high:.5f}'
    text = text if np.isnan(value) else f'{value:.5f} ({text})'
    return text if low <= truth <= high else f'**{text}**'


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument(
        '--open', action='store_true', help='mujoco.sysid also in open windows of 0.5 s: minutes'
    )
    options = parser.parse_args()
    try:
        from mujoco import sysid
    except ImportError:
        sysid = None
    # Its import goes on in silence where an extra is missing; this is the last name it makes.
    if not hasattr(sysid, 'default_report'):
        sys.exit('mujoco.sysid cannot be imported: install it with pip install "mujoco[sysid]"')
    versions = f'mujoco {version("mujoco")}, sosml_friction {sf.__version__}'
    print(f'{versions}; bold: the 95 % interval does not hold the truth\n')
    print('| | armature | B | C | S | v_s | CPU s | says |\n|' + '---|' * 8, flush=True)
    sf.fit(log_of(recording(0.0, options.seed)), sf.Model.from_urdf(URDF))  # compiles
    model = None
    for knee in (0.0, KNEE):
        record = recording(knee, options.seed)
        truth = dict(zip(NAMES, (ARMATURE, VISCOUS, COULOMB, knee, KNEE_SPEED), strict=True))
        shown = [f'{x:g}' for name, x in truth.items() if knee or name != 'stribeck_velocity']
        print(f'| **truth** | {" | ".join(shown)} {"" if knee else "| "}| | |')
        answers = [by_mujoco(record)]
        if options.open:
            answers.append(by_mujoco(record, round(0.5 / STEP)))
        fitted, own = by_fit(record)
        model = model or own
        for answer in (*answers, fitted, by_diagnosis(record, model)):
            cells = [cell(answer.found, name, x) for name, x in truth.items()]
            ends = f'{answer.seconds:.1f} | {answer.said}'
            print(f'| {answer.who} | {" | ".join(cells)} | {ends} |', flush=True)


if __name__ == '__main__':
    main()
