# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What effort may be a function of, in the words of an answer."""

SPEED, POSITION, ACCELERATION, LOAD = 'speed', 'position', 'acceleration', 'load'
TIME, BACK_AND_FORTH = 'time', 'time, back and forth'
#: What no cause of the catalogue is a function of.
NEIGHBOURS = 'the position of the next joint', 'the speed of the next joint'
