# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Does one part of a measured record say the same as the other? ``python -m validation.repeats``.

Halves of a record, and runs of one robot, are fitted each alone. For each joint the parameters
that both know differ by d, and d^T (V_1 + V_2)^-1 d is beside chi squared. Friction that itself
changed (temperature, load, place) differs too: a small p says that the intervals do not hold it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.stats import chi2

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.law.law_fit import LawFit
from validation.records import Tool, add_data

_MAPS = Path(__file__).resolve().parents[1] / 'config' / 'import'
_ROTORS = (0.0, 3.7434, 0.0, 0.0708, 0.2342, 0.4365)
_DAMIAO = """
time: {variable: time, unit: s}
joints:
  joint:
    position: {variable: position, unit: rad}
    velocity: {variable: velocity, unit: rad/s}
    effort: {variable: torque_feedback, unit: Nm}
"""
Parts = dict[str, JointLog]


def halves(log: JointLog) -> Parts:
    """Return the first and the second half of a recording."""
    middle = len(log) // 2
    temperature = log.temperature
    return {
        name: replace(
            log, t_ns=log.t_ns[rows], q=log.q[rows], v=log.v[rows], tau=log.tau[rows],
            temperature=None if temperature is None else temperature[rows],
        )
        for name, rows in (('first half', slice(None, middle)), ('second', slice(middle, None)))
    }  # fmt: skip


def records(data: Path, tool: Tool, folder: Path) -> Iterator[tuple[str, sf.Model, Parts]]:
    """Yield what is there: the record, its model, and the parts that are compared."""
    if (data / 'emps').is_dir():
        for name, mapping in (('DATA_EMPS', 'emps'), ('DATA_EMPS_PULSES', 'emps_pulses')):
            source = data / 'emps' / f'{name}.mat'
            bag = folder / tool.imported(source, _MAPS / f'{mapping}.yaml', name)
            yield name, sf.Model.from_bag(bag), halves(sf.load(bag))
    if (data / 'ur10e').is_dir():
        names = [f'shoulder_{x}_joint' for x in ('pan', 'lift')] + ['elbow_joint']
        names += [f'wrist_{k}_joint' for k in (1, 2, 3)]
        urdf = (data / 'ur10e' / 'robot.urdf').read_text(encoding='utf-8')
        model = sf.Model.from_urdf(urdf, dict(zip(names, _ROTORS, strict=True)))
        runs = {
            name: sf.load(data / 'ur10e' / f'{name}.csv', _MAPS / 'ur10e.yaml')
            for name in ('30sec_12harm', 'joint_2')
        }
        yield 'UR10e 30sec_12harm', model, halves(runs['30sec_12harm'])
        yield 'UR10e', model, runs
    for motor, inertia in (('03', 0.0566), ('05', 0.00107)):
        if not (data / 'damiao').is_dir():
            continue
        shaft = folder / f'shaft_{motor}'
        tool.run('model', 'free', '--inertia', inertia, '--out', shaft)
        mapping = folder / 'damiao.yaml'
        mapping.write_text(_DAMIAO, encoding='utf-8')
        parts = {}
        for run in ('01', '02'):
            source = data / 'damiao' / f'motor_{motor}_run_{run}.npz'
            parts[f'run {run}'] = sf.load(source, mapping)
        yield f'Damiao motor {motor}', sf.Model.read(shaft), parts


def laws(log: JointLog, model: sf.Model) -> dict[str, LawFit]:
    """Return the law of each joint that can be fitted."""
    found = sf.fit(log, model).analysis.fit.joints
    return {
        joint: fits[observer].fit
        for joint, fits in found.items()
        if (observer := preferred_observer(fits)) is not None
    }


def compare(one: LawFit, other: LawFit) -> tuple[list[str], float, float]:
    """
    Return the parameters that both know, d^T (V_1 + V_2)^-1 d and its p.

    A law of the regression over all joints has standard errors alone: V is then their diagonal.
    """
    names = [
        n
        for n, p in one.parameters.items()
        if n in other.parameters and np.isfinite([p.value, other.parameters[n].value]).all()
    ]
    variance = np.zeros((len(names), len(names)))
    for fit in (one, other):
        if fit.covariance is None:
            variance += np.diag([fit.parameters[n].std_error ** 2 for n in names])
        else:
            at = [fit.covariance_of.index(n) for n in names]
            variance += fit.covariance[np.ix_(at, at)]
    d = np.array([one.parameters[n].value - other.parameters[n].value for n in names])
    square = float(d @ np.linalg.solve(variance, d))
    return names, square, float(chi2.sf(square, len(names)))


def main() -> int:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_data(parser)
    data = parser.parse_args().data.resolve()
    print('| record | joint | parameters, one and other | d^2 | p |\n|---|---|---|---|---|')
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for record, model, parts in records(data, Tool(folder), folder):
            fitted = {name: laws(log, model) for name, log in parts.items()}
            for (first, one), (second, other) in combinations(fitted.items(), 2):
                for joint in one:
                    if joint not in other:
                        continue
                    names, square, p = compare(one[joint], other[joint])
                    told = ', '.join(
                        f'{n} {_text(one[joint], n)} and {_text(other[joint], n)}' for n in names
                    )
                    print(
                        f'| {record}: {first}, {second} | {joint} | {told} | {square:.1f} '
                        f'| {p:.2g} |',
                        flush=True,
                    )
    return 0


def _text(fit: LawFit, name: str) -> str:
    parameter = fit.parameters[name]
    return f'{parameter.value:.4g} ± {parameter.std_error:.2g}'


if __name__ == '__main__':
    sys.exit(main())
