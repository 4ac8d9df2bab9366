# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What the diagnosis says of a pendulum without a hidden effect that moves in a few sines.

Inverse dynamics in closed form, no plant: effort is that of the nominal model, and white noise is
added to effort and position. Anything but ``nothing_above_floor`` is wrong.
``python -m validation.sines``
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import sosml_friction as sf
from sosml_friction.report.common.table import print_table, terminal_table

MASS, LENGTH, ARMATURE, COULOMB, VISCOUS = 1.3, 0.3, 0.02, 0.5, 0.12
#: Standard deviations of effort [Nm] and position [rad], rate [Hz], seconds, the lowest sine [Hz].
EFFORT_NOISE, POSITION_NOISE, RATE, SECONDS, LOWEST = 0.02, 2e-5, 250.0, 60.0, 0.2
MJCF = f"""<mujoco><worldbody><body>
<joint name="joint" axis="0 -1 0" armature="{ARMATURE}" damping="{VISCOUS}"
  frictionloss="{COULOMB}"/>
<inertial pos="0 0 -{LENGTH}" mass="{MASS}" diaginertia="1e-5 1e-5 1e-5"/>
</body></worldbody></mujoco>"""


def recording(sines: int, seed: int) -> sf.JointLog:
    """Return a recording of a sum of harmonics of random phase, amplitude 1 / k rad."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    k = np.arange(1, sines + 1)[:, None]
    w = 2.0 * np.pi * LOWEST * k
    phase = w * t + rng.uniform(0.0, 2.0 * np.pi, k.shape)
    q = np.sum(np.sin(phase) / k, axis=0)
    v = np.sum(w * np.cos(phase) / k, axis=0)
    a = np.sum(-(w**2) * np.sin(phase) / k, axis=0)
    tau = (MASS * LENGTH**2 + 1e-5 + ARMATURE) * a + MASS * 9.81 * LENGTH * np.sin(q)
    tau += COULOMB * np.sign(v) + VISCOUS * v + EFFORT_NOISE * rng.standard_normal(len(t))
    q += POSITION_NOISE * rng.standard_normal(len(t))
    t_ns = np.round(1e9 * t).astype(np.int64)
    return sf.JointLog(('joint',), t_ns, q[:, None], np.full((len(t), 1), np.nan), tau[:, None])


def said(sines: int, seeds: Iterable[int]) -> list[str]:
    """Return the verdict of each recording."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / 'pendulum.xml'
        model.write_text(MJCF)
        return [sf.diagnose(recording(sines, seed), mjcf=model).verdict for seed in seeds]


def main() -> None:
    """Count the verdicts by number of sines and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').strip().splitlines()[0])
    parser.add_argument('--seed', type=int, default=1, help='of the first recording (1)')
    parser.add_argument('--seeds', type=int, default=6, help='recordings of each motion (6)')
    options = parser.parse_args()
    verdicts = ('nothing_above_floor', 'unknown_structure', 'ambiguous', 'named', 'bad_data')
    rows = []
    for sines in (1, 2, 3, 6):
        found = said(sines, range(options.seed, options.seed + options.seeds))
        rows.append([str(sines), *(str(found.count(verdict)) for verdict in verdicts)])
    print_table(terminal_table({'sines': 'n', **dict.fromkeys(verdicts, 'n')}, rows))


if __name__ == '__main__':
    main()
