# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml fleet``: every recording of a folder by itself, here and on a Dask cluster."""

import csv
import os
import shutil
import signal
import socket
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest
from slider_bags import checked

from sosml_friction.cli.fleet import Done, find_recordings, run_one, split_words, why_not
from sosml_friction.exceptions import ConfigurationError

ROBOT = ('--free', '0.2', '--position', 'q', '--effort', 'tau')
#: The rotor is what the effort was made with, and one observer and one way of fitting will do.
QUICK = ('--observers', 'sosml', '--method', 'segments', '--body-tolerance', '0')


def write_recording(path, seed, day):
    """Write 20 s of a shaft that turns to and fro at three speeds, with C 0.4 and B 0.1."""
    rng, h = np.random.default_rng(seed), 0.01
    v = np.concatenate(
        [way * speed * np.ones(330) for speed in (0.2, 0.6, 1.2) for way in (1.0, -1.0)]
    )
    v = np.convolve(v, np.hanning(31) / np.hanning(31).sum(), mode='same')
    q = np.cumsum(v) * h
    tau = 0.2 * np.gradient(v, h) + 0.4 * np.sign(v) + 0.1 * v
    t = 1.7e9 + 86400.0 * day + np.arange(len(q)) * h
    q, tau = q + 1e-5 * rng.standard_normal(len(q)), tau + 0.01 * rng.standard_normal(len(q))
    path.parent.mkdir(exist_ok=True, parents=True)
    np.savez(path, t=t, q=q, tau=tau)


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp('fleet') / 'recordings'
    for day, name in enumerate(('monday', 'tuesday', 'week/monday')):
        write_recording(folder / f'{name}.npz', day, day)
    (folder / 'notes.csv').write_text('remark,number\nworn,1\n')
    return folder


