# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joint friction without a torque sensor: observe it, identify it, diagnose the model."""
