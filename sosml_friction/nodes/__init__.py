# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 glue, one node per file."""
