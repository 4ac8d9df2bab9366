# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Record serialised ROS 2 messages to a bag folder that survives a crash."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic_ns
from typing import Any, NamedTuple

import yaml
from mcap.exceptions import McapError
from mcap.writer import CompressionType, Writer

from sosml_friction.bags.bag_metadata import CHECKSUM, INFORMATION, METADATA, text_checksum
from sosml_friction.bags.message_definitions import message_definition, split_type_name, type_hash
from sosml_friction.exceptions import BagError

# Version of rosbag2's metadata that ROS 2 Jazzy writes; since 9 the QoS policies are words.
METADATA_VERSION = 9
CHUNK_BYTES = 64 * 1024
FLUSH_INTERVAL_NS = 200_000_000

_INFINITE = {'sec': 9223372036, 'nsec': 854775807}


def offered_qos(latched: bool) -> list[dict[str, Any]]:
    """Return rosbag2's form (metadata version 9) of a reliable offer, latched or volatile."""
    return [
        {
            'history': 'keep_last',
            'depth': 1 if latched else 1000,
            'reliability': 'reliable',
            'durability': 'transient_local' if latched else 'volatile',
            'deadline': dict(_INFINITE),
            'lifespan': dict(_INFINITE),
            'liveliness': 'automatic',
            'liveliness_lease_duration': dict(_INFINITE),
            'avoid_ros_namespace_conventions': False,
        }
    ]


class TypeDefinition(NamedTuple):
    """Hold how messages of a type are made: ``encoding`` names the language of ``text``."""

    text: bytes
    encoding: str
    hash: str

    @classmethod
    def installed(cls, type_name: str) -> TypeDefinition:
        """
        Return the definition of a type that is installed.

        :raises BagError: if it is not.
        """
        return cls(message_definition(type_name).encode(), 'ros2msg', type_hash(type_name))


@dataclass
class _Topic:
    """One recorded topic: its channel in the file, its type and how many messages it has."""

    channel_id: int
    type_name: str
    type_hash: str
    latched: bool
    message_count: int = 0


