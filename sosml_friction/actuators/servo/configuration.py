# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver is told about a joint with a position servo behind a CAN bridge."""

from dataclasses import dataclass

from sosml_friction.actuators.joint_configuration import JointConfiguration
from sosml_friction.actuators.parameter import parameter
from sosml_friction.model.robot import JointLimits
from sosml_friction.share import share_directory

POSITION_MODE = 'position'


@dataclass(frozen=True)
class ServoConfiguration(JointConfiguration):
    """
    Describe a joint with a servo: ``dbc`` of its bridge, and ``dbc_map``, the DBC's own names.

    A name is mapped as ``ours=theirs``: ``servo_state=STATE_1``, ``servo_state.position=Pos``.

    :raises ConfigurationError: if a value does not fit.
    """

    driver = 'servo_dbc'

    dbc: str = parameter(
        'DBC of the servo bridge; empty: config/elbow_servo.dbc of the package', '', mount=True
    )
    dbc_map: tuple[str, ...] = parameter(
        "the DBC's own names as OURS=THEIRS: servo_state=STATE_1, servo_state.position=Pos",
        (),
        mount=True,
    )
    mode: str = parameter(
        'servo_dbc: position, by its own loop', POSITION_MODE, choices=(POSITION_MODE,)
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, 'dbc_map', tuple(self.dbc_map))
        if not self.dbc:
            shipped = share_directory() / 'config' / 'elbow_servo.dbc'
            object.__setattr__(self, 'dbc', str(shipped))

    def check_drive(self) -> None:
        """Need nothing more: the servo limits its own current."""

    def loop(self, limits: JointLimits) -> str:
        return f'the loop of {self.name} is in its servo'
