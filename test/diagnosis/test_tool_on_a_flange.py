# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A tool that the URDF lacks, beside the line to its last body's own centre: hidden, and found."""

import numpy as np
import pytest

import sosml_friction as sf
from validation.seven_plant import NAMES, ROTOR, Arm, place_of, recording


@pytest.fixture(scope='module')
def found():
    log, _, mass = recording(np.random.default_rng(5), 'sines', 30.0, 'payload')
    model = sf.Model.from_urdf(Arm.nominal().urdf(), dict(zip(NAMES, ROTOR.tolist(), strict=True)))
    return sf.diagnose(log, model).to_dict(), mass


def test_it_is_the_one_cause_beside_friction(found):
    document, _ = found
    assert document['verdict'] == 'named'
    causes = [c for c in document['causes'] if c['effect'] not in ('coulomb', 'viscous')]
    assert [(c['effect'], c['joint'], c['rivals']) for c in causes] == [('payload', '*', [])]


def test_its_mass_and_its_place_are_within_their_intervals(found):
    document, mass = found
    (cause,) = (c for c in document['causes'] if c['effect'] == 'payload')
    true = dict(zip('xyz', place_of(mass), strict=True)) | {'mass': mass}
    for name, value in true.items():
        low, high = cause['parameters'][name]['interval']
        assert low < value < high
        # A quarter of the mass, and 5 cm.
        assert high - low < (0.25 * mass if name == 'mass' else 0.05)
