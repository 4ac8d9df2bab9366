# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The messages of a topic, in all files of a bag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sosml_friction.arrays import IndexArray
from sosml_friction.bags.mcap_scan import McapScan
from sosml_friction.exceptions import BagError


@dataclass
class Topic:
    """Hold where the messages of one topic are: region, offset and length, by log time."""

    type_name: str
    encoding: str
    places: tuple[IndexArray, IndexArray, IndexArray]
    log_time_ns: IndexArray

    def __len__(self) -> int:
        return len(self.log_time_ns)


def merge_topics(path: Path, scans: Sequence[McapScan]) -> dict[str, Topic]:
    """Join the channels of all files that carry the same topic; two types are a BagError."""
    parts: dict[str, list[IndexArray]] = {}
    kinds: dict[str, tuple[str, str]] = {}
    for found in scans:
        table = np.array(found.messages.columns, dtype=np.int64)
        for channel_id, channel in found.channels.items():
            kind = (found.type_name(channel), channel.message_encoding)
            if kinds.setdefault(channel.topic, kind) != kind:
                raise BagError(
                    f'{channel.topic} in {path} is both {kinds[channel.topic][0]} and {kind[0]}: '
                    'remap one of the two publishers and record again'
                )
            parts.setdefault(channel.topic, []).append(table[1:, table[0] == channel_id])
    topics = {}
    for name, own in parts.items():
        region, offset, length, log_time_ns = np.concatenate(own, axis=1)
        # Equal log times keep the order of the file.
        order = np.lexsort((offset, region, log_time_ns))
        places = region[order], offset[order], length[order]
        topics[name] = Topic(*kinds[name], places, log_time_ns[order])
    return topics
