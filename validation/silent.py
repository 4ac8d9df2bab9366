# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a case of the reliability run raises where something is wrong and nobody said so."""


class SilentError(Exception):
    """What was read is not what was written, and the reader calls it whole."""
