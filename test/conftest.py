# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every test can ask for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parent.parent


@pytest.fixture(scope='session')
def data_directory() -> Path:
    """Return the folder of measured data: SOSML_FRICTION_DATA, or ../shared/data."""
    directory = Path(os.environ.get('SOSML_FRICTION_DATA') or REPOSITORY / '../shared/data')
    if not directory.is_dir():
        pytest.skip(f'no measured data at {directory}: set SOSML_FRICTION_DATA')
    return directory.resolve()
