# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Python interface: what ``import sosml_friction`` offers, a file per function or class."""
