# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Files of every kind that the package reads, malformed, for the reliability run."""

from __future__ import annotations

import io
import logging
import re
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.io import savemat

from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoDbc
from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.mapping import read_mapping
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import parse_model, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.share import share_directory
from validation.silent import SilentError

Rng = np.random.Generator
JOINTS = ('shoulder', 'elbow')
#: What stands in the place of a number or a word.
HOSTILE = (
    '', '2,5', 'abc', 'nan', 'inf', '-inf', '${m}', '1_0', '0', '-1', '-0.0', '1e300', '-1e308',
    '1e999', '1e-320', '9' * 400, '0x10', '2026-13-45', '1:99', 'null', '~', 'true', '[]', '{}',
    '[1, 2', '&a [*a]', '*b', '!!python/name:os.system', '!!binary "@"', '"', "'", '\x00',
    '\ud7ff', '١٢', '<', '&amp;', '&lol;', '- - -', '? x', '%', '\t', 'a: b: c',
    '[' * 2000, '{a: ' * 200,
)  # fmt: skip
_TOKEN = re.compile(r'[A-Za-z0-9_.+-]+')
_NUMBER = re.compile(r'[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?')
_YAML_BOMB = 'aa: &aa [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'a{b}: &a{b} [{", ".join([f"*a{a}"] * 9)}]\n'
    for a, b in zip('abcdefgh', 'bcdefghi', strict=True)
)
_XML_BOMB = (
    '<!DOCTYPE r [<!ENTITY a "xxxxxxxxxx">'
    + ''.join(
        f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip('abcdefgh', 'bcdefghi', strict=True)
    )
    + ']>'
)


def malform(text: str, rng: Rng) -> str:
    """Return the text with one to three things wrong."""
    for _ in range(int(rng.integers(1, 4))):
        way, lines = int(rng.integers(9)), text.splitlines(keepends=True) or ['']
        k = int(rng.integers(len(lines)))
        places = list((_NUMBER if way < 3 else _TOKEN).finditer(text))
        if way < 5 and places:
            at = places[rng.integers(len(places))]
            text = text[: at.start()] + str(rng.choice(HOSTILE)) + text[at.end() :]
        elif way == 5:
            text = ''.join(lines[:k] + lines[k + int(rng.integers(1, 4)) :])
        elif way == 6:
            text = ''.join([*lines[:k], lines[k], *lines[k:]])
        elif way == 7:
            text = text[: rng.integers(len(text) + 1)]
        else:
            place = int(rng.integers(len(text) + 1))
            text = text[:place] + str(rng.choice(HOSTILE)) + text[place:]
    return text


def _usable(robot: Robot, where: str) -> None:
    """See that the numbers of a robot that was read are numbers, and its inertias none below 0."""
    q = np.linspace(0.3, 0.9, robot.n)
    M = robot.inertia(q)
    numbers = np.concatenate([M.ravel(), robot.gravity(q), robot.inertial_parameters().ravel()])
    # Beside 1e300 of something every other number is lost to rounding.
    if not np.isfinite(numbers).all():
        raise SilentError(f'{where} gives a robot whose numbers are none')
    if (
        np.linalg.eigvalsh(M)[0] < -1e-9 * np.abs(M).max()
        or robot.inertial_parameters()[:, 0].min() < 0.0
    ):
        raise SilentError(f'{where} gives a robot of negative inertia')


