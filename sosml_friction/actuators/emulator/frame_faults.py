# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What happens to frames between the host and an emulated actuator."""

from collections.abc import Iterable

import numpy as np

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.fault import Fault

# Two frames of 8 bytes at 1 Mbit/s are at least this far apart.
FRAME_NS = 130_000

TimedFrame = tuple[int, Frame]


class FrameFaults:
    """
    Lose, delay, double, exchange and damage frames as the standing faults say.

    Only faults draw random numbers here, so that a run without any is the same with and without
    this class.
    """

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._rng = np.random.default_rng(seed)
        self._held: dict[str, Frame] = {}

    def forget(self) -> None:
        """Drop what is held back."""
        self._held.clear()

    def through(
        self, joint: str, direction: str, t_ns: int, frame: Frame, faults: Iterable[Fault]
    ) -> list[TimedFrame]:
        """Return what becomes of a request to a joint, or a reply, with times of arrival [ns]."""
        result = [(t_ns, frame)]
        for fault in faults:
            if fault.meets(joint, direction):
                result = [
                    changed
                    for t_ns, frame in result
                    for changed in self._one(fault, joint, t_ns, frame)
                ]
        return result

    def _one(self, fault: Fault, joint: str, t_ns: int, frame: Frame) -> list[TimedFrame]:
        if fault.name == 'delay':
            return [(t_ns + round(fault.number('seconds') * 1e9), frame)]
        if fault.name == 'reorder' and joint in self._held:
            return [(t_ns, frame), (t_ns + FRAME_NS, self._held.pop(joint))]
        if float(self._rng.random()) >= fault.number('fraction'):
            return [(t_ns, frame)]
        if fault.name == 'duplicate':
            return [(t_ns, frame), (t_ns + FRAME_NS, frame)]
        if fault.name == 'bit_errors':
            return [(t_ns, self._damaged(frame))]
        if fault.name == 'reorder':
            self._held[joint] = frame
        return []

    def _damaged(self, frame: Frame) -> Frame:
        if not frame.data:
            return frame
        bit = int(self._rng.integers(8 * len(frame.data)))
        data = bytearray(frame.data)
        data[bit // 8] ^= 1 << bit % 8
        return Frame(frame.can_id, bytes(data))
