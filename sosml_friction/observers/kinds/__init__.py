# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The observers, one file each, named as the observer is; a new file here is found by itself."""

from pkgutil import iter_modules

#: Known without loading any of them.
NAMES = tuple(sorted(module.name for module in iter_modules(__path__)))
