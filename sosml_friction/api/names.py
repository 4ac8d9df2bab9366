# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Names that a caller gives: one, several or none."""

from collections.abc import Sequence


def as_names(names: str | Sequence[str] | None) -> tuple[str, ...] | None:
    """Return names as a tuple; one text has them joined by commas, as on the command line."""
    if names is None:
        return None
    split = names.split(',') if isinstance(names, str) else names
    return tuple(name.strip() for name in split)
