# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recorded experiment simulated again: in its own closed loop, or in windows."""
