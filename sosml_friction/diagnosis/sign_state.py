# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The sign of motion as a state that keeps its value at rest: Dahl's, as in the simulation."""

from sosml_friction.simulation.dahl import dahl_path as sign_state

__all__ = ['sign_state']
