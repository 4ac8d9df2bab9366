# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Find the RMD-X motors on a bus: version, model and status of each, read-only."""

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import Protocol
from sosml_friction.exceptions import CanProtocolError

# Motors asked at once: their requests fit the transmit queue of a SocketCAN interface.
_AT_ONCE = 8
_BLOCKS = 3
# A motor whose timeout passes while the others are asked echoes once.
_ATTEMPTS = 3


def scan_motors(inquiry: Inquiry, kind: str) -> list[FoundActuator]:
    """Return the motors that answer, in the order of ``inquiry.ids``."""
    found = []
    for start in range(0, len(inquiry.ids), _AT_ONCE):
        some = inquiry.ids[start : start + _AT_ONCE]
        requests = {
            rmd_x.REPLY_BASE + motor: rmd_x.encode_request(motor, rmd_x.ReadVersion())
            for motor in some
        }
        # A motor whose timeout has passed only echoes the first request: ask twice.
        rounds = [inquiry.ask(requests, _answers) for _ in range(2)]
        for motor in some:
            own = [
                [frame for frame in replies if frame.can_id == rmd_x.REPLY_BASE + motor]
                for replies in rounds
            ]
            if any(own):
                found.append(_describe(inquiry, motor, own, kind))
    return found


def _answers(asked: Frame, reply: Frame) -> bool:
    return len(reply.data) == 8 and reply.data[0] == asked.data[0]


def _dates(replies: list[Frame]) -> list[int]:
    """Return the dates of versions that are no echoes."""
    dates = (int.from_bytes(reply.data[4:8], 'little') for reply in replies)
    return [date for date in dates if date]


def _describe(inquiry: Inquiry, motor: int, rounds: list[list[Frame]], kind: str) -> FoundActuator:
    found = FoundActuator(rmd_x.REQUEST_BASE + motor, kind, motor_id=motor)
    if any(len(replies) > 1 for replies in rounds):
        found.remarks.append(f'more than one answer: two motors may share id {motor}')
    # Only at first: later it is the scan itself that lets the motor wait.
    if rounds[0] and not _dates(rounds[0][:1]):
        found.remarks.append('its communication timeout had tripped')
    # While the others were waited for, its timeout may have passed again.
    dates = [date for replies in rounds for date in _dates(replies)] or _dates(
        _ask_one(inquiry, motor, rmd_x.ReadVersion())
    )
    if not dates:
        found.remarks.append('answers with an echo only')
        return found
    found.version = dates[0]
    try:
        protocol = Protocol.of_version(found.version)
    except CanProtocolError as error:
        found.remarks.append(str(error))
        return found
    found.model = _model(inquiry, motor, protocol)
    for frame in _ask_one(inquiry, motor, rmd_x.ReadStatus()):
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


def _model(inquiry: Inquiry, motor: int, protocol: Protocol) -> str | None:
    blocks = range(1, _BLOCKS + 1) if protocol is Protocol.V4_4 else (0,)
    text = ''
    for block in blocks:
        for frame in _ask_one(inquiry, motor, rmd_x.ReadModel(block))[:1]:
            try:
                _, reply = rmd_x.decode_reply(frame, protocol)
            except CanProtocolError:
                continue
            if isinstance(reply, rmd_x.Model):
                text += reply.name
            elif isinstance(reply, rmd_x.ModelBlock):
                text += reply.text
    return text or None


def _ask_one(inquiry: Inquiry, motor: int, request: rmd_x.Request) -> list[Frame]:
    frame = rmd_x.encode_request(motor, request)
    replies: list[Frame] = []
    for _ in range(_ATTEMPTS):
        replies = inquiry.ask({rmd_x.REPLY_BASE + motor: frame}, _answers)
        if replies and replies[0].data != frame.data:
            break
    return replies
