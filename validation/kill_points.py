# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings whose process is killed at a random moment, for the reliability run."""

from __future__ import annotations

import contextlib
import mmap
import os
import shutil
import signal
import struct
import time
from pathlib import Path

import numpy as np

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import serialize_joint_state
from sosml_friction.exceptions import SosmlFrictionError
from validation.silent import SilentError

#: Messages between two flushes: the identifier flushes ten times a second, at 500 Hz.
EVERY = 50
#: Messages of a recording that nobody kills in time.
_MOST = 100_000
_TOPIC = '/joint_states'
_COUNTS = struct.Struct('<qq')
_NAMES = ('shoulder', 'elbow')


def _message(k: int) -> bytes:
    return bytes(
        serialize_joint_state(10**18 + k * 2_000_000, _NAMES, [k] * 2, [0.0] * 2, [1.0] * 2)
    )


def _record(folder: Path, counts: mmap.mmap) -> None:
    """Record as the identifier does, only faster; tell what was written and what was flushed."""
    with BagRecorder(folder) as recorder:
        recorder.add_topic(_TOPIC, 'sensor_msgs/msg/JointState')
        flushed = 0
        for k in range(_MOST):
            recorder.write(_TOPIC, _message(k), 10**18 + k * 2_000_000)
            counts[:16] = _COUNTS.pack(k + 1, flushed)
            if (k + 1) % EVERY == 0:
                recorder.flush()
                flushed = k + 1
                counts[:16] = _COUNTS.pack(k + 1, flushed)


class KillPoints:
    """
    Kill a recording with SIGKILL, and read what is left.

    What is promised: all that was flushed is there, from the first message on and without a hole,
    and a bag that lacks something says so; where not even its beginning was written, the error is
    a sentence.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / 'bag'

    def __call__(self, rng: np.random.Generator) -> list[str]:
        """
        Run one recording and kill it within 0.2 s.

        :raises SilentError: if a promise was broken.
        """
        shutil.rmtree(self._folder, ignore_errors=True)
        counts = mmap.mmap(-1, 16)
        child = os.fork()
        if child == 0:
            with contextlib.suppress(BaseException):
                _record(self._folder, counts)
            os._exit(0)
        time.sleep(float(rng.uniform(0.0, 0.2)))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        written, flushed = _COUNTS.unpack(counts[:16])
        return self._read(written, flushed)

    def _read(self, written: int, flushed: int) -> list[str]:
        try:
            bag = Bag.open(self._folder)
            found = [data for _, data in bag.messages(_TOPIC)] if _TOPIC in bag.topics else []
        except SosmlFrictionError:
            if flushed:
                raise SilentError(f'{flushed} messages were flushed, and none is read') from None
            raise
        if found != [_message(k) for k in range(len(found))]:
            raise SilentError('what is read is not what was written first')
        if len(found) < flushed:
            raise SilentError(f'{flushed} messages were flushed, and {len(found)} are read')
        if len(found) < written and not bag.recovered:
            raise SilentError(
                f'{written} messages were written, and {len(found)} are called whole'
            )
        return [bag.recovery] if bag.recovered else []
