# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every test can ask for."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from scipy.io import loadmat

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.cli import main as cli
from sosml_friction.model.robot import Robot
from sosml_friction.report.common import figure
from sosml_friction.study.run import Study, StudySettings, run_study

REPOSITORY = Path(__file__).resolve().parent.parent
# gw0, gw1, ... in a process that runs its share of the tests (pytest -n), empty in any other.
WORKER = os.environ.get('PYTEST_XDIST_WORKER', '')
# The niceness of a worker's tests that do not need to be on time.
BEHIND = min(os.getpriority(os.PRIO_PROCESS, 0) + 5, 19)

# The first example of a test may have to compile; no test judges by the clock, none draws a seed.
settings.register_profile('no_clock', deadline=None, derandomize=True)
settings.load_profile('no_clock')

# Files of one value here are one worker's: nodes run in real time, and would rob each other of it;
# a study is run once for all who look at it.
TOGETHER = {'study/test_run.py': 'study', 'study/test_report.py': 'study'}


def is_of_nodes(path: Path) -> bool:
    return path.parent.name == 'nodes'


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes(specs: list[Any]) -> None:
    """Say what is each worker's own before it is started."""
    domain = os.environ.get('ROS_DOMAIN_ID')
    for number, spec in enumerate(specs):
        # The other cores are the other workers'.
        spec.env.setdefault('OPENBLAS_NUM_THREADS', '1')
        if number and domain is not None:
            # Nodes of one worker do not hear those of another: strides meet after 101, a prime.
            spec.env['ROS_DOMAIN_ID'] = str((int(domain) - 1 + 37 * number) % 101 + 1)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Deal the tests out to the workers by file, except for those that belong together."""
    if config.getoption('dist') != 'loadfile':
        return None
    from xdist.scheduler import LoadFileScheduling

    class Together(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = Path(super()._split_scope(nodeid))
            return (
                'nodes'
                if is_of_nodes(file)
                else TOGETHER.get('/'.join(file.parts[-2:]), str(file))
            )

    # In the order of collection, not by the number of tests in a file.
    config.option.loadscopereorder = False
    return Together(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the nodes, which take longest to wait for."""
    if WORKER:
        items.sort(key=lambda item: not is_of_nodes(item.path))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let the nodes of another worker go first: they have to keep their rate, the rest has not."""
    if WORKER and not is_of_nodes(item.path):
        os.setpriority(os.PRIO_PROCESS, 0, BEHIND)


@pytest.fixture(scope='session')
def data_directory() -> Path:
    """Return the folder of measured data: SOSML_FRICTION_DATA, or ../shared/data."""
    directory = Path(os.environ.get('SOSML_FRICTION_DATA') or REPOSITORY / '../shared/data')
    if not directory.is_dir():
        pytest.skip(f'no measured data at {directory}: set SOSML_FRICTION_DATA')
    return directory.resolve()


@pytest.fixture(scope='session')
def emps_record(data_directory: Path) -> dict[str, Any]:
    """Return the variables of the measured EMPS record."""
    return loadmat(data_directory / 'emps/DATA_EMPS.mat', squeeze_me=True)


@pytest.fixture(scope='session')
def emps_log(emps_record: dict[str, Any]) -> JointLog:
    """Return it as position and force, without velocity."""
    q = emps_record['qm'][:, None]
    effort = float(emps_record['gtau']) * emps_record['vir'][:, None]
    t_ns = np.round(emps_record['t'] * 1e9).astype(np.int64)
    return JointLog(('slider',), t_ns, q, np.full_like(q, np.nan), effort)


@pytest.fixture
def sosml(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs the tool in an empty folder: (exit code, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> tuple[int, str, str]:
        code = cli.main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture
def refused(sosml: Callable[..., tuple[int, str, str]], tmp_path: Path) -> Callable[..., str]:
    """Return a function that expects exit code 2, one sentence, and nothing written."""

    def run(*arguments: object) -> str:
        before = sorted(tmp_path.rglob('*'))
        code, out, err = sosml(*arguments)
        assert code == 2
        assert out == ''
        assert err.startswith('sosml: ')
        assert err.count('\n') == 1
        assert 'Traceback' not in err
        assert sorted(tmp_path.rglob('*')) == before
        return err

    return run


def serial_arm(types: list[str], seed: int = 0) -> str:
    """Return the URDF of a serial arm of random axes, offsets and (valid) inertias."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="chain"><link name="l0"/>']
    for k, kind in enumerate(types, start=1):
        # The inertia of eight point masses is positive definite and obeys the triangle rule.
        points = rng.normal(scale=0.08, size=(8, 3))
        points -= points.mean(0)
        mass = rng.uniform(0.5, 3.0)
        tensor = mass / 8 * (np.sum(points**2) * np.eye(3) - points.T @ points)
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        text = [' '.join(f'{x:.17g}' for x in rng.uniform(-0.3, 0.3, size=3)) for _ in range(3)]
        entries = zip(
            ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), tensor[np.triu_indices(3)], strict=True
        )
        parts.append(
            f'<link name="l{k}"><inertial><origin xyz="{text[0]}"/><mass value="{mass:.17g}"/>'
            f'<inertia {" ".join(f"{name}={chr(34)}{x:.17g}{chr(34)}" for name, x in entries)}/>'
            f'</inertial></link><joint name="j{k}" type="{kind}"><parent link="l{k - 1}"/>'
            f'<child link="l{k}"/><origin xyz="{text[1]}" rpy="{text[2]}"/>'
            f'<axis xyz="{" ".join(f"{x:.17g}" for x in axis)}"/>'
            f'<limit lower="-{k}" upper="{k}" effort="{10 * k}" velocity="{2 * k}"/></joint>'
        )
    return ''.join(parts) + '</robot>'


@pytest.fixture(scope='session')
def make_serial_arm() -> Callable[..., str]:
    return serial_arm


@pytest.fixture(scope='session')
def seven_joints() -> Robot:
    """Return an arm of seven joints, one of them prismatic, with rotors."""
    urdf = serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    return Robot(urdf, [f'j{k}' for k in range(1, 8)], np.linspace(0.01, 0.07, 7))


@pytest.fixture(scope='session')
def tiny_study() -> Study:
    """Return the paper's study with three observers, few evaluations and a coarse plant."""
    settings = StudySettings(
        observers=('first_order_capped', 'sosml', 'kalman'),
        seeds=3,
        tuning_seeds=1,
        evaluations=16,
        plant_step=200e-6,
    )
    return run_study(settings, processes=1)


@pytest.fixture(scope='module', autouse=True)
def pictures_are_left_blank(request):
    """
    Make the figures of reports, and leave out that Matplotlib renders them.

    It is a third of the time of a command; test/report judges what a report looks like.
    """
    with pytest.MonkeyPatch.context() as patch:
        if 'report' not in request.path.parts:
            patch.setattr(figure, 'to_svg', lambda *_: '<svg data-axes="[]"></svg>')
        yield
