# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The answer to a reset is read as it was told, and other sentences tell no stamp."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.nodes.fresh_start import read_start, tell_start


@given(st.none() | st.integers(0, 2**62))
def test_the_stamp_of_the_last_sample_comes_back_to_the_nanosecond(last_ns):
    assert read_start(tell_start(last_ns)) == last_ns


@given(st.text())
def test_any_other_sentence_tells_no_stamp(sentence):
    assert read_start(sentence) is None
