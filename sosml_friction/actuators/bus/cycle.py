# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One exchange on the bus: all requests out, then all replies in, until one deadline."""

import contextlib
import errno
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntFlag

import can

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.start_up import Request
from sosml_friction.exceptions import ActuatorError, CanProtocolError

_FULL_ERRNOS = (errno.ENOBUFS, errno.EAGAIN, errno.EWOULDBLOCK)
_FULL_WORDS = ('transmit buffer full', 'no buffer space', 'transmit queue is full')


class BusTrouble(IntFlag):
    """Classes of SocketCAN's error frames, bits of their identifier."""

    TRANSMIT_TIMEOUT = 0x001
    LOST_ARBITRATION = 0x002
    CONTROLLER = 0x004
    PROTOCOL = 0x008
    TRANSCEIVER = 0x010
    NOT_ACKNOWLEDGED = 0x020
    BUS_OFF = 0x040
    BUS_ERROR = 0x080
    RESTARTED = 0x100


def bus_trouble(message: can.Message) -> BusTrouble:
    """Return what an error frame says; nothing for any other frame."""
    if not message.is_error_frame:
        return BusTrouble(0)
    return BusTrouble(message.arbitration_id & 0x1FF)


def trouble_names(trouble: BusTrouble) -> str:
    """Return the set bits as words."""
    names = [(flag.name or '').lower().replace('_', ' ') for flag in BusTrouble if trouble & flag]
    return ', '.join(names) or 'none'


def is_transmit_full(error: BaseException) -> bool:
    """
    Tell whether a failed send means "transmit buffer full": the bus is there, but does not take.

    python-can raises it with an errno (ENOBUFS), or by words alone when its own wait timed out.
    """
    code = getattr(error, 'error_code', None)
    if code is None and isinstance(error, OSError):
        code = error.errno
    if code is not None:
        return code in _FULL_ERRNOS
    return any(words in str(error).lower() for words in _FULL_WORDS)


# More frames than this before a cycle are not late replies but a flood.
_DRAIN_LIMIT = 256
# Frames sent that may still come back as heard.
_RECENT = 256


@dataclass
class BusCounters:
    """
    Count frames since the start.

    ``stale``: from a known actuator but not asked for now (late, double); ``unsolicited``: what an
    actuator says by itself; ``echoes``: a request that came back instead of its reply;
    ``foreign``: from an identifier nobody here talks to; ``undecodable``: a known identifier with
    bytes that are no reply; ``missed``: requests without a reply by the deadline; ``not_sent``:
    refused by a full transmit buffer or by the adapter; ``error_frames`` of the controller;
    ``failures`` of the bus as a whole; ``reopened``: how often it was opened again;
    ``intruders``: commands to these actuators that another program sent.
    """

    sent: int = 0
    received: int = 0
    stale: int = 0
    unsolicited: int = 0
    echoes: int = 0
    foreign: int = 0
    undecodable: int = 0
    missed: int = 0
    not_sent: int = 0
    error_frames: int = 0
    failures: int = 0
    reopened: int = 0
    intruders: int = 0


