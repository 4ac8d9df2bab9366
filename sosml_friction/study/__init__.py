# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's comparison of observers in simulation, and the search for their gains."""
