# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The campaign of blind trials against every bar of it, one test each.

Of 60 single effects of SNR 0.6 and more, in ``make validate`` alone: 300 diagnoses, about an hour
on two cores. The seed is SOSML_FRICTION_BLIND_SEED, else
fresh, and printed; with the same seed a run that was stopped goes on. All is written to
blind_campaign/ before the first bar is looked at.
"""

from __future__ import annotations

import os
import secrets
from pathlib import Path

import pytest
from full_runs import only_full

from validation.bars import bars
from validation.campaign import run_campaign
from validation.tables import tables

TRIALS = 60
FOLDER = Path('blind_campaign')
NAMES = [bar.name for bar in bars([])]

pytestmark = only_full


@pytest.fixture(scope='module')
def campaign():
    """Return the bars of a campaign, by name."""
    seed = int(os.environ.get('SOSML_FRICTION_BLIND_SEED') or secrets.randbelow(10**6))
    print(f'SOSML_FRICTION_BLIND_SEED={seed}')
    rows = run_campaign(seed, TRIALS, FOLDER, say=lambda text: print(text, flush=True))
    print(tables(rows, bars(rows), seed, TRIALS))
    return {bar.name: bar for bar in bars(rows)}


@pytest.mark.parametrize('name', NAMES)
def test_the_campaign_meets_the_bar(campaign, name):
    bar = campaign[name]
    assert bar.met, f'{bar.demand}: it is {bar.value:.3g}, n = {bar.n}: {bar.text}'
