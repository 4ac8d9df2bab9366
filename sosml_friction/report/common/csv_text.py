# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rows as CSV."""

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from typing import Any


def csv_text(head: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return rows below their heading as CSV, its lines ended as Unix does."""
    stream = StringIO()
    writer = csv.writer(stream, lineterminator='\n')
    writer.writerow(head)
    writer.writerows(rows)
    return stream.getvalue()
