# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
After which sample the observers start afresh, in the answer of ``~/reset``.

An estimate that is not known may also be that of a gap just before the reset, and answers and
estimates come by different ways, in any order. Only the stamp tells them apart.
"""

import re

_SENTENCE = 'the observers start with the first joint_states after stamp {}.{:09d}'
_STAMP = re.compile(r'after stamp (\d+)\.(\d{9})$')


def tell_start(last_ns: int | None) -> str:
    """Return the answer to a reset; ``last_ns``: stamp of the last sample before it, or None."""
    if last_ns is None:
        return 'the observers start with the next joint_states'
    return _SENTENCE.format(*divmod(last_ns, 10**9))


def read_start(sentence: str) -> int | None:
    """Return the stamp of the last sample before the start [ns]; None if none is told."""
    found = _STAMP.search(sentence)
    return None if found is None else int(found[1]) * 10**9 + int(found[2])