@pytest.fixture(scope='module')
def results(recordings, tmp_path_factory):
    """
    Return the folder of a fit of all and what the command ended with.

    Two workers of a real Dask scheduler do it; the first that is busy is killed.
    """
    distributed = pytest.importorskip('distributed')
    place = tmp_path_factory.mktemp('fleet')
    with socket.create_server(('127.0.0.1', 0)) as server:
        port = server.getsockname()[1]
    address, processes = f'tcp://127.0.0.1:{port}', []

    def start(*command):
        log = (place / f'{len(processes)}.log').open('wb')
        processes.append(subprocess.Popen([sys.executable, *command], stdout=log, stderr=log))

    start('-m', 'distributed.cli.dask_scheduler', '--host', '127.0.0.1', '--port', str(port),
          '--no-dashboard')  # fmt: skip
    worker = ('-m', 'distributed.cli.dask_worker', address, '--nthreads', '1', '--no-nanny',
              '--no-dashboard', '--host', '127.0.0.1')  # fmt: skip
    start(*worker)
    start(*worker)
    asked = ['fleet', 'fit', str(recordings), '--out', str(place / 'results')]
    asked += [*ROBOT, *QUICK, '--json']
    try:
        with distributed.Client(address, timeout='60s') as client:
            client.wait_for_workers(2, timeout=60)
            fleet = subprocess.Popen(
                [sys.executable, '-m', 'sosml_friction.cli.main', *asked, '--scheduler', address],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            busy = []
            while not busy and fleet.poll() is None:
                busy = [name for name, tasks in client.processing().items() if tasks]
            victim = client.run(os.getpid, workers=busy[:1])[busy[0]]
            os.kill(victim, signal.SIGKILL)
            out, said = fleet.communicate(timeout=300)
    finally:
        for process in processes:
            process.kill()
            process.wait()
    return place / 'results', subprocess.CompletedProcess(asked, fleet.returncode, out, said)


def test_no_recording_is_lost_with_a_worker_that_is_killed_and_one_table_has_all(results):
    out, ended = results
    assert ended.returncode == 1
    document = checked(ended.stdout, 'fleet')
    for name in ('monday', 'tuesday', 'week_monday'):
        assert (out / name / 'report.html').is_file()
        (row,) = (
            r for r in document['rows'] if r['recording'] == name and r['quantity'] == 'coulomb'
        )
        assert row['low'] < 0.4 < row['high']
    with (out / 'fleet.csv').open() as file:
        assert len(list(csv.DictReader(file))) == len(document['rows'])
    drift = next(d for d in document['drifts'] if d['quantity'] == 'coulomb')
    assert drift['recordings'] == 3
    assert drift['half_width'] > abs(drift['per_day'])


def test_a_recording_that_cannot_be_fitted_is_named_with_its_reason_and_stops_no_other(results):
    document = checked(results[1].stdout, 'fleet')
    (failed,) = (row for row in document['rows'] if row['quantity'] == 'failed')
    assert failed['recording'] == 'notes'
    assert 'q' in failed['told']
    assert failed['told'] in results[1].stderr


def test_what_has_a_result_is_not_fitted_again(results, recordings, sosml):
    out, _ = results
    before = {path: path.stat().st_mtime_ns for path in out.glob('*/fit.json')}
    code, text, _ = sosml('fleet', 'fit', recordings, '--out', out, *ROBOT)
    assert code == 1
    assert 'coulomb' in text
    assert {path: path.stat().st_mtime_ns for path in out.glob('*/fit.json')} == before


def test_options_of_the_fleet_are_not_handed_on(sosml, recordings, tmp_path):
    code, _, said = sosml('fleet', 'fit', tmp_path)
    assert code == 2
    assert 'no bag and no table' in said
    code, _, said = sosml('fleet', 'fit', recordings, '--jobs', '1', '--scheduler', 'tcp://x:1')
    assert code == 2
    assert '--jobs' in said
    code, _, said = sosml('fleet', 'fit', recordings, '--scheduler', 'tcp://127.0.0.1:9')
    assert code == 2
    assert 'no Dask scheduler answers at tcp://127.0.0.1:9' in said


def test_recordings_of_one_name_are_told_apart_and_results_are_none(tmp_path):
    names = (
        'a.npz',
        'a.csv',
        'out/b.npz',
        '.hidden/c.npz',
        'deep/down/d.npz',
        'fleet.csv',
        'e/f.npz',
        'e_f.npz',
        'old/fit.json',
        'old/segments.csv',
        'old/figures/x.csv',
    )
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    found = find_recordings(tmp_path, (tmp_path / 'out').resolve())
    assert sorted(found) == ['a.csv', 'a.npz', 'deep_down_d', 'e__f.npz', 'e_f.npz']
    assert found['e__f.npz'] == tmp_path / 'e_f.npz'
    with pytest.raises(ConfigurationError, match='is no folder'):
        find_recordings(tmp_path / 'a.npz', tmp_path)


@pytest.mark.parametrize(
    ('files', 'names'),
    [
        (('metadata.yaml', 'x_0.mcap', 'x_1.mcap'), {'run'}),
        (('day/day_0.mcap', 'day/day_1.mcap'), {'day'}),
        (('day/left.mcap', 'day/right.mcap'), {'day_left', 'day_right'}),
        (('day/x_0.mcap.zstd',), {'day'}),
    ],
)
def test_a_folder_is_one_bag_where_it_says_so_or_its_files_are_numbered(tmp_path, files, names):
    for name in files:
        (tmp_path / 'run' / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / 'run' / name).touch()
    assert set(find_recordings(tmp_path / 'run', tmp_path / 'out')) == names


@pytest.mark.parametrize(
    ('words', 'handed'),
    [
        (('arm', '--model', 'arm', '--effort-hold=end'), ['--model', 'arm', '--effort-hold=end']),
        (('--model', 'arm', 'arm'), ['--model', 'arm']),
        (('--model=x=y', 'arm', '--asymmetric'), ['--model=x=y', '--asymmetric']),
    ],
)
def test_the_folder_may_stand_before_and_behind_the_options(words, handed):
    assert split_words('fit', words) == (Path('arm'), handed)


@pytest.mark.parametrize(
    ('words', 'told'),
    [
        (('--modle', 'arm'), 'no such option: --modle'),
        (('one', 'two'), 'one and two are 2'),
        (('--model', 'arm'), 'give the folder'),
    ],
)
def test_words_that_mean_nothing_end_it_before_any_recording(sosml, words, told):
    code, _, said = sosml('fleet', 'fit', *words)
    assert code == 2
    assert told in said


def test_results_of_another_command_are_not_mixed_with_its_own(sosml, recordings, tmp_path):
    (tmp_path / 'monday').mkdir()
    (tmp_path / 'monday' / 'diagnosis.json').write_text('{}')
    code, _, said = sosml('fleet', 'fit', recordings, '--out', tmp_path, *ROBOT)
    assert code == 2
    assert 'results of sosml fleet diagnose' in said
    assert not (tmp_path / 'fleet.csv').exists()


def test_fitted_terms_make_a_table_and_a_result_that_is_broken_is_told(
    sosml, recordings, tmp_path, monkeypatch
):
    broken = tmp_path / 'out' / 'tuesday'
    broken.mkdir(parents=True)
    (broken / 'fit.json').write_text('{')
    (tmp_path / 'recs').mkdir()
    for name in ('monday', 'tuesday'):
        shutil.copy(recordings / f'{name}.npz', tmp_path / 'recs')
    monkeypatch.chdir(tmp_path)
    code, text, said = sosml(
        'fleet', 'fit', '--terms', 'coulomb,viscous', *ROBOT, 'recs', '--out', 'out', '--json'
    )
    assert code == 1
    assert '1 of 2 recordings have a result' in said
    rows = {(r['recording'], r['quantity']): r for r in checked(text, 'fleet')['rows']}
    found = rows['monday', 'coulomb']
    assert found['low'] < 0.4 < found['high']
    assert found['date'] == '2023-11-14T22:13:20+00:00'
    assert 'cannot be read' in rows['tuesday', 'failed']['told']


def test_paths_among_options_begin_where_the_fleet_was_called(tmp_path):
    asked = ('fit', str(tmp_path / 'x.csv'), str(tmp_path / 'out'), ['--urdf', 'own.urdf'])
    (tmp_path / 'x.csv').write_text('t,q\n0,1\n')
    (tmp_path / 'own.urdf').write_text('<robot')
    here = run_one(*asked, str(tmp_path))
    elsewhere = run_one(*asked, str(tmp_path / 'gone'))
    assert here.code == elsewhere.code == 2
    assert here.said != elsewhere.said


def test_a_command_that_is_killed_says_the_signal_and_not_its_last_remark():
    future = Future()
    future.set_result(Done(-9, 'the recording is long'))
    assert why_not('fit', future) == 'sosml fit was ended by signal 9'
    lost = Future()
    lost.set_exception(RuntimeError('no worker'))
    assert why_not('fit', lost) == 'RuntimeError: no worker'
