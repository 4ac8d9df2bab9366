# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The table of a fleet, from the documents of its recordings."""

import csv
import io

import pytest

from sosml_friction.report.fleet.rows import (
    COLUMNS,
    diagnosis_rows,
    drifts,
    failed_row,
    fit_rows,
    joint_tables,
    rows_csv,
)


def parameter(value, interval, flags=()):
    error = None if value is None else 0.01
    return {
        'value': value, 'std_error': error, 'unit': 'Nm', 'flags': flags, 'interval': interval
    }  # fmt: skip


def fitted(start_ns, coulomb):
    return {
        'bags': [{'start_ns': start_ns}],
        'joints': {
            'elbow': {
                'sosml': {'parameters': {'coulomb': parameter(9.0, [8.0, 10.0])}},
                'weak_form': {
                    'parameters': {
                        'coulomb': parameter(coulomb, [coulomb - 0.02, coulomb + 0.02]),
                        'stribeck': parameter(None, [0.0, None], ('not_identifiable',)),
                    }
                },
            }
        },
        'unavailable': {'wrist': 'the recording has no effort of it'},
    }


DAY = 86400 * 10**9
START = 1_699_920_000 * 10**9


def test_a_fit_s_rows_are_those_of_the_fit_to_use_and_say_why_a_joint_has_none():
    rows = fit_rows('monday', 'arm', fitted(START, 0.4))
    assert [(r.joint, r.quantity, r.value) for r in rows] == [
        ('elbow', 'coulomb', 0.4),
        ('elbow', 'stribeck', None),
        ('wrist', 'friction', None),
    ]
    assert rows[1].told == 'not identifiable'
    assert rows[2].told == 'the recording has no effort of it'
    assert rows[0].date == '2023-11-14T00:00:00+00:00'


def test_a_diagnosis_has_a_row_for_its_verdict_and_one_for_each_number_of_a_cause():
    document = {
        'verdict': 'named',
        'sentence': 'Named: elbow: backlash.',
        'provenance': {'bags': [{'start_ns': 5}]},
        'causes': [
            {'effect': 'backlash', 'joint': 'elbow', 'parameters': {'gap': parameter(0.1, None)}}
        ],
    }
    verdict, gap = diagnosis_rows('monday', 'arm', document)
    assert verdict.told == 'named: Named: elbow: backlash.'
    assert (gap.quantity, gap.value, gap.low) == ('backlash gap', 0.1, None)


def test_a_csv_has_every_row_and_reads_back():
    rows = [*fit_rows('a, "b"', 'arm', fitted(0, 0.4)), failed_row('c', 'no effort')]
    read = list(csv.DictReader(io.StringIO(rows_csv(rows))))
    assert tuple(read[0]) == COLUMNS
    assert [r['recording'] for r in read] == ['a, "b"'] * 3 + ['c']
    assert float(read[0]['high']) == pytest.approx(0.42)
    assert read[-1]['told'] == 'no effort'


def test_three_recordings_of_a_joint_tell_its_drift():
    rows = [
        row
        for day, coulomb in enumerate((0.40, 0.50, 0.60))
        for row in fit_rows(f'day {day}', 'arm', fitted(START + day * DAY, coulomb))
    ]
    found = drifts(rows)
    assert list(found) == [('arm', 'elbow', 'coulomb', 'Nm')]
    assert found['arm', 'elbow', 'coulomb', 'Nm'].slope == pytest.approx(0.1)


def test_a_time_since_some_start_is_no_date_and_no_drift():
    rows = [r for day in range(3) for r in fit_rows(f'{day}', 'arm', fitted(day * DAY, 0.4))]
    assert {row.date for row in rows} == {''}
    assert {line[1] for line in joint_tables(rows)['arm', 'elbow']} == {'no date'}
    assert drifts(rows) == {}


def test_the_terminal_s_lines_go_by_quantity_and_date_and_show_open_ranges():
    rows = [
        *fit_rows('late', 'arm', fitted(START + DAY, 0.41)),
        *fit_rows('early', 'arm', fitted(START, 0.4)),
    ]
    assert joint_tables(rows)['arm', 'elbow'] == [
        ['coulomb', '2023-11-14', 'early', '0.400 ± 0.020', 'Nm'],
        ['', '2023-11-15', 'late', '0.410 ± 0.020', 'Nm'],
        ['stribeck', '2023-11-14', 'early', '0 to open', 'Nm'],
        ['', '2023-11-15', 'late', '0 to open', 'Nm'],
    ]
