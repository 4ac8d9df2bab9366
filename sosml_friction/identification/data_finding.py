# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One thing that is said about a recording before anything is fitted to it."""

from __future__ import annotations

from dataclasses import dataclass

#: What a finding means: the data say nothing against it; a part of them is not used; no fit.
NOTE, LEFT_OUT, REFUSED = 'note', 'left_out', 'refused'


@dataclass(frozen=True)
class DataFinding:
    """
    Say one thing about a recording.

    ``check`` names what was looked at, ``joint`` where (``*``: all of it), ``level`` is one of
    ``note``, ``left_out`` (a part of the data is not used) and ``refused`` (the joint is not
    fitted). ``sentence`` says what, where, and what to do, without a full stop.
    """

    check: str
    joint: str
    level: str
    sentence: str
