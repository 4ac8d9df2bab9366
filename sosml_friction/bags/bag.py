# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read a recorded bag: whole, cut off, or recorded by ``ros2 bag record``."""

from __future__ import annotations

import re
import shutil
import tempfile
import weakref
from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Channel, Schema

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.bag_metadata import (
    CHECKSUM,
    METADATA,
    as_mapping,
    read_metadata,
    refuse_compressed_messages,
    text_checksum,
)
from sosml_friction.bags.chunk_data import Region
from sosml_friction.bags.joint_log import LARGEST, JointLog
from sosml_friction.bags.joint_state_layout import FIELDS
from sosml_friction.bags.joint_states import JointStates, read_joint_states
from sosml_friction.bags.mcap_scan import McapScan, scan
from sosml_friction.bags.message_definitions import JOINT_STATE, STRING, TEMPERATURE, TRAJECTORY
from sosml_friction.bags.message_store import MessageStore
from sosml_friction.bags.other_bag import copy_bag, is_other_bag
from sosml_friction.bags.serialization import (
    deserialize,
    plain_string,
    plain_temperature,
    stamp_ns,
)
from sosml_friction.bags.stand_in import refuse_stand_in
from sosml_friction.bags.topic import Topic, merge_topics
from sosml_friction.bags.wrap import unwrapped
from sosml_friction.exceptions import BagError, ConfigurationError
from sosml_friction.yaml_text import parse_yaml


class WantedMotion(NamedTuple):
    """
    Hold a trajectory that was sent to the driver, as it was sent.

    ``log_time_ns``: when it was recorded; ``names`` n joints; ``times`` (M,) [s] from its start;
    ``positions`` (M, n) [rad or m]; ``velocities`` (M, n) [rad/s or m/s] or None.
    """

    log_time_ns: int
    names: tuple[str, ...]
    times: FloatArray
    positions: FloatArray
    velocities: FloatArray | None


