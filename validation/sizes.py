# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Are the sizes of named causes right within their errors, effect by effect?

    python -m validation.sizes blind_campaign

prints the table of a campaign that was run. A parameter of the nominal model that is off has the
size of all that it is off by, its 1 to 3 % included; every other effect that of what was hidden.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from validation import plant as bp
from validation.judge import match
from validation.trial import JOINTS, Trial, Truth

Row = dict[str, Any]


def true_values(trial: Trial) -> dict[str, float]:
    """Return what the parameters of a right answer should be, by the names that it gives them."""
    truth = trial.truths[0]
    i = JOINTS.index(truth.joint) if truth.joint in JOINTS else 0
    hidden, plant = trial.exact, trial.plant
    p = {name: float(values[i]) for name, values in hidden.joint.items()}
    if truth.effect in ('coulomb', 'viscous'):
        nominal = {'coulomb': bp.COULOMB, 'viscous': bp.VISCOUS}[truth.effect][i]
        return {'change': float(plant.joint[truth.effect][i] - nominal)}
    if truth.effect == 'inertia':
        return {'change': _turning(plant, i) - _turning(bp.Plant(), i)}
    if truth.effect == 'gravity':
        own = plant.second if i else plant.first + plant.mass_2 * bp.L1
        nominal = bp.C2 if i else bp.C1 + bp.M2 * bp.L1
        return {'first_moment_1': own - nominal}
    if truth.effect == 'effort_saturation':
        return {'limit': float(hidden.saturation[i])}
    return {
        'stribeck': {
            'stribeck': p['stribeck'],
            'stribeck_velocity': p['stribeck_velocity'],
            'exponent': p['stribeck_exponent'],
        },
        'asymmetric_friction': {'viscous_asymmetry': p['asymmetry_viscous']},
        'load_dependent_friction': {'load_coefficient': p['load']},
        'position_dependent_friction': {
            'cosine': p['position'] * np.cos(p['position_phase']),
            'sine': -p['position'] * np.sin(p['position_phase']),
        },
        'cogging': {
            'cosine': p['cogging'] * np.cos(p['cogging_phase']),
            'sine': -p['cogging'] * np.sin(p['cogging_phase']),
            'frequency': p['cogging_cycles'],
        },
        'hysteresis': {'level': p['hose']},
        'joint_elasticity': {'stiffness': p['stiffness']},
        'backlash': {'gap': p['gap']},
        'effort_scale': {'error': float(hidden.scale[i]) - 1.0},
        'effort_bias': {'bias': float(hidden.bias[i])},
        'effort_delay': {'delay': hidden.delay},
        # About the joints' axis, of which only the horizontal part turns gravity.
        'gravity_tilt': {'rotation_y': hidden.tilt * bp.GRAVITY / 9.81},
        'payload': {'mass': hidden.payload, 'x': hidden.payload_distance, 'y': 0.0},
        'joint_coupling': {'coupling': hidden.coupling},
        'spring': {'stiffness': p['spring'], 'offset': -p['spring'] * p['spring_zero']},
    }.get(truth.effect, {})  # fmt: skip


def _turning(plant: bp.Plant, i: int) -> float:
    """Return what a rotor stands for: of the first joint, all that no position changes."""
    rotor = float(plant.joint['armature'][i])
    return rotor if i else rotor + plant.inertia[0] + plant.mass_2 * bp.L1**2


def judged_sizes(row: Row) -> list[Row]:
    """Return each parameter of a rightly named cause beside its true value."""
    if row['kind'] != 'single' or not row.get('true') or not row['causes']:
        return []
    truth = Truth(**row['truths'][0])
    result = []
    for cause, parameters in zip(row['causes'], row['parameters'], strict=True):
        if not match(cause, truth) or cause['effect'] != truth.effect:
            continue
        true = dict(row['true'])
        if 'limit' in true and 'excess' in parameters:
            # By the definition of the parameter: what is reported beyond the reference.
            reference, limit = parameters['reference']['value'], true.pop('limit')
            true['excess'] = limit * np.arctanh(min(reference / limit, 0.98)) - reference
        for name, value in true.items():
            p = parameters.get(name)
            if p is None:
                continue
            sign = 1.0
            if name == 'rotation_y':
                # Which way is positive depends on the frame.
                sign = float(np.sign(p['value'] * value) or 1.0)
            low, high = _ends(p)
            result.append(
                {
                    'trial': row['spec']['name'], 'effect': truth.effect, 'parameter': name,
                    'true': sign * value, 'value': p['value'], 'low': low, 'high': high,
                    'std_error': p['std_error'], 'stated': cause.get('size_known', True),
                }
            )  # fmt: skip
        return result
    return result


def _ends(p: Row) -> tuple[float, float]:
    """Return an interval of two standard errors, or the range that is stated."""
    if p.get('interval') and p.get('flags'):
        low, high = p['interval']
        return -np.inf if low is None else low, np.inf if high is None else high
    error = np.nan if p['std_error'] is None else 2.0 * p['std_error']
    return p['value'] - error, p['value'] + error


def sizes_table(rows: Iterable[Row]) -> str:
    """Return the share of sizes within two standard errors, by effect and parameter."""
    found = [one for row in rows for one in judged_sizes(row)]
    lines = [
        '| effect | parameter | n | within 2 standard errors | found / true, median and extremes |'
        ' standard error / true, median | stated |',
        '|---|---|---|---|---|---|---|',
    ]
    for effect, name in dict.fromkeys((x['effect'], x['parameter']) for x in found):
        own = [x for x in found if (x['effect'], x['parameter']) == (effect, name)]
        inside = sum(x['low'] <= x['true'] <= x['high'] for x in own)
        ratios = sorted(x['value'] / x['true'] for x in own if x['true'])
        errors = [abs((x['std_error'] or np.nan) / x['true']) for x in own if x['true']]
        spread = f'{median(ratios):.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f}' if ratios else ''
        lines.append(
            f'| {effect} | {name} | {len(own)} | {inside} | {spread} | '
            f'{median(errors) if errors else np.nan:.3f} | '
            f'{"yes" if all(x["stated"] for x in own) else "no: present only"} |'
        )
    stated = [x for x in found if x['stated']]
    inside = sum(x['low'] <= x['true'] <= x['high'] for x in stated)
    lines.append(f'\nOf the sizes that are stated, {inside} of {len(stated)} are within.')
    return '\n'.join(lines)


def main() -> int:
    """Print the table of a campaign."""
    parser = argparse.ArgumentParser(prog='python -m validation.sizes', description=__doc__)
    parser.add_argument('campaign', type=Path, help='OUT of a campaign: trials/*.json are read')
    rows = [
        json.loads(path.read_text())
        for path in sorted((parser.parse_args().campaign / 'trials').glob('*.json'))
    ]
    print(sizes_table(rows))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
