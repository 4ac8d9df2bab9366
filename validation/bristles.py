# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Ask a fit of terms for the Stribeck term of friction that follows its level over a displacement.

``python -m validation.bristles --seeds 8`` prints how far S is off, half its interval, and how
often the intervals of S and v_s hold the truth. A pendulum moves along four sines with phases of
its own for 60 s at 250 Hz, 20 mNm of noise in effort, 19 bits of position. Its friction is that of
LuGre's bristles, F' = s_0 (v - F |v| / g), of a Dahl's state times the level g, or g at once. Of
3 mrad, longer than what counts as a sign, presliding is fitted besides.
"""

from __future__ import annotations

import argparse

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.report.common.table import print_table, terminal_table

COULOMB, VISCOUS, KNEE = 0.25, 0.15, 0.05
STEP, SAMPLES, FINE, NOISE, COUNT = 4e-3, 15000, 8, 0.02, 2.0 * np.pi / 2**19
SIZES, RATES = (0.5, 0.2, 0.12, 0.05), (0.31, 0.83, 1.7, 3.3)
#: Longer ones are no sign for a motion of this range [rad].
LONGEST = 1.2e-3
MODEL = pendulum_model(1.2, 0.3, 0.0, 0.02, 'joint')
#: Form, displacement [rad], exponent, and S as a share of C.
CASES = tuple(
    (form, displacement, exponent, share)
    for share in (0.2, 0.4, 0.8)
    for form, displacement, exponent in (
        ('bristles', 3e-4, 1.0),
        ('bristles', 1e-3, 1.0),
        ('bristles', 1e-3, 2.0),
        ('bristles', 3e-3, 1.0),
        ('state times level', 1e-3, 1.0),
        ('at once', 0.0, 1.0),
    )
)


def bristles(v: np.ndarray, displacement: float, exponent: float, S: float) -> np.ndarray:
    """Return F (N,) with s_0 = C / displacement, solved over fine steps."""
    result, force = np.zeros_like(v), 0.0
    for k in range(1, len(v)):
        for j in range(FINE):
            speed = v[k - 1] + (v[k] - v[k - 1]) * (j + 0.5) / FINE
            level = COULOMB + S * np.exp(-((abs(speed) / KNEE) ** exponent))
            moved = abs(speed) * STEP / FINE * COULOMB / displacement / level
            aim = np.sign(speed) * level
            force = aim + (force - aim) * np.exp(-moved)
        result[k] = force
    return result


def recording(
    form: str, displacement: float, exponent: float, S: float, seed: int, noise: float = NOISE
) -> JointLog:
    """Return one recording; ``noise`` of effort [Nm]."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(SAMPLES)
    angles = np.outer(RATES, t) + rng.uniform(0.0, 2.0 * np.pi, (4, 1))
    w, size = np.array(RATES), np.array(SIZES)
    q, v, a = size @ np.sin(angles), (size * w) @ np.cos(angles), -(size * w**2) @ np.sin(angles)
    robot = MODEL.make_robot()
    rows = zip(q[:, None], v[:, None], a[:, None], strict=True)
    tau = np.array([robot.inverse_dynamics(*row) for row in rows])
    level = COULOMB + S * np.exp(-((np.abs(v) / KNEE) ** exponent))
    if form == 'bristles':
        friction = bristles(v, displacement, exponent, S)
    else:
        sign = dahl_path(q, displacement) if displacement else np.sign(v)
        friction = sign * level
    tau = tau[:, 0] + friction + VISCOUS * v + noise * rng.standard_normal(SAMPLES)
    q = COUNT * np.rint(q / COUNT + 0.5 * rng.standard_normal(SAMPLES))
    stamps = np.rint(1e9 * t).astype(np.int64)
    return JointLog(('joint',), stamps, q[:, None], np.full((SAMPLES, 1), np.nan), tau[:, None])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=8)
    parser.add_argument('--seed', type=int, default=0, help='the first')
    asked = parser.parse_args()
    rows = []
    for form, displacement, exponent, share in CASES:
        S, found = share * COULOMB, []
        for seed in range(asked.seed, asked.seed + asked.seeds):
            log = recording(form, displacement, exponent, S, seed)
            slow = ['presliding_hysteresis'] if displacement > LONGEST else []
            fit = fit_terms([log], MODEL, ['coulomb', 'viscous', *slow, 'stribeck'])
            p = fit.terms[-1].parameters
            ends = [p[name].interval for name in ('stribeck', 'stribeck_velocity')]
            holds = [low <= x <= high for (low, high), x in zip(ends, (S, KNEE), strict=True)]
            follows = any('follows' in own.inner for own in fit.estimate.placed)
            found.append((p['stribeck'].value, 0.5 * (ends[0][1] - ends[0][0]), *holds, follows))
        values = np.array(found, dtype=float)
        mean, half = values[:, 0].mean() / S - 1.0, np.median(values[:, 1]) / S
        counts = [f'{int(n)} of {len(found)}' for n in values[:, 2:].sum(axis=0)]
        case = [form, f'{1e3 * displacement:g}', f'{exponent:g}', f'{share:g}']
        rows.append([*case, f'{100 * mean:+.1f}', f'{100 * half:.1f}', *counts])
    names = ('friction', 'mrad', 'exponent', 'S / C', 'S off [%]', '± [%]', 'S held', 'v_s held',
             'followed')  # fmt: skip
    print_table(terminal_table(dict.fromkeys(names, 'w'), rows))


if __name__ == '__main__':
    main()
