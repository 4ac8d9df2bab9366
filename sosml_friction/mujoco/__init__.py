# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo: models read from MJCF and written into it, and friction that it has no field for."""

from sosml_friction.mujoco.friction import Friction, apply_friction

__all__ = ['Friction', 'apply_friction']
