# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Who is on the bus: ask every motor and the servo bridge, command none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import can

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoDbc, ServoFlag, ServoState
from sosml_friction.exceptions import ActuatorError, CanProtocolError

# Long enough for a motor on a slow adapter; the whole scan then takes some two seconds [s].
ANSWER_TIME = 0.15
# Motors asked at once: their requests fit the transmit queue of a SocketCAN interface.
_AT_ONCE = 8
# Another host's cycle would be heard within this time.
LISTEN_NS = 200_000_000
_BLOCKS = 3
# A second motor with the same id answers within this time after the first.
_SECOND_NS = 20_000_000
# A motor whose timeout passes while the others are asked echoes once.
_ATTEMPTS = 3


@dataclass
class FoundActuator:
    """
    Hold what an actuator says of itself; None is not told.

    ``can_id``: the identifier it is asked at; ``kind``: rmd_x or servo_dbc; ``motor_id``: 1 to 32
    of an RMD-X; ``voltage`` [V]; ``temperature`` [degC]; ``errors``: its error or status bits in
    words; ``remarks``: what else its owner should know.
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


class CanScan:
    """
    Ask on a bus who is there; read-only.

    An RMD-X is asked version, model and status. A servo bridge answers nothing but a command: it
    is told "off", which it is anyway while no driver runs. So the bus is listened to first, and
    where somebody else talks nothing is asked.

    :param bus: open, and nobody else's.
    :param answer_time: how long to wait for an answer [s].
    """

    def __init__(self, bus: can.BusABC, clock: Clock, answer_time: float = ANSWER_TIME) -> None:
        self._bus = bus
        self._clock = clock
        self._answer_ns = round(answer_time * 1e9)

    def run(self, ids: Iterable[int], dbc: ServoDbc | None) -> list[FoundActuator]:
        """
        Return who answers, by identifier.

        :param ids: the motors to ask, 1 to 32.
        :param dbc: of the servo bridge to ask, None for none.
        :raises ActuatorError: if the bus fails, or another host is talking on it.
        """
        try:
            self._refuse_company()
            found = self._motors(list(ids))
            if dbc is not None:
                found += self._servo(dbc)
        except (can.CanError, OSError) as error:
            raise ActuatorError(
                f'the CAN bus failed while it was scanned ({" ".join(str(error).split())}): check '
                'the adapter, the bit rate and the power of the bus'
            ) from error
        return sorted(found, key=lambda actuator: actuator.can_id)

    def _refuse_company(self) -> None:
        for frame in self._listen(self._clock.now_ns() + LISTEN_NS):
            if frame.data[:1] != bytes([rmd_x.Command.TIMEOUT_EXPIRED]):
                raise ActuatorError(
                    f'another host is talking on the bus (frame {frame} was heard before anything '
                    'was asked): stop it first, or the motors answer two'
                )

    def _motors(self, ids: list[int]) -> list[FoundActuator]:
        version = rmd_x.ReadVersion()
        found = []
        for start in range(0, len(ids), _AT_ONCE):
            some = ids[start : start + _AT_ONCE]
            requests = {motor: rmd_x.encode_request(motor, version) for motor in some}
            # A motor whose timeout has passed only echoes the first request: ask twice.
            rounds = [self._ask(requests) for _ in range(2)]
            for motor in some:
                own = [[frame for key, frame in replies if key == motor] for replies in rounds]
                if any(own):
                    found.append(self._describe(motor, own))
        return found

    def _describe(self, motor: int, rounds: list[list[Frame]]) -> FoundActuator:
        found = FoundActuator(rmd_x.REQUEST_BASE + motor, 'rmd_x', motor_id=motor)
        if any(len(replies) > 1 for replies in rounds):
            found.remarks.append(f'more than one answer: two motors may share id {motor}')
        dates = [int.from_bytes(own.data[4:8], 'little') for replies in rounds for own in replies]
        # Only at first: later it is the scan itself that lets the motor wait.
        if rounds[0] and not any(rounds[0][0].data[4:8]):
            found.remarks.append('its communication timeout had tripped')
        if not any(dates):
            # While the others were waited for, its timeout has passed again.
            again = self._ask_one(motor, rmd_x.ReadVersion(), Protocol.V3)
            dates = [int.from_bytes(reply.data[4:8], 'little') for reply in again]
        date = next((date for date in dates if date), None)
        if date is None:
            found.remarks.append('answers with an echo only')
            return found
        found.version = date
        try:
            protocol = Protocol.of_version(date)
        except CanProtocolError as error:
            found.remarks.append(str(error))
            return found
        found.model = self._model(motor, protocol)
        for frame in self._ask_one(motor, rmd_x.ReadStatus(), protocol):
            try:
                _, status = rmd_x.decode_reply(frame, protocol)
            except CanProtocolError as error:
                found.remarks.append(str(error))
                continue
            if isinstance(status, rmd_x.Status):
                found.voltage = status.voltage
                found.temperature = float(status.temperature)
                found.errors = rmd_x.flag_names(status.errors)
        return found

    def _model(self, motor: int, protocol: Protocol) -> str | None:
        blocks = range(1, _BLOCKS + 1) if protocol is Protocol.V4_4 else (0,)
        text = ''
        for block in blocks:
            for frame in self._ask_one(motor, rmd_x.ReadModel(block), protocol)[:1]:
                try:
                    _, reply = rmd_x.decode_reply(frame, protocol)
                except CanProtocolError:
                    continue
                if isinstance(reply, rmd_x.Model):
                    text += reply.name
                elif isinstance(reply, rmd_x.ModelBlock):
                    text += reply.text
        return text or None

    def _ask_one(self, motor: int, request: rmd_x.Request, protocol: Protocol) -> list[Frame]:
        frame = rmd_x.encode_request(motor, request, protocol)
        replies: list[Frame] = []
        for _ in range(_ATTEMPTS):
            replies = [reply for _, reply in self._ask({motor: frame})]
            if replies and replies[0].data != frame.data:
                break
        return replies

    def _ask(self, requests: dict[int, Frame]) -> list[tuple[int, Frame]]:
        """Send a request to each motor; return the replies with the same command byte."""
        for frame in requests.values():
            self._bus.send(frame.to_message())
        replies = []
        waiting = set(requests)
        for frame in self._listen(self._clock.now_ns() + self._answer_ns):
            motor = frame.can_id - rmd_x.REPLY_BASE
            asked = requests.get(motor)
            if asked is None or len(frame.data) != 8 or frame.data[0] != asked.data[0]:
                continue
            replies.append((motor, frame))
            waiting.discard(motor)
            if not waiting:
                replies += [
                    (late.can_id - rmd_x.REPLY_BASE, late)
                    for late in self._listen(self._clock.now_ns() + _SECOND_NS)
                    if late.can_id - rmd_x.REPLY_BASE in requests
                    and len(late.data) == 8
                    and late.data[0] == asked.data[0]
                ]
                break
        return replies

    def _servo(self, dbc: ServoDbc) -> list[FoundActuator]:
        command = dbc.encode_command(ServoCommand(Mode.OFF, 1))
        for _ in range(2):
            self._bus.send(command.to_message())
            for frame in self._listen(self._clock.now_ns() + self._answer_ns):
                if frame.can_id != dbc.state_id:
                    continue
                found = FoundActuator(dbc.command_id, 'servo_dbc')
                try:
                    state = dbc.decode_state(frame)
                except CanProtocolError as error:
                    found.remarks.append(str(error))
                else:
                    _describe_servo(found, state)
                return [found]
        return []

    def _listen(self, end_ns: int) -> Iterable[Frame]:
        while True:
            remaining_ns = end_ns - self._clock.now_ns()
            message = self._bus.recv(max(0.0, remaining_ns * 1e-9))
            if message is None:
                if remaining_ns <= 0:
                    return
                continue
            frame = Frame.from_message(message)
            if frame is not None:
                yield frame
            if remaining_ns <= 0:
                return


def servo_flag_names(status: ServoFlag) -> str:
    """Return the bits of a bridge's status as words, 'none' for none."""
    names = [flag.name.lower() for flag in ServoFlag if status & flag and flag.name]
    return ', '.join(names) or 'none'


def _describe_servo(found: FoundActuator, state: ServoState) -> None:
    found.errors = servo_flag_names(state.status)
    if state.current != state.current:
        found.remarks.append('it measures no current: effort and friction stay unknown')
