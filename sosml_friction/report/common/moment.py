# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""When a recording was made."""

from datetime import datetime, timezone
from typing import Any

#: What says an earlier year counts from some start, of a machine or of the recording: no robot of
#: ROS is older. Chosen, no measurement.
_FIRST_YEAR = 2000


def recorded_at(stamp_ns: Any) -> datetime | None:
    """Return a stamp [ns] as a date, None where it is none, or counts from some start."""
    try:
        found = datetime.fromtimestamp(1e-9 * int(stamp_ns), timezone.utc)
    except (TypeError, ValueError, OverflowError, OSError):
        return None
    return None if found.year < _FIRST_YEAR else found
