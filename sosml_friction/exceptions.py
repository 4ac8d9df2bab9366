# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Errors a user can meet, each one sentence: what, where, what to do.

::

    SosmlFrictionError
    +-- ConfigurationError   a parameter, model, URDF or mapping file is missing or contradictory
    +-- DataError            measured data cannot answer the question
    |   +-- BagError         a bag cannot be read or written
    +-- CanProtocolError     a CAN frame does not say what the protocol allows
    +-- ActuatorError        an actuator or its bus is silent, faulty or refuses
    +-- TrajectoryError      a trajectory is refused before its first point
"""


class SosmlFrictionError(Exception):
    """Root of every error this package raises on purpose."""


class ConfigurationError(SosmlFrictionError):
    """A parameter, model, URDF or mapping file is missing or contradictory."""


class DataError(SosmlFrictionError):
    """Measured data cannot answer the question asked of it."""


class MotionError(DataError):
    """A motion cannot tell what is asked, by whatever method."""


class BagError(DataError):
    """A bag cannot be read or written."""


class CanProtocolError(SosmlFrictionError):
    """A CAN frame does not say what the protocol allows."""


class ActuatorError(SosmlFrictionError):
    """An actuator or its bus is silent, faulty or refuses."""


class TrajectoryError(SosmlFrictionError):
    """A trajectory is refused as a whole, before its first point is executed."""
