# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""YAML from outside is plain values, or one sentence with file, line and key."""

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.yaml_text import parse_yaml, read_yaml

BOMB = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{key}: &{key} [{", ".join(f"*{last}" for _ in range(9))}]\n'
    for last, key in zip('abcdefghi', 'bcdefghij', strict=True)
)


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('[' * 100_000, r'f is not YAML \(line 1, key .*deeper than 40 levels'),
        ('- ' * 60, 'deeper than 40 levels'),
        (BOMB, r'\(line 7, key g.\d\): its aliases stand for more than 1000000 entries'),
        ('a: &a [*a]', r'\(line 1, key a.0\): an alias stands within what it names'),
        ('a: 1\nb: ' + '9' * 5000, r'\(line 2, key b\): .* is no int'),
        ('b: ' + '9' * 300, r'\(line 1, key b\): .* is too large a number'),
        ('a:\n  b: 1\n  b: 2', r"\(line 3, key a\): the key 'b' is there twice"),
        ('a:\n  - b: [1,', r'\(line 2, key a.0.b\)'),
        ('a: !!python/object/apply:os.system [ls]', 'is no plain value'),
        ('a: !!timestamp 2026-01-01', 'is no plain value'),
        ('a: "\\ud800"', 'is no str'),
        ('x' * 2_000_001, 'longer than 2000000 characters'),
        ('\0', '^f is not YAML: '),
    ],
)
def test_what_has_no_bound_is_refused_with_line_and_key(text, sentence):
    with pytest.raises(ConfigurationError, match=sentence) as caught:
        parse_yaml(text, 'f')
    assert len(str(caught.value).splitlines()) == 1


def test_a_date_is_text():
    assert parse_yaml('day: 2026-13-45', 'f') == {'day': '2026-13-45'}


def test_aliases_of_a_usual_document_are_followed():
    shared = [1, 2.5, None, True, 'x']
    document = {'a': shared, 'b': shared, 'c': {'d': shared}}
    assert '*id001' in yaml.safe_dump(document)
    assert parse_yaml(yaml.safe_dump(document), 'f') == document
    assert parse_yaml('a: &a {x: 1}\nb: {<<: *a, y: 2}', 'f')['b'] == {'x': 1, 'y': 2}


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63)
    | st.floats(allow_nan=False)
    | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(VALUES)
@settings(max_examples=60, deadline=None)
def test_plain_values_come_back(value):
    assert parse_yaml(yaml.safe_dump(value), 'f') == value


@given(st.text('ab:-[]{}&*!?|>"\' \n0129.,#%@'))
@settings(max_examples=150, deadline=None)
def test_any_text_is_a_value_or_one_sentence(text):
    said = 'f is not YAML'
    try:
        parse_yaml(text, 'f')
    except ConfigurationError as error:
        said = str(error)
    assert said.startswith('f is not YAML')
    assert len(said.splitlines()) == 1


def test_a_file_that_cannot_be_read_says_what_to_give(tmp_path):
    with pytest.raises(ConfigurationError, match=r'the map .*x cannot be read \(No such.*give'):
        read_yaml(tmp_path / 'x', 'the map')
    (tmp_path / 'x').write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ConfigurationError, match='no text in UTF-8'):
        read_yaml(tmp_path / 'x')