class MalformedFiles:
    """Malform one kind of file in random ways, again and again; a call is one case."""

    def __init__(self, kind: str, place: Path) -> None:
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        self.place = place
        self.config = share_directory() / 'config'
        self.nominal = read_model(self.config / 'exoskeleton')
        # What the DBC parser logs is no part of the answer.
        logging.disable()
        self.case: Callable[[Rng], object] = getattr(self, FILES[kind])
        rng = np.random.default_rng(0)
        self.time = np.arange(200) * 0.01
        self.bomb = b''
        self.columns = {name: rng.normal(size=200) for name in ('q1', 'v1', 'tau1', 'q2', 'tau2')}

    def __call__(self, rng: Rng) -> bool:
        """Run a case; whatever is read without an error is used as a command would."""
        self.case(rng)
        return False

    def _write(self, name: str, content: str | bytes) -> Path:
        path = self.place / name
        data = content.encode('utf-8', 'replace') if isinstance(content, str) else content
        path.write_bytes(data)
        return path

    def urdf(self, rng: Rng) -> None:
        text = str(self.nominal.urdf)
        if rng.random() < 0.03:
            text = _XML_BOMB + text.replace('exoskeleton', '&i;', 1)
        _usable(Robot(malform(text, rng), JOINTS, [0.005, 0.004]), 'a URDF')

    def model(self, rng: Rng) -> None:
        folder = str(rng.choice(['exoskeleton', 'emulated_exoskeleton']))
        text = (self.config / folder / 'model.yaml').read_text(encoding='utf-8')
        text = malform(text + _YAML_BOMB * int(rng.random() < 0.05), rng)
        model = replace(parse_model(text, 'model.yaml'), urdf=self.nominal.urdf)
        _usable(model.make_robot(), 'a model')
        known_terms(model)

    def parameters(self, rng: Rng) -> None:
        text = (self.config / 'exoskeleton.yaml').read_text(encoding='utf-8')
        text = text[: text.index('/**/observer_node')]
        values = read_parameters(self._write('p.yaml', malform(text, rng)), 'driver_node')
        values = {k: v for k, v in values.items() if k not in ('can_interface', 'can_channel')}
        made = DriverConfiguration.from_parameters(values)
        numbers = (made.rate, made.limit_margin, made.stop_deceleration, made.bitrate)
        if not all(0.0 <= x < 1e9 for x in numbers) or made.period_ns <= 0:
            raise SilentError(f'a parameter file gives a driver with {numbers}')

    def observers(self, rng: Rng) -> None:
        gains = {'first_order': {'gain': [80.0, 90.0]}, 'sosml': {'t1': [1.0, 2.0]}}
        text = ObserverConfiguration(JOINTS, gains).to_yaml()
        parse_configuration(malform(text, rng), 'observer_configuration')

    def dbc(self, rng: Rng) -> None:
        text = (self.config / 'elbow_servo.dbc').read_text(encoding='utf-8')
        made = ServoDbc(self._write('e.dbc', malform(text, rng)))
        target = 0.5
        back = made.decode_command(made.encode_command(ServoCommand(Mode.POSITION, 3, target)))
        if not np.isfinite(back.target):
            raise SilentError('a DBC gives a target that is no number')

    def _mapping(self, name: str) -> str:
        self._write('robot.urdf', str(self.nominal.urdf))
        return (
            f'# {name}\ntime: {{variable: t, unit: s}}\njoints:\n'
            '  shoulder:\n    position: {variable: q1, unit: rad}\n'
            '    velocity: {variable: v1, unit: rad/s}\n'
            '    effort: {variable: tau1, unit: A, scale: 1.25}\n'
            '  elbow:\n    position: {variable: q2, unit: deg}\n'
            '    effort: {variable: tau2, unit: Nm}\nurdf: robot.urdf\ntags: {worn: yes}\n'
        )

    def _read(self, path: Path, mapping: str) -> None:
        log = read_recording(path, read_mapping(self._write('map.yaml', mapping)))
        for values in (log.q, log.v, log.tau):
            if np.isinf(values).any():
                raise SilentError(f'{path.name} gives an infinite value')

    def mapping(self, rng: Rng) -> None:
        self._read(self._csv('d.csv'), malform(self._mapping('d.csv'), rng))

    def _csv(self, name: str, change: Callable[[str], str] = str) -> Path:
        rows = np.column_stack([self.time, *self.columns.values()])
        text = '\n'.join(','.join(f'{x:.6g}' for x in row) for row in rows)
        return self._write(name, change(','.join(['t', *self.columns]) + '\n' + text))

    def table(self, rng: Rng) -> None:
        self._read(self._csv('d.csv', lambda text: malform(text, rng)), self._mapping('d.csv'))

    def npz(self, rng: Rng) -> None:
        columns = {'t': self.time, **self.columns}
        stream = io.BytesIO()
        np.savez_compressed(stream, **columns)
        data = stream.getvalue()
        if rng.random() < 0.05:
            data = self.bomb = self.bomb or _array_bomb(columns)
        self._read(self._write('d.npz', _bytes(data, rng)), self._mapping('d.npz'))

    def mat(self, rng: Rng) -> None:
        stream = io.BytesIO()
        savemat(stream, {'t': self.time, **self.columns}, do_compression=bool(rng.random() < 0.5))
        self._read(self._write('d.mat', _bytes(stream.getvalue(), rng)), self._mapping('d.mat'))


def _bytes(data: bytes, rng: Rng) -> bytes:
    """Return the data with bytes changed, lost or put in."""
    way = rng.random()
    if len(data) > 1_000_000:
        return data
    if way < 0.6:
        changed = bytearray(data)
        for place in rng.integers(0, len(data), int(rng.integers(1, 6))):
            changed[place] = int(rng.integers(256))
        return bytes(changed)
    first, last = sorted(rng.integers(0, len(data), 2).tolist())
    return data[:first] + (data[last:] if way < 0.8 else b'')


def _array_bomb(columns: dict[str, np.ndarray]) -> bytes:
    """Return an NPZ file with 0.5 GB of zeros, which take a thousandth of that."""
    stream, size = io.BytesIO(), 2**29
    with zipfile.ZipFile(stream, 'w', zipfile.ZIP_DEFLATED) as archive:
        for name, values in columns.items():
            whole = io.BytesIO()
            np.save(whole, values)
            archive.writestr(f'{name}.npy', whole.getvalue())
        head = io.BytesIO()
        form = {'descr': '<f8', 'fortran_order': False, 'shape': (size // 8,)}
        np.lib.format.write_array_header_1_0(head, form)
        with archive.open('extra.npy', 'w', force_zip64=True) as entry:
            entry.write(head.getvalue())
            for _ in range(size // 2**24):
                entry.write(bytes(2**24))
    return stream.getvalue()


#: What is malformed, and the method that reads it.
FILES = {
    'URDF': 'urdf',
    'model.yaml': 'model',
    'driver parameters': 'parameters',
    'observer configuration': 'observers',
    'DBC': 'dbc',
    'mapping': 'mapping',
    'CSV': 'table',
    'NPZ': 'npz',
    'MAT': 'mat',
}
