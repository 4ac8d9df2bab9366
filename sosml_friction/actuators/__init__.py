# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""CAN: codecs, devices, bus cycle, driver core and emulated hardware."""
