# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an actuator says of itself when somebody asks who is on the bus."""

from dataclasses import dataclass, field


@dataclass
class FoundActuator:
    """
    Hold what an actuator says of itself; None is not told.

    ``can_id``: the identifier it is asked at; ``kind``: its driver; ``motor_id``: the number it
    goes by, as 1 to 32 of an RMD-X; ``voltage`` [V]; ``temperature`` [degC]; ``errors``: its error
    or status bits in words; ``remarks``: what else its owner should know.
    """

    can_id: int
    kind: str
    motor_id: int | None = None
    model: str | None = None
    version: int | None = None
    voltage: float | None = None
    temperature: float | None = None
    errors: str | None = None
    remarks: list[str] = field(default_factory=list)