class Bag:
    """
    Give access to the messages of a bag; made by :meth:`open`.

    Topics are found by the last part of their names: ``/left/joint_states`` is ``joint_states`` if
    no other topic ends so. If several do, ``namespace`` chooses.

    ``recovered`` is True when the end of a file is missing, or when what was read is not what the
    files, their checksums and metadata.yaml say is there; then ``recovery`` says in one sentence
    what is wrong and what was saved, and is '' otherwise. ``tags`` are the conditions written by
    the recorder (rosbag2's custom data). No file stays open between calls.
    """

    def __init__(self, path: Path, namespace: str | None, scans: Sequence[McapScan]) -> None:
        self.path = path
        self._namespace = None if namespace is None else '/' + namespace.strip('/')
        self._regions: list[Region] = scans[0].regions
        self._scans = scans
        self._topics = merge_topics(path, scans)
        self.messages_read = sum(len(topic) for topic in self._topics.values())
        information, said = _information(path, scans)
        refuse_compressed_messages(path, information)
        counted = information[0].get('message_count') if information else None
        self._counted = counted if isinstance(counted, int) and counted > 0 else None
        damage = [f'{s.path.name} {reason}' for s in scans for reason in s.damage]
        damage += [*said, *self._miscounted(information)]
        self.recovered = bool(damage)
        self.recovery = ''
        if damage:
            upto = (
                ', up to the last whole one,'
                if any(s.is_cut and not s.beyond for s in scans)
                else ''
            )
            self.recovery = (
                f'{path} was not closed or is damaged ({", ".join(damage)}): '
                f'{self.messages_read} messages{upto} were read'
            )
        self.tags = {
            str(key): str(value)
            for part in information
            for key, value in (as_mapping(part.get('custom_data'))).items()
        }
        if not self.messages_read:
            found = f', or try sosml repair ({", ".join(damage)})' if damage else ''
            raise BagError(
                f'{path} holds no {"whole " if damage else ""}message: record again, with the '
                f'nodes running{found}'
            )

    def _miscounted(self, information: Sequence[dict[Any, Any]]) -> list[str]:
        """Return what metadata.yaml counts otherwise than the files of the bag have it."""
        if not (self.path / METADATA).is_file() or not information:
            return []
        stated = information[0].get('message_count')
        if isinstance(stated, int) and stated != self.messages_read:
            return [f'metadata.yaml counts {stated} messages']
        entries = information[0].get('topics_with_message_count')
        for entry in entries if isinstance(entries, list) else ():
            topic = as_mapping(as_mapping(entry).get('topic_metadata'))
            name, count = topic.get('name'), as_mapping(entry).get('message_count')
            found = self._topics.get(str(name))
            kind = '' if found is None else found.type_name
            if (0 if found is None else len(found)) != count or kind not in (
                '',
                topic.get('type'),
            ):
                return [f'metadata.yaml has other messages of {name}']
        return []

    @classmethod
    def open(cls, path: str | Path, namespace: str | None = None, beyond: bool = False) -> Bag:
        """
        Open a bag folder, with or without metadata.yaml, or a single .mcap file.

        A bag in SQLite (.db3) or of ROS 1 (.bag) is read by way of a copy in MCAP, which is
        removed with the object; see :func:`sosml_friction.bags.other_bag.copy_bag`.

        :param beyond: whether what a checksum shows to be whole is read behind a damaged place
            too; there are holes in such a recording.
        :raises BagError: if ``path`` is missing, is not a bag, or holds no message.
        """
        path = Path(path)
        if is_other_bag(path):
            place = Path(tempfile.mkdtemp(prefix='sosml_'))
            try:
                bag = cls.open(copy_bag(path, place / path.stem), namespace, beyond)
            except BaseException:
                shutil.rmtree(place)
                raise
            weakref.finalize(bag, shutil.rmtree, place, ignore_errors=True)
            bag.path = path
            return bag
        files = _mcap_files(path)
        for file in files:
            refuse_stand_in(file)
        regions: list[Region] = []
        return cls(path, namespace, [scan(file, regions, beyond) for file in files])

    @property
    def topics(self) -> dict[str, tuple[str, int]]:
        """Return the type and the number of messages of each topic."""
        return {name: (topic.type_name, len(topic)) for name, topic in self._topics.items()}

    @property
    def stated_messages(self) -> int | None:
        """Return how many messages the files or else metadata.yaml state, None if neither does."""
        stated = [found.stated for found in self._scans if found.stated is not None]
        return sum(stated) if len(stated) == len(self._scans) else self._counted

    def channels(self) -> dict[str, tuple[Schema | None, Channel]]:
        """Return the schema, where there is one, and the channel of each topic."""
        return {
            channel.topic: (found.schemas.get(channel.schema_id), channel)
            for found in self._scans
            for channel in found.channels.values()
        }

    @property
    def start_ns(self) -> int:
        """Return the log time of the first message [ns]."""
        return min(int(topic.log_time_ns[0]) for topic in self._topics.values() if len(topic))

    @property
    def end_ns(self) -> int:
        """Return the log time of the last message [ns]."""
        return max(int(topic.log_time_ns[-1]) for topic in self._topics.values() if len(topic))

    @property
    def duration_s(self) -> float:
        """Return the log time from the first to the last message [s]."""
        return (self.end_ns - self.start_ns) * 1e-9

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """
        Yield (log_time_ns, CDR bytes) of each message of a topic, given by its whole name.

        :raises BagError: if the bag does not have the topic.
        """
        entry = self._topics[self._known(topic)]
        with closing(MessageStore(self._regions)) as store:
            columns = [column.tolist() for column in (entry.log_time_ns, *entry.places)]
            for log_time_ns, region, offset, length in zip(*columns, strict=True):
                yield log_time_ns, store.fetch(region, offset, length)

    def timeline(self) -> Iterator[tuple[str, int, bytes]]:
        """Yield (topic, log_time_ns, CDR bytes) of every message of the bag in log time order."""
        return ((topic, log_time_ns, cdr) for topic, log_time_ns, _, cdr in self.records())

    def records(self) -> Iterator[tuple[str, int, int, bytes]]:
        """Yield (topic, log_time_ns, publish_time_ns, CDR bytes) in log time order."""
        names = list(self._topics)
        entries = list(self._topics.values())
        columns = zip(*((entry.log_time_ns, *entry.places) for entry in entries), strict=True)
        log_times, regions, offsets, lengths = map(np.concatenate, columns)
        which = np.repeat(np.arange(len(entries)), [len(entry) for entry in entries])
        # Equal log times keep the order of the file.
        order = np.lexsort((offsets, regions, log_times))
        with closing(MessageStore(self._regions)) as store:
            for i in order.tolist():
                # The time of publication stands before the message.
                start, length = int(offsets[i]) - 8, int(lengths[i]) + 8
                message = store.fetch(int(regions[i]), start, length)
                published = int.from_bytes(message[:8], 'little')
                yield names[which[i]], int(log_times[i]), published, message[8:]

    def decoded(self, topic: str) -> Iterator[tuple[int, Any]]:
        """
        Yield (log_time_ns, message) of each message of a topic, given by its whole name.

        :raises BagError: if the bag does not have the topic or a message cannot be decoded.
        """
        name = self._known(topic)
        self._decodable(name)
        for log_time_ns, cdr in self.messages(name):
            yield log_time_ns, self._decode(name, log_time_ns, cdr)

    def _decodable(self, topic: str, type_name: str = '') -> Topic:
        """Return a topic, which is of that type, if one is given, and can be decoded."""
        entry = self._topics[topic]
        actual = entry.type_name or 'topic of unknown type'
        if type_name and actual != type_name:
            raise BagError(f'{topic} in {self.path} is a {actual}: a {type_name} is needed')
        if entry.encoding != 'cdr':
            raise BagError(
                f'{topic} in {self.path} is encoded as {entry.encoding!r}: only cdr, which ROS 2 '
                'records, can be decoded'
            )
        return entry

    def _decode(self, topic: str, log_time_ns: int, cdr: bytes) -> Any:
        try:
            return deserialize(cdr, self._topics[topic].type_name)
        except BagError as error:
            raise BagError(f'{topic} in {self.path} at {log_time_ns} ns: {error}') from error

    def joint_log(self, topic: str | None = None) -> JointLog:
        """
        Return the measured motion: the JointState messages of ``topic``, or of joint_states.

        If no topic is called so, the only one of that type is taken.
        Joints are those of all messages, in order of first appearance. A sample has NaN for a
        joint or quantity that its message lacks, and for a value that no joint can have (infinite,
        1e9 and more). Temperatures (``joint_temperatures``, frame_id = joint) are those last
        measured at or before each sample. A position that wraps is made continuous here, for all
        that reads a bag; ``wraps`` of the log has the period.

        :raises BagError: if there is no such topic, or more than one; if a message contradicts
            itself, or no message carries a stamp.
        """
        chosen = self._joint_state_topic(topic)
        t_ns, names, (q, v, tau) = self._joint_states(chosen, ('position', 'velocity', 'effort'))
        temperature = self._temperatures(chosen, topic is not None, t_ns, names)
        return unwrapped(JointLog(names, t_ns, q, v, tau, temperature, dict(self.tags)))

    def reference(self) -> tuple[IndexArray, tuple[str, ...], FloatArray] | None:
        """
        Return stamps (N,), joints and wanted positions (N, n), None if none are recorded.

        They are the JointState messages of ``controller_reference``; one that wraps is made
        continuous.

        :raises BagError: if several topics end so, or a message contradicts itself.
        """
        found = self._series('controller_reference', 'position')
        if found is None:
            return None
        t_ns, names, q = found
        nothing = np.full_like(q, np.nan)
        return t_ns, names, unwrapped(JointLog(names, t_ns, q, nothing, nothing)).q

    def injected(self) -> tuple[IndexArray, tuple[str, ...], FloatArray] | None:
        """
        Return stamps (N,), joints and efforts (N, n) [Nm or N] added to the controllers' command.

        They are the JointState messages of ``injected_effort``; None if none are recorded. A joint
        without such a signal has NaN.

        :raises BagError: if several topics end so, or a message contradicts itself.
        """
        return self._series('injected_effort', 'effort')

    def _series(
        self, ending: str, field: str
    ) -> tuple[IndexArray, tuple[str, ...], FloatArray] | None:
        """Return one field of the JointState messages of a topic, None if it is not there."""
        topic = self._find(ending)
        if topic is None:
            return None
        t_ns, names, (values,) = self._joint_states(topic, (field,))
        return t_ns, names, values

    def trajectories(self) -> list[WantedMotion]:
        """
        Return the messages of ``joint_trajectory`` in the order they were recorded.

        :raises BagError: if several topics end so, or a message contradicts itself.
        """
        topic = self._find('joint_trajectory')
        if topic is None:
            return []
        self._decodable(topic, TRAJECTORY)
        found = []
        for log_time_ns, message in self.decoded(topic):
            points, n = message.points, len(message.joint_names)
            times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points]
            slow = not any(len(p.velocities) for p in points)
            if (
                not n
                or not points
                or any(len(p.positions) != n for p in points)
                or any(len(p.velocities) != (0 if slow else n) for p in points)
                or times[0] < 0.0
                or any(later <= one for one, later in pairwise(times))
            ):
                raise BagError(
                    f'{topic} in {self.path} has a trajectory whose points do not each have a '
                    'later time and a value for every joint: send it again and record it'
                )
            found.append(
                WantedMotion(
                    log_time_ns,
                    tuple(message.joint_names),
                    np.array(times),
                    np.array([p.positions for p in points], dtype=float),
                    None if slow else np.array([p.velocities for p in points], dtype=float),
                )
            )
        return found

    def text(self, topic_suffix: str) -> str | None:
        """
        Return the last text on a String topic such as robot_description, or None.

        :raises BagError: if several topics end so, or the topic is not a String.
        """
        topic = self._find(topic_suffix)
        if topic is None:
            return None
        entry = self._decodable(topic, STRING)
        log_time_ns, place = int(entry.log_time_ns[-1]), (int(each[-1]) for each in entry.places)
        with closing(MessageStore(self._regions)) as store:
            last = store.fetch(*place)
        # Without rclpy, which takes longer to import than many a bag to read.
        text = plain_string(last)
        return str(self._decode(topic, log_time_ns, last).data) if text is None else text

    def _in_namespace(self) -> dict[str, Topic]:
        """Return the topics of the chosen namespace, or all."""
        if self._namespace is None:
            return self._topics
        # The robot at the root: its own topics and their branches, no other namespace.
        is_root = self._namespace == '/'
        begin = '/friction_estimate/' if is_root else f'{self._namespace}/'
        return {
            name: entry
            for name, entry in self._topics.items()
            if name.startswith(begin) or (is_root and name.count('/') == 1)
        }

    def _find(self, suffix: str) -> str | None:
        """Return the one topic with messages whose name ends in ``suffix``, or None."""
        suffix = '/' + suffix.strip('/')
        found = [
            name
            for name, entry in self._in_namespace().items()
            if ('/' + name.lstrip('/')).endswith(suffix) and len(entry)
        ]
        if len(found) > 1:
            raise BagError(
                f'{self.path} has {len(found)} topics that end in {suffix} ({", ".join(found)}): '
                'choose one by its namespace'
            )
        return found[0] if found else None

    def _known(self, topic: str) -> str:
        """Return the name of a topic of this bag, given with or without its leading slash."""
        for name in (topic, '/' + topic):
            if name in self._topics:
                return name
        raise BagError(f'{self.path} has no topic {topic}: it has {self._topic_list()}')

    def _topic_list(self) -> str:
        return ', '.join(
            f'{name} ({entry.type_name}, {len(entry)} messages)'
            for name, entry in self._topics.items()
        )

    def _joint_state_topic(self, topic: str | None) -> str:
        chosen = self._find('joint_states') if topic is None else self._known(topic)
        if chosen is None:
            # Another driver may use another name; what this package publishes is no measurement.
            others = [
                name
                for name, entry in self._in_namespace().items()
                if entry.type_name == JOINT_STATE
                and len(entry)
                and not re.search(r'friction_estimate|controller_reference|injected_effort', name)
            ]
            chosen = others[0] if len(others) == 1 else None
        if chosen is None:
            within = '' if self._namespace is None else f' in the namespace {self._namespace}'
            raise BagError(
                f'{self.path} has no messages on joint_states{within}: it has {self._topic_list()}'
            )
        if not len(self._decodable(chosen, JOINT_STATE)):
            raise BagError(f'{chosen} in {self.path} has no messages: record it again')
        return chosen

    def _joint_states(
        self, topic: str, quantities: Sequence[str]
    ) -> tuple[IndexArray, tuple[str, ...], list[FloatArray]]:
        """Return stamps (N,), names of n joints, and (N, n) of each quantity, NaN if absent."""
        entry = self._decodable(topic, JOINT_STATE)

        def decode(row: int, cdr: bytes) -> Any:
            return self._decode(topic, int(entry.log_time_ns[row]), cdr)

        with closing(MessageStore(self._regions)) as store:
            found = read_joint_states(store, entry.places, quantities, decode)
        self._refuse_contradictions(topic, found)
        if len(entry) > 1 and not found.t_ns.any():
            raise BagError(
                f'{topic} in {self.path} has no stamps (all are 0): let its publisher fill '
                'header.stamp with the time of measurement'
            )
        arrays = [found.table(quantity) for quantity in quantities]
        for table in arrays:
            # What no joint can do was not measured.
            table[~(np.abs(table) < LARGEST)] = np.nan
        return found.t_ns, found.names, arrays

    def _refuse_contradictions(self, topic: str, found: JointStates) -> None:
        """Raise for the first message that is none, or contradicts itself."""
        problem = found.problem
        for names, counts in found.blocks:
            row = found.first((names, counts))
            if problem is not None and problem[0] < row:
                continue
            odd = [
                f'{n} values of {what}'
                for what, n in zip(FIELDS, counts, strict=True)
                if n not in (0, len(names))
            ]
            if len(set(names)) != len(names):
                what = f'joints {", ".join(names)}'
            elif odd:
                what = f'{len(names)} joint names and {odd[0]}'
            else:
                continue
            stamp = int(found.t_ns[row])
            problem = (
                row,
                BagError(
                    f'{topic} in {self.path} at stamp {stamp} ns has {what}: each joint needs one '
                    'name and one value, or the array must be empty; correct its publisher'
                ),
            )
        if problem is not None:
            raise problem[1]

    def _temperatures(
        self, joint_topic: str, explicit: bool, t_ns: IndexArray, names: tuple[str, ...]
    ) -> FloatArray | None:
        """Return (N, n) [degC], the value last measured at or before each sample, or None."""
        beside = joint_topic.rpartition('/')[0] + '/joint_temperatures'
        topic: str | None = beside if beside in self._topics else None
        if topic is None and not explicit:
            topic = self._find('joint_temperatures')
        if topic is None:
            return None
        self._decodable(topic, TEMPERATURE)
        measured: dict[str, tuple[list[int], list[float]]] = {}
        for log_time_ns, cdr in self.messages(topic):
            plain = plain_temperature(cdr)
            if plain is None:
                message = self._decode(topic, log_time_ns, cdr)
                header = message.header
                plain = stamp_ns(header.stamp), header.frame_id, message.temperature
            stamp, joint, celsius = plain
            stamps, values = measured.setdefault(joint, ([], []))
            stamps.append(stamp)
            values.append(celsius)
        if not any(name in measured for name in names):
            return None
        temperature = np.full((len(t_ns), len(names)), np.nan)
        for i, name in enumerate(names):
            if name not in measured:
                continue
            when, degrees = (np.array(column) for column in measured[name])
            order = np.argsort(when, kind='stable')
            last = np.searchsorted(when[order], t_ns, side='right') - 1
            known = last >= 0
            temperature[known, i] = degrees[order][last[known]]
        return temperature


