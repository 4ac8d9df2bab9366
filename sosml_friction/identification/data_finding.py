# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One thing that is said about a recording before anything is fitted to it."""

from dataclasses import dataclass

#: What a finding means: nothing is against the data; they are used, and something is to be known
#: of them or of the model; a part of them is not used; no fit.
NOTE, WARNING, LEFT_OUT, REFUSED = 'note', 'warning', 'left_out', 'refused'


@dataclass(frozen=True)
class DataFinding:
    """
    Say one thing about a recording.

    ``check`` names what was looked at, ``joint`` where (``*``: all of it), ``level`` is one of
    ``note``, ``warning`` (all is used), ``left_out`` (a part of the data is not used) and
    ``refused`` (the joint is not fitted). ``sentence`` says what, where, and what to do, without
    a full stop.
    """

    check: str
    joint: str
    level: str
    sentence: str