class BusCycle:
    """
    Own a python-can bus and exchange requests for replies on it. One thread may use it.

    Replies are matched by (identifier, command byte) or (identifier, sequence), so that a late or
    foreign frame is never taken for the answer; each goes to its actuator with the time at which
    it was asked: an actuator measures then, however much later this program reads the answer.
    After a failure nothing is sent until :meth:`recover` says so; ``bus`` may then be another one.

    :param reopen: opens the bus anew after it was lost; without it the same object is used again.
    """

    def __init__(
        self,
        bus: can.BusABC,
        clock: Clock,
        actuators: Iterable[Actuator],
        reopen: Callable[[], can.BusABC] | None = None,
    ) -> None:
        self.bus = bus
        self._clock = clock
        actuators = list(actuators)
        self._actuators = {actuator.reply_id: actuator for actuator in actuators}
        self._reopen = reopen
        self._commanded = {own for actuator in actuators for own in actuator.request_ids}
        # Some interfaces hear what they send themselves.
        self._recent: deque[tuple[int, bytes]] = deque(maxlen=_RECENT)
        # When each was asked last, by the key of its reply.
        self._asked_ns: dict[Hashable, int] = {}
        self._patient: dict[Hashable, tuple[int, Actuator]] = {}
        self._refused = int(getattr(bus, 'refused', 0))
        self._off = False
        self._lost = False
        self.counters = BusCounters()
        self.trouble = BusTrouble(0)

    def exchange(self, requests: Sequence[Request], deadline_ns: int) -> set[Hashable]:
        """
        Send all requests, collect their replies; return the keys of those that did not come.

        What lies in the receive buffer beforehand is dropped as stale. At the deadline, what has
        arrived by then is still read. A transmit buffer that is full counts as no reply.

        :raises ActuatorError: if the bus fails or the controller is off the bus.
        """
        counters = self.counters
        with self._guard():
            self._drain()
            self._check_off()
            missing: set[Hashable] = set()
            pending: dict[Hashable, Request] = {}
            for request in requests:
                if missing or not self._send(request):
                    # After the first that is refused, no later one may overtake it.
                    missing.add(request.key)
                elif request.patience_ns:
                    self._be_patient(request)
                else:
                    pending[request.key] = request
            if missing:
                missing -= {request.key for request in requests if request.patience_ns}
            missing |= self._collect(pending, deadline_ns)
            self._check_off()
        counters.missed += len(missing)
        return missing

    def listen(self, until_ns: int) -> None:
        """
        Take what comes until ``until_ns``, asking nothing.

        :raises ActuatorError: if the bus fails or the controller is off the bus.
        """
        with self._guard():
            while (timeout := (until_ns - self._clock.now_ns()) * 1e-9) > 0.0:
                message = self.bus.recv(timeout)
                if message is not None:
                    self._take(message, {}, set())
                self._check_off()

    @contextlib.contextmanager
    def _guard(self) -> Iterator[None]:
        try:
            yield
        except ActuatorError:
            raise
        except (can.CanError, OSError) as error:
            self.counters.failures += 1
            self._lost = True
            reason = ' '.join(str(error).split())
            raise ActuatorError(
                f'the CAN bus failed ({reason}): check the adapter and its cable'
            ) from error
        except Exception:
            # A defect, perhaps of a CAN driver: the last word is then better said to a new bus.
            self._lost = True
            raise

    def recover(self) -> bool:
        """
        Try to get a lost bus back, sending nothing; return whether frames may be sent again.

        A lost adapter is opened again. Off the bus, the controller restarts by itself or by its
        operator (``ip link set can0 type can restart-ms 100``); where opening the bus again resets
        the controller, that is done. Takes as long as opening takes.
        """
        try:
            if self._lost or (self._off and self._reopen is not None):
                if self._reopen is not None:
                    with contextlib.suppress(Exception):
                        # A bus that is gone may fail to close in any way.
                        self.bus.shutdown()
                    self.bus = self._reopen()
                    self._off = False
                    self._refused = int(getattr(self.bus, 'refused', 0))
                    self.counters.reopened += 1
                self._lost = False
            self._drain()
        except (ActuatorError, can.CanError, OSError):
            self._lost = True
        return not (self._lost or self._off)

    def _send(self, request: Request) -> bool:
        # Once it is sent, another program may run before this one.
        asked_ns = self._clock.now_ns()
        try:
            self.bus.send(request.frame.to_message())
        except (can.CanError, OSError) as error:
            if not is_transmit_full(error):
                raise
            self.counters.not_sent += 1
            return False
        self._asked_ns[request.key] = asked_ns
        self._recent.append((request.frame.can_id, request.frame.data))
        self.counters.sent += 1
        return True

    def _be_patient(self, request: Request) -> None:
        # A key begins with the identifier of the reply.
        reply_id = request.key[0] if isinstance(request.key, tuple) else None
        if reply_id in self._actuators:
            until_ns = self._clock.now_ns() + request.patience_ns
            self._patient[request.key] = until_ns, self._actuators[reply_id]

    def _collect(self, pending: dict[Hashable, Request], deadline_ns: int) -> set[Hashable]:
        missing: set[Hashable] = set()
        late = 0
        while pending and late < _DRAIN_LIMIT:
            timeout = max(0.0, (deadline_ns - self._clock.now_ns()) * 1e-9)
            message = self.bus.recv(timeout)
            if message is None:
                if timeout > 0.0 and self._clock.now_ns() < deadline_ns:
                    continue
                break
            late += timeout == 0.0
            self._take(message, pending, missing)
            if self._off:
                break
        if self._patient:
            now_ns = self._clock.now_ns()
            for key, (until_ns, actuator) in list(self._patient.items()):
                if now_ns >= until_ns:
                    del self._patient[key]
                    actuator.overdue(key)
        refused = int(getattr(self.bus, 'refused', 0))
        self.counters.not_sent += refused - self._refused
        self._refused = refused
        return missing | set(pending)

    def _drain(self) -> None:
        for _ in range(_DRAIN_LIMIT):
            message = self.bus.recv(0.0)
            if message is None:
                return
            self._take(message, {}, set())

    def _check_off(self) -> None:
        if self._off:
            self.counters.failures += 1
            raise ActuatorError(
                'the CAN controller is off the bus (bus-off): check bit rate, wiring and '
                'termination; it returns by itself where restart-ms is set'
            )

    def _take(
        self,
        message: can.Message,
        pending: dict[Hashable, Request],
        missing: set[Hashable],
    ) -> None:
        counters = self.counters
        if message.is_error_frame:
            self._take_error(message)
            return
        counters.received += 1
        # Whoever is off the bus hears nothing.
        self._off = False
        frame = Frame.from_message(message)
        actuator = None if frame is None else self._actuators.get(frame.can_id)
        if frame is None or actuator is None:
            counters.foreign += 1
            if frame is not None and frame.can_id in self._commanded:
                counters.intruders += (frame.can_id, frame.data) not in self._recent
            return
        try:
            if actuator.unsolicited(frame):
                counters.unsolicited += 1
                return
            key = actuator.key(frame)
            request = pending.get(key)
            if request is None and key not in self._patient:
                counters.stale += 1
                return
            if request is not None and actuator.is_echo(request, frame):
                counters.echoes += 1
                missing.add(key)
                del pending[key]
                return
            actuator.accept(frame, self._asked_ns[key])
            if request is not None:
                actuator.measurement.received_ns = self._clock.now_ns()
        except CanProtocolError:
            counters.undecodable += 1
            return
        pending.pop(key, None)
        self._patient.pop(key, None)

    def _take_error(self, message: can.Message) -> None:
        self.counters.error_frames += 1
        self.trouble = bus_trouble(message)
        if self.trouble & BusTrouble.RESTARTED:
            self._off = False
        elif self.trouble & BusTrouble.BUS_OFF:
            self._off = True
