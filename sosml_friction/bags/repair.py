# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Write what can be saved of a damaged bag into a new one."""

from pathlib import Path
from typing import Any

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.bag_metadata import METADATA
from sosml_friction.bags.recorder import BagRecorder, TypeDefinition
from sosml_friction.exceptions import BagError

FORMAT = 'sosml_friction/repair/1'
_LATCHED = ('transient_local', 'durability: 1')


def repair_bag(path: str | Path, destination: str | Path) -> dict[str, Any]:
    """
    Write all that is whole of a bag, behind damaged places too, into the bag ``destination``.

    Index, statistics and metadata are made anew. Return the object of ``sosml repair --json``,
    whose schema is ``docs/schema/repair.schema.json``; ``output`` is None, and nothing is written,
    where nothing is damaged. ``lost`` is how many messages are missing, as far as the bag says how
    many it had.

    :raises BagError: if no message can be saved, or ``destination`` exists or cannot be written.
    """
    path, destination = Path(path), Path(destination)
    bag = Bag.open(path, beyond=True)
    before = _read_before(path)
    is_whole = not bag.recovered and (path.is_file() or (path / METADATA).is_file())
    topics: dict[str, int] = {}
    left_out: list[str] = []
    if not is_whole:
        topics, left_out = _write(bag, destination)
    saved = sum(topics.values())
    stated = bag.stated_messages
    return {
        'format': FORMAT,
        'path': str(path),
        'output': None if is_whole else str(destination),
        'damage': bag.recovery,
        'read_before': before,
        'saved': bag.messages_read if is_whole else saved,
        'lost': 0 if is_whole else None if stated is None else max(stated - saved, 0),
        'topics': {
            name: {'type': kind, 'messages': count if is_whole else topics.get(name, 0)}
            for name, (kind, count) in bag.topics.items()
        },
        'left_out': left_out,
    }


def _read_before(path: Path) -> int:
    """Return how many messages are read of the bag as it is."""
    try:
        return Bag.open(path).messages_read
    except BagError:
        return 0


def _write(bag: Bag, destination: Path) -> tuple[dict[str, int], list[str]]:
    """Write the messages of a bag; return how many by topic, and the topics that cannot be."""
    counts: dict[str, int] = {}
    left_out = []
    with BagRecorder(destination, bag.tags) as recorder:
        for topic, (schema, channel) in bag.channels().items():
            if schema is None or channel.message_encoding != 'cdr':
                left_out.append(topic)
                continue
            offered = channel.metadata.get('offered_qos_profiles', '')
            latched = any(word in offered for word in _LATCHED) if offered else None
            kind = TypeDefinition(
                schema.data, schema.encoding, channel.metadata.get('topic_type_hash', '')
            )
            recorder.add_topic(topic, bag.topics[topic][0], latched, kind)
            counts[topic] = 0
        for topic, log_time_ns, published_ns, cdr in bag.records():
            if topic in counts:
                recorder.write(topic, cdr, log_time_ns, published_ns)
                counts[topic] += 1
    return counts, left_out
