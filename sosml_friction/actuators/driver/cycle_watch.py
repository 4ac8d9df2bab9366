# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Watch what is no single joint's matter: the host, the cycle itself, other programs."""

from sosml_friction.actuators.bus.cycle import BusCounters
from sosml_friction.actuators.driver.configuration import DriverConfiguration

# Another program on the bus is taken to be there for as long as this after its last command.
INTRUDER_NS = 1_000_000_000


class CycleWatch:
    """
    Watch the program around the driver, the pace of the cycle and who else commands.

    ``blocked``: the last cycle's frames met a full transmit buffer; ``host_problem``: a fault of
    the program around the driver, which only :meth:`begin` lifts.
    """

    def __init__(self, configuration: DriverConfiguration) -> None:
        self._configuration = configuration
        self._intruders = self._not_sent = 0
        self._intruded_ns: int | None = None
        self.begin()

    def begin(self) -> None:
        """Start anew: the host has not spoken, no cycle has run."""
        self._host_ns: int | None = None
        self._step_ns: int | None = None
        self.host_problem = ''
        self.blocked = False

    def enable(self, now_ns: int) -> None:
        """Let the times run from now: the drive begins."""
        if self._host_ns is not None:
            self._host_ns = now_ns
        self._step_ns = None

    def heartbeat(self, now_ns: int) -> None:
        """Take note that the program around the driver is alive; from then on it must be."""
        self._host_ns = now_ns

    def start_cycle(self, now_ns: int) -> str:
        """
        Begin a cycle; return why it should not have come to this, '' if all is well.

        A host that is silent for ``host_timeout`` hangs. A pause of the cycle itself is taken for
        what it is, as the reference would jump after it: the joints were without a command for as
        long as a silent actuator may be.
        """
        configuration = self._configuration
        last_ns, self._step_ns = self._step_ns, now_ns
        silence = 0.0 if self._host_ns is None else (now_ns - self._host_ns) * 1e-9
        if silence > configuration.host_timeout:
            return (
                f'the program around the driver has not been heard of for {silence:.2f} s: one of '
                'its callbacks hangs'
            )
        pause_ns = 0 if last_ns is None else now_ns - last_ns
        if pause_ns > configuration.silence_ns + round(configuration.reply_timeout * 1e9):
            return (
                f'the cycle stood still for {pause_ns * 1e-6:.0f} ms, longer than missed_limit '
                f'({configuration.missed_limit} periods): the machine is too busy, or slept'
            )
        return ''

    def end_cycle(self, counters: BusCounters, now_ns: int) -> None:
        """Take what the bus has counted in this cycle."""
        self.blocked = counters.not_sent > self._not_sent
        self._not_sent = counters.not_sent
        if counters.intruders > self._intruders:
            self._intruded_ns = now_ns
        elif self._intruded_ns is not None and now_ns - self._intruded_ns > INTRUDER_NS:
            self._intruded_ns = None
        self._intruders = counters.intruders

    def intruder(self) -> str:
        """Return that another program commands these actuators, '' if none does."""
        if self._intruded_ns is None:
            return ''
        return (
            'another program commands these actuators on the same bus (or they share an '
            'identifier): end it'
        )

    def blockage(self) -> str:
        """Return that the bus takes no frames, '' if it does."""
        if not self.blocked:
            return ''
        return (
            'the CAN bus takes no frames (transmit buffer full): nobody acknowledges them: '
            "check the actuators' power, wiring, termination and bit rate"
        )
