# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the tool says of measured records, beside what is known of them: ``make records``."""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sosml_friction.model.parameter import Z_95

_HERE = Path(__file__).resolve().parents[1]
_MAPS = _HERE / 'config' / 'import'
#: Of motor 5 of the Damiao bench, published [kg m2].
_SHAFT = '0.00107'


class Row(NamedTuple):
    """Hold one line of the table; ``met`` is None where there is no bar."""

    record: str
    what: str
    known: str
    found: str
    met: bool | None


class Tool:
    """Runs ``sosml`` in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def run(self, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        """Return what a command printed and its exit code."""
        command = [sys.executable, '-m', 'sosml_friction.cli.main', *map(str, arguments)]
        environment = {**os.environ, 'PYTHONPATH': str(_HERE)}
        return subprocess.run(
            command, cwd=self._folder, env=environment, capture_output=True, text=True, check=False
        )

    def told(self, *arguments: str | Path) -> dict[str, Any]:
        """
        Return the object that a command prints with ``--json``.

        :raises RuntimeError: if it prints none, with what it said.
        """
        done = self.run(*arguments, '--json')
        if not done.stdout:
            raise RuntimeError(done.stderr.strip())
        return dict(json.loads(done.stdout))

    def imported(self, source: Path, mapping: Path, name: str) -> str:
        """
        Return the bag that a file becomes.

        :raises RuntimeError: if it cannot be imported, with what was said.
        """
        done = self.run('import', source, '--map', mapping, '--out', name)
        if done.returncode:
            raise RuntimeError(done.stderr.strip())
        return name


def _model_values(document: dict[str, Any], joint: str) -> dict[str, Any]:
    return dict(document['joints'][joint][document['model'][joint]]['parameters'])


def _text(parameter: dict[str, Any]) -> str:
    """Return a value with half of its 95 % interval."""
    value, error = parameter['value'], parameter['std_error']
    return 'open' if value is None else f'{value:.4g} ± {Z_95 * (error or math.nan):.2g}'


def _near(parameter: dict[str, Any], known: float, share: float = 0.1) -> bool:
    value = parameter['value']
    return value is not None and abs(value - known) <= share * known


def _named(document: dict[str, Any]) -> str:
    return ', '.join(f'{c["effect"]}@{c["joint"]}' for c in document['causes']) or 'nothing'


def ur10e(data: Path, tool: Tool) -> Iterator[Row]:
    """Yield friction of six joints whose URDF is wrong, and a record in which five rest."""
    record = 'UR10e 30sec_12harm'
    bag = tool.imported(data / '30sec_12harm.csv', _MAPS / 'ur10e.yaml', 'ur10e')
    # The model beside the data has the rotors that are published with them.
    base = ('--urdf', data / 'robot.urdf')
    rotors = (0.0, 3.7434, 0.0, 0.0708, 0.2342, 0.4365)
    joints = ('shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint')
    joints += tuple(f'wrist_{k}_joint' for k in (1, 2, 3))
    for joint, inertia in zip(joints, rotors, strict=True):
        base += ('--armature', f'{joint}={inertia}')
    fit = tool.told('fit', bag, *base)
    published = {
        'coulomb': (12.55, 13.27, 4.99, 2.00, 2.69, 2.30),
        'viscous': (21.26, 20.22, 10.38, 3.58, 2.49, 3.03),
    }
    bars = {('coulomb', 0): 13.6, ('viscous', 0): 19.4}
    for i, joint in enumerate(joints):
        for name in ('coulomb', 'viscous'):
            own = _model_values(fit, joint)[name]
            bar = bars.get((name, i))
            told = f'published {published[name][i]}'
            told += '' if bar is None else f', least squares {bar}'
            met = own['value'] is not None if bar is None else _near(own, bar)
            yield Row(record, f'{joint} {name} [{own["unit"]}]', told, _text(own), met)
    loads = {entry['joint']: entry['parameters'] for entry in fit['rigid_body']['loads']}
    for joint, low, high in ((joints[1], 0.05, 0.075), (joints[2], 0.055, 0.085)):
        k = loads.get(joint, {}).get('load_coefficient', {'value': None, 'std_error': None})
        inside = k['value'] is not None and low < k['value'] < high
        yield Row(record, f'{joint} k [1]', f'{low} to {high}', _text(k), inside)
    terms = tool.told('fit', bag, *base, '--terms', 'coulomb,viscous,load_dependent_friction')
    found = tool.told('diagnose', bag, *base)
    for joint in joints[:3]:
        own = terms['effort'][joint]
        left = found['gain'][joint]['inverse']['after']
        known = f'diagnose leaves {left:.3g} {own["unit"]}'
        yield Row(
            record,
            f'{joint} effort left',
            known,
            f'{own["after"]:.3g} {own["unit"]} ({100 * own["after"] / own["measured"]:.1f} %)',
            own['after'] <= left,
        )
    one = tool.imported(data / 'joint_2.csv', _MAPS / 'ur10e.yaml', 'joint_2')
    alone = tool.told('fit', one, *base)
    resting = [
        j for j in joints if j in alone['unavailable'] and 'rest' in alone['unavailable'][j]
    ]
    own = _model_values(alone, joints[1])['coulomb']
    yield Row(
        'UR10e joint_2',
        'fit: joint 2, others',
        'five rest',
        f'coulomb {_text(own)}, {len(resting)} rest',
        len(resting) == 5,
    )
    why = tool.told('diagnose', one, *base)
    rests = {c['joint'] for c in why['data_checks'] if 'rest' in c['sentence']}
    yield Row(
        'UR10e joint_2',
        'diagnose',
        'joint 2 answered, five rest',
        f'{why["verdict"]}: {_named(why)}; {len(rests & set(joints))} rest',
        why['verdict'] != 'bad_data' and len(rests & set(joints)) == 5,
    )


def damiao(data: Path, tool: Tool) -> Iterator[Row]:
    """Yield friction and ripple of a free shaft, and what a wrong velocity is accused of."""
    columns = (
        '--position',
        'position',
        '--velocity',
        'velocity',
        '--effort',
        'torque_feedback',
        '--time',
        'time',
    )
    shaft = (*columns, '--free', _SHAFT)
    runs = [data / f'motor_05_run_0{k}.npz' for k in (1, 2)]
    fit = tool.told('fit', runs[0], *shaft)
    own = _model_values(fit, 'joint')
    # Least squares took the reported velocity, which is this share of the slope of the position;
    # `fit` says the factor, and its velocity is the slope.
    share = 1.0 / 1.658
    for name, bar, unit in (
        ('coulomb', 0.096, 'Nm'),
        ('viscous', 0.0065 * share, 'Nm s/rad'),
    ):
        known = f'{bar:.2g} by plateaus'
        if name == 'viscous':
            known += f' (0.0065 per reported velocity, {share:.3f} of the slope)'
        yield Row(
            'Damiao motor 5', f'{name} [{unit}]', known, _text(own[name]), _near(own[name], bar)
        )
    why = tool.told('diagnose', runs[0], *shaft, '--holdout', runs[1])
    ripple = [c for c in why['causes'] if c['effect'] == 'cogging']
    gain = why['gain']['joint']['inverse']
    yield Row(
        'Damiao motor 5', 'ripple', '10 periods a turn', _named(why), _has_period(ripple, 10)
    )
    yield Row(
        'Damiao motor 5',
        'run 2 held out [Nm]',
        'improved',
        f'{gain["before"]:.4g} -> {gain["after"]:.4g}',
        gain['after'] < gain['before'],
    )
    slow = tool.run('fit', data / 'motor_03_run_01.npz', *columns, '--free', '0.0566')
    said = ' '.join((slow.stdout + slow.stderr).split())
    for what, word in (
        ('velocity is half its slope', 'factor of 1.9'),
        ('it saturates', 'at the limit of its speed'),
    ):
        at = said.find(word)
        begin = max(said.rfind(mark, 0, at) for mark in (': ', ', ')) + 2
        clause = said[begin : at + len(word)] if at >= 0 else 'not said'
        yield Row('Damiao motor 3', what, 'told', clause, word in said)


def _has_period(causes: list[dict[str, Any]], periods: int) -> bool:
    """Tell whether a cause has that many periods a turn, within 2 %."""
    values = [p['value'] for c in causes for p in c['parameters'].values()]
    return any(abs(x / periods - 1.0) < 0.02 for x in values if x)


def emps(data: Path, tool: Tool) -> Iterator[Row]:
    """Yield what carries over from one record of a linear axis to another."""
    first = tool.imported(data / 'DATA_EMPS.mat', _MAPS / 'emps.yaml', 'emps')
    pulses = tool.imported(data / 'DATA_EMPS_PULSES.mat', _MAPS / 'emps_pulses.yaml', 'pulses')
    why = tool.told('diagnose', first, '--holdout', pulses)
    gain = why['gain']['slider']['inverse']
    size = _rms_effort(data / 'DATA_EMPS_PULSES.mat')
    left = 100.0 * gain['after'] / size
    yield Row(
        'EMPS -> PULSES',
        'effort error [%]',
        '5.2 or less; by direction alone 5.16',
        f'{100.0 * gain["before"] / size:.2f} -> {left:.2f}; {_named(why)}',
        left <= 5.2,
    )
    alone = tool.told('diagnose', pulses)
    told = f'{alone["verdict"]}: {_named(alone)}'
    direction = any(c['effect'] == 'asymmetric_friction' for c in alone['causes'])
    yield Row('EMPS PULSES', 'diagnosed', 'friction by direction', told, direction)


def _rms_effort(path: Path) -> float:
    from scipy.io import loadmat

    values = loadmat(path)
    return float(np.sqrt(np.mean((values['gtau'].ravel()[0] * values['vir']) ** 2)))


def odrive(data: Path, tool: Tool) -> Iterator[Row]:
    """Yield the causes of a cogging motor for two inertias that the motion does not tell."""
    named = []
    for inertia in ('2.5e-4', '2.5e-5'):
        why = tool.told(
            'diagnose',
            data / 'slow2_nocomp_0.npy',
            '--time',
            '0',
            '--position',
            '1:counts',
            '--counts-per-turn',
            '8192',
            '--current',
            '2',
            '--kt',
            '0.0083',
            '--free',
            inertia,
            '--out',
            f'odrive_{inertia}',
        )
        named.append(f'{why["verdict"]}: {_named(why)}')
    yield Row(
        'ODrive nocomp_0',
        'causes, armature 2.5e-4 and 2.5e-5',
        'the same',
        ' | '.join(dict.fromkeys(named)),
        len(set(named)) == 1,
    )


#: By the folder of the data.
RECORDS: dict[str, Callable[[Path, Tool], Iterator[Row]]] = {
    'ur10e': ur10e,
    'damiao': damiao,
    'emps': emps,
    'odrive_cogging': odrive,
}


def add_data(parser: argparse.ArgumentParser) -> None:
    """Add the option that says where the records are."""
    parser.add_argument(
        '--data',
        type=Path,
        default=Path(os.environ.get('SOSML_FRICTION_DATA', '../shared/data')),
        help='folder of the records (SOSML_FRICTION_DATA, else ../shared/data)',
    )


def main() -> int:
    """Print the table as Markdown; return 1 if a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_data(parser)
    parser.add_argument('--only', help=f'one of {", ".join(RECORDS)}')
    arguments = parser.parse_args()
    missed = 0
    print('| record | what | known | found | met |\n|---|---|---|---|---|')
    with tempfile.TemporaryDirectory() as scratch:
        tool = Tool(Path(scratch))
        for name, rows in RECORDS.items():
            folder = arguments.data.resolve() / name
            if arguments.only not in (None, name):
                continue
            if not folder.is_dir():
                print(f'| {name} | | | not there: skipped | |')
                continue
            try:
                for row in rows(folder, tool):
                    missed += row.met is False
                    told = {True: 'yes', False: '**no**', None: ''}[row.met]
                    print(f'| {" | ".join(row[:4])} | {told} |'.replace('\n', ' '), flush=True)
            except (RuntimeError, KeyError) as error:
                missed += 1
                print(f'| {name} | | | stopped: {error!r} | **no** |'.replace('\n', ' '))
    return int(missed > 0)


if __name__ == '__main__':
    sys.exit(main())
