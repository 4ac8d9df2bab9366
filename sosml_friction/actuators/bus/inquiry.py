# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Ask on a bus, outside any cycle, and listen."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import can

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.frame import Frame

# Long enough for a motor on a slow adapter; the whole scan then takes some two seconds [s].
ANSWER_TIME = 0.15
# A second actuator with the same identifier answers within this time after the first.
_SECOND_NS = 20_000_000


class Inquiry:
    """
    Send questions on an open bus that is nobody else's, and collect what comes back.

    ``ids`` are the numbers of motors to ask, ``dbc`` the file of the servo bridge to ask or ''.
    """

    def __init__(
        self,
        bus: can.BusABC,
        clock: Clock,
        ids: Sequence[int],
        dbc: str = '',
        answer_time: float = ANSWER_TIME,
    ) -> None:
        self.ids = ids
        self.dbc = dbc
        self._bus = bus
        self._clock = clock
        self._answer_ns = round(answer_time * 1e9)

    def ask(
        self,
        requests: Mapping[int, Frame],
        is_answer: Callable[[Frame, Frame], bool] = lambda asked, reply: True,
    ) -> list[Frame]:
        """Send requests, by the identifier of their replies, and return these, double ones too."""
        for frame in requests.values():
            self._bus.send(frame.to_message())
        replies: list[Frame] = []
        waiting = set(requests)
        for frame in self.listen(self._answer_ns):
            asked = requests.get(frame.can_id)
            if asked is None or not is_answer(asked, frame):
                continue
            replies.append(frame)
            waiting.discard(frame.can_id)
            if not waiting:
                replies += [
                    late
                    for late in self.listen(_SECOND_NS)
                    if late.can_id in requests and is_answer(requests[late.can_id], late)
                ]
                break
        return replies

    def listen(self, time_ns: int) -> Iterator[Frame]:
        """Return the frames that are heard within ``time_ns`` [ns] from now."""
        end_ns = self._clock.now_ns() + time_ns
        while True:
            remaining_ns = end_ns - self._clock.now_ns()
            message = self._bus.recv(max(0.0, remaining_ns * 1e-9))
            frame = None if message is None else Frame.from_message(message)
            if frame is not None:
                yield frame
            if remaining_ns <= 0:
                return


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
