# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The terms of a joint model beyond its rigid body: one physical idea in one file, stated once."""
