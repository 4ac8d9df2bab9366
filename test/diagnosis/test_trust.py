# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of trust is read, or refused with what it may be."""

import math

import pytest

from sosml_friction.diagnosis.trust import parse_trust
from sosml_friction.exceptions import ConfigurationError


def test_entries_are_groups_with_shares():
    assert parse_trust(['friction=inf', 'masses=0.1']) == {'friction': math.inf, 'masses': 0.1}
    assert parse_trust([]) == {}


@pytest.mark.parametrize(
    ('entry', 'sentence'),
    [
        ('friction', "'friction' says no trust: write GROUP=SHARE"),
        ('friction=much', "'friction=much' says no trust"),
        ('gears=0.1', "'gears' cannot be trusted: use masses, armature, friction"),
        ('=0.1', "'' cannot be trusted"),
        ('masses=-1', 'the trust in masses is -1: give a share'),
        ('masses=nan', 'the trust in masses is nan'),
    ],
)
def test_anything_else_is_refused_in_a_sentence(entry, sentence):
    with pytest.raises(ConfigurationError) as error:
        parse_trust(['friction=inf', entry])
    assert str(error.value).startswith(sentence)