class BagRecorder:
    """
    Write ``<folder>/<name>_0.mcap`` and, when closed, ``metadata.yaml`` as rosbag2 does.

    The file is what ``ros2 bag record -s mcap`` makes: profile ``ros2``, schemas ``ros2msg``,
    messages ``cdr``, uncompressed chunks with message indexes. After a crash (``kill -9``) all
    but the last 0.5 s can be read: a chunk is handed to the operating system when it reaches 64
    KiB and on the first write 0.2 s or more after the last hand-over, by log time or by the
    monotonic clock, whichever says so first. A topic that falls silent leaves its last 0.2 s in
    memory until :meth:`flush`, which a node therefore calls at 5 Hz. Power loss is another
    matter: nothing is forced to the disk.

    A recorder that could not write once writes nothing more: what it has is that of a recording
    that was cut off, and never one with a hole that calls itself whole.

    All methods may be called from several threads.

    :param folder: the bag to make; its last part names the file in it.
    :param tags: conditions of the recording (worn, payload, ...), kept as rosbag2's custom data.
    :raises BagError: if ``folder`` exists or cannot be made.
    """

    def __init__(self, folder: str | Path, tags: Mapping[str, str] | None = None) -> None:
        self.folder = Path(folder)
        self.path = self.folder / f'{self.folder.resolve().name}_0.mcap'
        self._tags = {str(key): str(value) for key, value in (tags or {}).items()}
        self._lock = threading.Lock()
        self._topics: dict[str, _Topic] = {}
        self._schema_ids: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0
        self._recent_ns: int | None = None
        self._flushed_log_ns: int | None = None
        self._flushed_clock_ns = monotonic_ns()
        self._closed = False
        self._failed: BagError | None = None
        try:
            self.folder.mkdir(parents=True)
        except FileExistsError:
            raise BagError(
                f'{self.folder} exists and is not overwritten: choose another name or remove it'
            ) from None
        except OSError as error:
            raise BagError(
                f'the bag {self.folder} cannot be made: {error.strerror}: choose another place'
            ) from error
        try:
            self._stream = self.path.open('xb')
        except OSError as error:
            raise self._write_error(error) from error
        self._writer = Writer(
            self._stream,
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.NONE,
            enable_data_crcs=True,
        )
        with self._writing():
            self._writer.start(profile='ros2', library='sosml_friction')
            # Says which version the words in offered_qos_profiles belong to, even if the end of
            # the file is never written.
            self._add_metadata_record()
            self._writer.flush()

    def __enter__(self) -> BagRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def message_count(self) -> int:
        """Return how many messages were written."""
        with self._lock:
            return sum(topic.message_count for topic in self._topics.values())

    def add_topic(
        self,
        topic: str,
        type_name: str,
        latched: bool | None = None,
        definition: TypeDefinition | None = None,
    ) -> None:
        """
        Announce a topic; again with the same type changes nothing.

        ``latched`` is the durability ``ros2 bag play`` will offer; None means latched for
        std_msgs/String (robot_description and its like) and volatile for the rest. ``definition``
        is that of the type, where it need not be installed.

        :raises BagError: if the type is not installed, or the topic has another one already.
        """
        package, name = split_type_name(type_name)
        type_name = f'{package}/msg/{name}'
        with self._writing():
            known = self._topics.get(topic)
            if known is not None:
                if known.type_name != type_name:
                    raise BagError(
                        f'{topic} is recorded as {known.type_name} and cannot be {type_name} too'
                    )
                return
            if latched is None:
                latched = type_name == 'std_msgs/msg/String'
            definition = definition or TypeDefinition.installed(type_name)
            if type_name not in self._schema_ids:
                self._schema_ids[type_name] = self._writer.register_schema(
                    type_name, definition.encoding, definition.text
                )
            channel_id = self._writer.register_channel(
                topic,
                'cdr',
                self._schema_ids[type_name],
                {
                    'offered_qos_profiles': _dump(offered_qos(latched)).strip(),
                    'topic_type_hash': definition.hash,
                },
            )
            self._topics[topic] = _Topic(channel_id, type_name, definition.hash, latched)

    def write(
        self, topic: str, cdr_bytes: bytes, log_time_ns: int, publish_time_ns: int | None = None
    ) -> None:
        """
        Append one message as received: time of reception and, where known, of publication.

        :raises BagError: if the topic was not added, a time is negative, the recorder is closed or
            the disk refuses.
        """
        if publish_time_ns is None:
            publish_time_ns = log_time_ns
        with self._writing():
            entry = self._topics.get(topic)
            if entry is None:
                raise BagError(f'{topic} was not added to the bag {self.folder}: add_topic first')
            if not (0 <= log_time_ns < 2**63 and 0 <= publish_time_ns < 2**63):
                raise BagError(
                    f'{topic} has the time {min(log_time_ns, publish_time_ns)} ns: a bag holds '
                    'times from 0 to 2^63 ns only'
                )
            self._writer.add_message(
                entry.channel_id, log_time_ns, cdr_bytes, publish_time_ns, entry.message_count
            )
            entry.message_count += 1
            if self._first_ns is None:
                self._first_ns = self._last_ns = log_time_ns
            self._first_ns = min(self._first_ns, log_time_ns)
            self._last_ns = max(self._last_ns, log_time_ns)
            # Log time alone would stall with a paused simulation clock, the monotonic clock alone
            # would let a fast import build chunks of any duration; abs() because log time can
            # step back.
            clock_ns = monotonic_ns()
            if (
                self._flushed_log_ns is None
                or abs(log_time_ns - self._flushed_log_ns) >= FLUSH_INTERVAL_NS
                or clock_ns - self._flushed_clock_ns >= FLUSH_INTERVAL_NS
            ):
                self._writer.flush()
                self._flushed_log_ns = log_time_ns
                self._flushed_clock_ns = clock_ns
            self._recent_ns = log_time_ns

    def flush(self) -> None:
        """
        Hand every message that was written to the operating system.

        :raises BagError: if the recorder is closed or the disk refuses.
        """
        with self._writing():
            self._writer.flush()
            self._flushed_log_ns = self._recent_ns
            self._flushed_clock_ns = monotonic_ns()

    def close(self) -> None:
        """
        Finish the file and write ``metadata.yaml``; again does nothing.

        :raises BagError: if the disk refuses.
        """
        with self._lock:
            if self._closed:
                return
            self._closed = True
            if self._failed is not None:
                with contextlib.suppress(OSError):
                    self._stream.close()
                return
            try:
                self._writer.flush()
                self._add_metadata_record()
                self._writer.finish()
                self._stream.close()
                # A reader never sees half a metadata.yaml.
                temporary = self.folder / f'{METADATA}.tmp'
                temporary.write_text(_dump({INFORMATION: self._information()}), encoding='utf-8')
                os.replace(temporary, self.folder / METADATA)
            except OSError as error:
                with contextlib.suppress(OSError):
                    self._stream.close()
                raise self._write_error(error) from error

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Hold the lock over one operation on the open file and name what goes wrong."""
        with self._lock:
            if self._closed:
                raise BagError(f'the bag {self.folder} is closed: nothing more can be recorded')
            if self._failed is not None:
                raise self._failed
            try:
                yield
            except (OSError, McapError) as error:
                self._failed = self._write_error(error)
                raise self._failed from error

    def _write_error(self, error: Exception) -> BagError:
        reason = getattr(error, 'strerror', None) or error
        return BagError(
            f'the bag {self.folder} cannot be written: {reason}: free or choose another disk'
        )

    def _add_metadata_record(self) -> None:
        """Append the record from which ``ros2 bag info`` reads a single file."""
        text = _dump(self._information())
        checked = {'serialized_metadata': text, CHECKSUM: text_checksum(text)}
        self._writer.add_metadata('rosbag2', checked)

    def _information(self) -> dict[str, Any]:
        """Return rosbag2's BagMetadata of what was written up to now."""
        count = sum(topic.message_count for topic in self._topics.values())
        start = {'nanoseconds_since_epoch': self._first_ns or 0}
        duration = {'nanoseconds': self._last_ns - (self._first_ns or 0)}
        return {
            'version': METADATA_VERSION,
            'storage_identifier': 'mcap',
            'duration': duration,
            'starting_time': start,
            'message_count': count,
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': name,
                        'type': topic.type_name,
                        'serialization_format': 'cdr',
                        'offered_qos_profiles': offered_qos(topic.latched),
                        'type_description_hash': topic.type_hash,
                    },
                    'message_count': topic.message_count,
                }
                for name, topic in self._topics.items()
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self.path.name],
            'files': [
                {
                    'path': self.path.name,
                    'starting_time': dict(start),
                    'duration': dict(duration),
                    'message_count': count,
                }
            ],
            'custom_data': dict(self._tags) or None,
            'ros_distro': os.environ.get('ROS_DISTRO') or 'jazzy',
        }


class _PlainDumper(yaml.SafeDumper):
    """Write equal parts out in full: yaml-cpp reads anchors, other readers of bags may not."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _dump(value: Any) -> str:
    return yaml.dump(value, Dumper=_PlainDumper, sort_keys=False, default_flow_style=False)
