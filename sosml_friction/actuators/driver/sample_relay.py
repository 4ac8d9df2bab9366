# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Take samples from the cycle and hand them on in a thread of its own, which may hang."""

import queue
import threading
from collections.abc import Callable

from sosml_friction.actuators.driver.joint_sample import JointSample


class SampleRelay(threading.Thread):
    """
    Call ``on_sample`` with each sample, in order, outside the cycle's thread.

    The cycle only appends to a queue of ``capacity`` samples and never waits. If ``on_sample``
    raises, or hangs until the queue is full, ``on_failure`` is called once with the reason; what
    does not fit is counted in ``dropped``.
    """

    def __init__(
        self,
        on_sample: Callable[[JointSample], None],
        on_failure: Callable[[str], None],
        capacity: int,
    ) -> None:
        super().__init__(name='samples', daemon=True)
        self._on_sample = on_sample
        self._on_failure = on_failure
        self._capacity = capacity
        self._queue: queue.SimpleQueue[JointSample | None] = queue.SimpleQueue()
        self._failed = False
        self.dropped = 0
        self.error: BaseException | None = None

    def put(self, sample: JointSample) -> None:
        """Take one sample; returns at once."""
        waiting = self._queue.qsize()
        if waiting >= self._capacity or self.error is not None:
            self.dropped += 1
            self._fail(f'{waiting} samples wait to be published: the publisher hangs')
            return
        self._queue.put(sample)

    def _fail(self, reason: str) -> None:
        if not self._failed:
            self._failed = True
            self._on_failure(reason)

    def run(self) -> None:
        """Hand samples on until :meth:`stop`; an exception is kept in ``error``."""
        try:
            while (sample := self._queue.get()) is not None:
                self._on_sample(sample)
        except BaseException as error:
            self.error = error
            self._fail(f'samples cannot be published: {error!r}')

    def stop(self, patience: float = 1.0) -> bool:
        """End when the queue is empty; return False if it hangs longer than ``patience`` [s]."""
        self._queue.put(None)
        if self.is_alive() and threading.current_thread() is not self:
            self.join(patience)
        return not self.is_alive()
