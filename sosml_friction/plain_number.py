# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as files and people write them, and nothing else that Python would take for one."""

import re

_NUMBER = re.compile(r'[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?', re.ASCII)


def plain_number(text: str) -> float:
    """
    Return the number that a text is, with a point for its decimals; ``1_0`` and ``nan`` are none.

    :raises ValueError: if it is no number, or larger than a number can be.
    """
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        raise ValueError(f'{text!r} is no number')
    value = float(text)
    if not abs(value) < float('inf'):
        raise ValueError(f'{text!r} is larger than a number can be')
    return value
