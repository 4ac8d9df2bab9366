# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The worker of the identifier: whatever becomes of the diagnosis, the fit is kept."""

from __future__ import annotations

import math
import threading

import pytest

from sosml_friction.diagnosis import bag_diagnosis
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.nodes import fit_job
from sosml_friction.nodes.fit_job import FitJob


@pytest.fixture
def fits(monkeypatch):
    """Let every fit end at once, well; return what a job is made with and what it wrote."""
    written: list[str] = []
    analysis = object.__new__(BagAnalysis)
    monkeypatch.setattr(fit_job, 'analyse_bag', lambda *args, **kwargs: analysis)
    monkeypatch.setattr(
        fit_job, 'write_results', lambda folder, *args, **kwargs: written.append(folder.name)
    )
    return written


def finished(job: FitJob) -> FitJob:
    job.join()
    assert isinstance(job.outcome, BagAnalysis)
    assert (job.folder / 'parameters.yaml').is_file()
    return job


def test_without_being_asked_nothing_is_diagnosed(fits, tmp_path, monkeypatch):
    monkeypatch.setattr(bag_diagnosis, 'diagnose_bags', pytest.fail)
    job = finished(FitJob(tmp_path, FitSettings()))
    assert fits == ['model']
    assert job.diagnosis is None


@pytest.mark.parametrize('error', [DataError('too short'), RuntimeError('a defect')])
def test_a_diagnosis_that_fails_leaves_the_fit_and_is_told(fits, tmp_path, monkeypatch, error):
    def fail(*args, **kwargs):
        raise error

    monkeypatch.setattr(bag_diagnosis, 'diagnose_bags', fail)
    job = finished(FitJob(tmp_path, FitSettings(), diagnose=True))
    assert job.diagnosis is error
    assert not (tmp_path / 'diagnosis').exists()


def test_it_is_given_up_between_two_steps(fits, tmp_path, monkeypatch):
    steps, begun, given_up = [], threading.Event(), threading.Event()

    def diagnose(bags, without, settings, step):
        steps.append((bags, without, settings.trust))
        begun.set()
        assert given_up.wait(timeout=60.0)
        step('one more')
        steps.append('too far')

    monkeypatch.setattr(bag_diagnosis, 'diagnose_bags', diagnose)
    job = FitJob(
        tmp_path, FitSettings(), diagnose=True, without=['spring'], trust=['friction=inf']
    )
    assert begun.wait(timeout=60.0)
    job.give_up()
    given_up.set()
    finished(job)
    assert steps == [([tmp_path / 'bag'], ('spring',), {'friction': math.inf})]
    assert isinstance(job.diagnosis, ConfigurationError)
    assert 'aborted' in str(job.diagnosis)


def test_a_place_with_something_else_is_not_overwritten(fits, tmp_path, monkeypatch):
    monkeypatch.setattr(bag_diagnosis, 'diagnose_bags', pytest.fail)
    (tmp_path / 'diagnosis').mkdir()
    (tmp_path / 'diagnosis' / 'notes.txt').write_text('mine')
    job = finished(FitJob(tmp_path, FitSettings(), diagnose=True))
    assert 'not overwritten' in str(job.diagnosis)