def _mcap_files(path: Path) -> list[Path]:
    """Return the MCAP files of a bag in the order they were recorded, at least one."""
    if not path.exists():
        raise BagError(f'{path} does not exist: give a bag folder, a .mcap file or a table')
    if path.is_file():
        return [path]
    try:
        names = sorted(file.name for file in path.iterdir() if file.is_file())
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from error
    files = [name for name in names if name.endswith('.mcap')]
    if files:
        # name_2.mcap comes before name_10.mcap.
        files.sort(
            key=lambda name: [int(p) if p.isdigit() else p for p in re.split(r'(\d+)', name)]
        )
        return [path / name for name in files]
    packed = [name for name in names if name.endswith(('.mcap.zstd', '.db3.zstd'))]
    if packed:
        raise BagError(
            f'{path} holds compressed files only ({packed[0]}): unpack them with `zstd -d`, or '
            'record with --storage-preset-profile zstd_fast, which is read directly'
        )
    raise BagError(
        f'{path} is no bag: the folder holds no .mcap or .db3 file; give the folder of one bag'
    )


def _information(path: Path, scans: Sequence[McapScan]) -> tuple[list[dict[Any, Any]], list[str]]:
    """Return what rosbag2 wrote about the bag, beside the files and in them, and its damage."""
    parts, damage = [], []
    if (path / METADATA).is_file():
        stated = read_metadata(path)
        if stated is None:
            damage.append(f'{METADATA} cannot be read')
        parts.append(stated or {})
    for found in scans:
        for record in found.metadata:
            if record.name != 'rosbag2':
                continue
            text = record.metadata.get('serialized_metadata', '')
            checksum = record.metadata.get(CHECKSUM)
            try:
                if checksum is not None and checksum != text_checksum(text):
                    raise ConfigurationError('the checksum does not match')
                parts.append(as_mapping(parse_yaml(text, METADATA)))
            except ConfigurationError:
                damage.append(f'{found.path.name} has damaged tags')
    tags = [own for part in parts if (own := as_mapping(part.get('custom_data')))]
    if any(own != tags[-1] for own in tags):
        damage.append('its tags are stated in two ways')
    return parts, damage
