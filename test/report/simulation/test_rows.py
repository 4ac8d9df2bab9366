# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of a simulation as a person reads them."""

from __future__ import annotations

import pytest

from sosml_friction.report.simulation.document import percent_text


@pytest.mark.parametrize(
    ('share', 'text'),
    [
        (0.000757, '0.000757 %'),
        (0.0138, '0.0138 %'),
        (4.443, '4.44 %'),
        (44.7, '44.7 %'),
        (405.6, '406 %'),
        (2172.7, '2173 %'),
        (0.0, '0.00 %'),
        (float('nan'), '-'),
    ],
)
def test_a_share_has_three_digits_and_no_power_of_ten(share, text):
    assert percent_text(share) == text
