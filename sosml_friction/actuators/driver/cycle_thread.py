# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The one thread that owns the bus and steps the driver in real time."""

import threading
from collections.abc import Callable

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.histogram import Histogram
from sosml_friction.actuators.driver.joint_sample import JointSample


class CycleThread(threading.Thread):
    """
    Step the driver at absolute deadlines; switch all outputs off when it ends, however it ends.

    ``begun`` counts by how much cycles began after their deadline: the jitter of the machine. A
    cycle that ends after the next one should have begun is an overrun, and ``late`` counts by how
    much; the cycles that are then past are skipped, never made up for.

    :param on_sample: called in this thread with each completed cycle's sample: it must not wait.
    """

    def __init__(
        self, driver: JointDriver, clock: Clock, on_sample: Callable[[JointSample], None]
    ) -> None:
        super().__init__(name='can cycle', daemon=True)
        self._driver = driver
        self._clock = clock
        self._on_sample = on_sample
        self._stop_event = threading.Event()
        self.begun = Histogram()
        self.late = Histogram()
        self.skipped = 0
        self.last_cycle_ns = clock.now_ns()
        self.error: BaseException | None = None

    @property
    def overruns(self) -> int:
        """Return how many cycles ended after the next one should have begun."""
        return self.late.total

    def run(self) -> None:
        """Run cycles until :meth:`stop`; an exception is kept in ``error``."""
        period = self._driver.configuration.period_ns
        due_ns = self._clock.now_ns()
        try:
            while not self._stop_event.is_set():
                self.begun.add(max(0, self._clock.now_ns() - due_ns))
                sample = self._driver.step()
                if sample is not None:
                    self._on_sample(sample)
                due_ns += period
                now_ns = self._clock.now_ns()
                self.last_cycle_ns = now_ns
                late = now_ns - due_ns
                if late > 0:
                    self.late.add(late)
                    self.skipped += late // period
                    due_ns += late // period * period
                self._clock.sleep_until_ns(due_ns)
        except BaseException as error:
            self.error = error
        finally:
            self._driver.shut_down()

    def stop(self, patience: float = 5.0) -> bool:
        """
        End after the present cycle and wait until the outputs are off; return whether they are.

        A call into the CAN driver that does not return within ``patience`` [s] may never: then the
        outputs are not known to be off.
        """
        self._stop_event.set()
        if self.is_alive() and threading.current_thread() is not self:
            self.join(patience)
        return threading.current_thread() is self or not self.is_alive()
