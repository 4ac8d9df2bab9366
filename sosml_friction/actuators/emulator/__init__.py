# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Emulated hardware: the arm, its actuators and their faults."""
