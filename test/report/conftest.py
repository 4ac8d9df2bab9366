# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording of the exoskeleton whose friction is known, and its analysis."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.identification.several.consolidation import (
    BagRole,
    Consolidation,
    consolidate,
)
from sosml_friction.identification.term_fit import TermFit, fit_terms
from sosml_friction.model.model_folder import RobotModelFile, read_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.report.fit.html import render_report
from sosml_friction.share import share_directory
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation

ROLES = {
    'ladder': BagRole('T1', 'stated', 'stated'),
    'slow': BagRole('T3', 'stated', 'stated'),
}


@pytest.fixture(scope='session')
def truth() -> RobotModelFile:
    """Return the model whose friction is in the recording."""
    return read_model(share_directory() / 'config' / 'emulated_exoskeleton')


@pytest.fixture(scope='session')
def record_exoskeleton(truth: RobotModelFile) -> Callable[..., Path]:
    """Return a maker of recordings of a short speed ladder: inverse dynamics plus friction."""

    def make(folder: Path, elbow_effort: bool = True) -> Path:
        robot, laws = truth.make_robot(), truth.friction_laws()
        ladder = speed_ladder(
            {'shoulder': 0.4, 'elbow': 0.6},
            {'shoulder': 0.5, 'elbow': 0.7},
            [0.03, 0.08, 0.2, 0.5],
            plateau_s=0.6,
        )
        spline = ladder.spline()
        t = np.arange(0.0, ladder.duration, 0.002)
        q, v, a = spline(t), spline(t, 1), spline(t, 2)
        noise = np.random.default_rng(1)
        tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
        tau += np.column_stack([law.torque(v[:, i]) for i, law in enumerate(laws)])
        tau += noise.normal(0.0, 0.02, tau.shape)
        if not elbow_effort:
            tau[:, 1] = np.nan
        q = q + noise.normal(0.0, 2e-5, q.shape)
        v = v + noise.normal(0.0, 2e-3, v.shape)
        log = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)
        nominal = share_directory() / 'config' / 'exoskeleton' / 'model.yaml'
        return write_joint_log(log, folder, truth.urdf, nominal.read_text(encoding='utf-8'))

    return make


@pytest.fixture(scope='session')
def analysis(
    record_exoskeleton: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> BagAnalysis:
    """Return the analysis of a recording of both joints, by two observers."""
    bag = record_exoskeleton(tmp_path_factory.mktemp('bags') / 'ladder')
    return analyse_bag(bag, settings=FitSettings(method='segments'))


@pytest.fixture(scope='session')
def one_joint_analysis(
    record_exoskeleton: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> BagAnalysis:
    """Return the usual analysis, with the weak form, of a bag whose elbow reports no effort."""
    return analyse_bag(record_exoskeleton(tmp_path_factory.mktemp('bags') / 'mute', False))


@pytest.fixture(scope='session')
def rejecting_analysis(analysis: BagAnalysis) -> BagAnalysis:
    """Return the analysis as if some windows had not been used, for two reasons and a third."""
    reasons = {1: 'speed ripples by 9 %', 2: 'speed ripples by 12 %', 4: 'steady for < 0.1 s'}
    joints = {}
    for joint, fits in analysis.fit.joints.items():
        segments = tuple(
            dataclasses.replace(segment, rejected=reasons.get(k, segment.rejected))
            for k, segment in enumerate(next(iter(fits.values())).segments)
        )
        joints[joint] = {o: dataclasses.replace(f, segments=segments) for o, f in fits.items()}
    return dataclasses.replace(analysis, fit=dataclasses.replace(analysis.fit, joints=joints))


@pytest.fixture(scope='session')
def fit_page(rejecting_analysis: BagAnalysis, truth: RobotModelFile) -> str:
    """Return the report of the fit, with pictures."""
    return render_report(rejecting_analysis, truth, {'seed': '<7>'})


@pytest.fixture(scope='session')
def bags(analysis: BagAnalysis) -> BagsAnalysis:
    """Return two recordings, the second of the shoulder alone: the same motion, other labels."""
    joints = {'shoulder': analysis.fit.joints['shoulder']}
    rows = {'shoulder': analysis.fit.rows['shoulder']}
    fit = dataclasses.replace(
        analysis.fit,
        joints=joints,
        alternatives={},
        rows=rows,
        unavailable={'elbow': 'the recording has no effort of it'},
    )
    second = dataclasses.replace(analysis, fit=fit)
    recordings = {'ladder': analysis.fit, 'slow': fit}
    found = {
        joint: {'sosml': consolidate(joint, 'sosml', 'Nm', recordings, ROLES)}
        for joint in ('shoulder', 'elbow')
    }
    consolidation = Consolidation(
        ('ladder', 'slow'), ROLES, found, dict.fromkeys(('shoulder', 'elbow'), 'sosml')
    )
    return BagsAnalysis({'ladder': analysis, 'slow': second}, consolidation, analysis.model)


@pytest.fixture(scope='session')
def diagnosis() -> Diagnosis:
    """Return that of a slider with a constant in its effort: a bias, an asymmetry or a spring."""
    log = slider_recording(lambda v: 4.0 + 0.0 * v, seed=1)
    return diagnose([log], slider_model())


@pytest.fixture(scope='session')
def fitted_terms() -> TermFit:
    """Return Coulomb and viscous friction fitted to the slider."""
    log = slider_recording(lambda v: 0.0 * v, seed=1)
    return fit_terms([log], slider_model(), ['m1'])


@pytest.fixture(scope='session')
def simulated() -> RecordedSimulation:
    """Return the slider simulated in windows."""
    log = slider_recording(lambda v: 0.0 * v, seed=1)
    return simulate_model(log, slider_model(), {}, 0.3)
