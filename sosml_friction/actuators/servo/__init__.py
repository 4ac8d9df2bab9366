# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A position servo behind a CAN bridge: codec from a DBC file, actuator, emulation."""
