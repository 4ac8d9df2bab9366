# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of an observer: of the last second, with the cause and the way out. No ROS here."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from sosml_friction.arrays import FloatArray

#: What is judged [s].
SPAN_S = 1.0

Level = Literal['ok', 'warn', 'error', 'stale']

#: By kind of event: what is said of it, with its number.
_EVENTS = {
    'gap': '{n} gaps in joint_states of more than {gap:.3g} s: the publisher stalls or messages '
    'are lost; relieve the machine or the network, or set parameter maximum_gap',
    'lost': '{n} messages of joint_states lost on the way: relieve the machine or the network',
    'repeated': '{n} messages of joint_states repeat the stamp of the one before: make the driver '
    'stamp each with the time of its measurement',
    'twice': '{n} messages of joint_states name a joint twice, and its first number is taken: '
    'make the publisher name each once',
    'backwards': 'the stamps of joint_states went back {n} times: a bag that loops, a clock that '
    'was set, or two publishers (ros2 topic info -v joint_states names them)',
}
_SLOW = (
    'the driver measures at {hz:.3g} Hz: {repeats} of {count} messages in motion say the same as '
    'the one before: publish each measurement once, with the stamp of its time'
)
#: Said from this share of repeats on: fewer are two clocks that drift apart. Chosen.
_REPEATS = 0.1
_ZERO = (
    'all stamps of joint_states are 0: make the driver stamp each message with the time of its '
    'measurement'
)


@dataclass(frozen=True)
class Said:
    """Hold one status: of which part, how grave, the sentence, and figures."""

    component: str
    level: Level
    message: str
    values: Mapping[str, Any]


class _Estimate(NamedTuple):
    now_s: float
    t_s: float
    known: tuple[bool, ...]
    causes: Mapping[str, str]
    remarks: Mapping[str, str]
    repeats: int | None


class ObserverHealth:
    """
    Judge the last second of an observer.

    Times ``now_s`` are of a clock that always goes forwards; the stamps of the messages may not.

    :param joints: that are observed.
    """

    def __init__(self, joints: Sequence[str]) -> None:
        self._joints = tuple(joints)
        self._estimates: deque[_Estimate] = deque()
        self._events: deque[tuple[float, str]] = deque()
        self._totals: Counter[str] = Counter()
        self._heard_s = math.nan
        self._stamped = False
        self._others: tuple[float, tuple[str, ...]] | None = None
        #: What was found about the topic itself; empty where there is nothing to say.
        self.topic_remark = ''

    def estimated(
        self,
        now_s: float,
        t_ns: int,
        estimate: FloatArray,
        causes: Mapping[str, str],
        remarks: Mapping[str, str] = MappingProxyType({}),
        repeats: int | None = None,
    ) -> None:
        """
        Take the selected estimate (n,) of one sample, why it is NaN, and what else to tell.

        :param repeats: how many before one that is new said the same, of a motion; else None.
        """
        self.heard(now_s, t_ns)
        known = tuple(map(math.isfinite, estimate.tolist()))
        self._estimates.append(_Estimate(now_s, t_ns * 1e-9, known, causes, remarks, repeats))
        self._totals['estimates'] += 1

    def heard(self, now_s: float, t_ns: int) -> None:
        """Note that a message came, whatever was made of it."""
        self._heard_s = now_s
        self._stamped |= t_ns != 0
        self._totals['samples'] += 1
        self._forget(now_s)

    def others(self, now_s: float, names: Sequence[str]) -> None:
        """Note a message without the joints that are observed."""
        self._others = now_s, tuple(names)

    def event(self, now_s: float, kind: str, count: int = 1) -> None:
        """Note something that happened: a gap, a loss, a repeated stamp, time that goes back."""
        self._totals[kind] += count
        self._events.extend([(now_s, kind)] * count)

    def judge(self, now_s: float, gap_s: float) -> list[Said]:
        """
        Return what is to be said: first of the observers as a whole, then of each joint.

        :param gap_s: the longest interval that is no gap.
        """
        self._forget(now_s)
        values = self._values()
        others = ''
        if self._others is not None and now_s - self._others[0] <= SPAN_S:
            others = (
                f'joint_states has the joints {", ".join(self._others[1]) or "(none)"} where the '
                f'model has {", ".join(self._joints)}: name them alike or give another model'
            )
        if not self._totals['samples']:
            text = others or (
                'no joint_states yet: start the driver, or remap joint_states to the topic it '
                'publishes'
            )
            return self._all('stale', self.topic_remark or text, values)
        silence = now_s - self._heard_s
        # A stream may be so slow that a second says nothing.
        if silence > max(SPAN_S, 2.0 * gap_s):
            text = others or (
                f'no joint_states for {silence:.1f} s: see whether the driver runs (ros2 topic hz '
                'joint_states) and start it again'
            )
            return self._all('error', self.topic_remark or text, values)
        if not self._stamped:
            return self._all('error', _ZERO, values)
        joints = [self._joint(i) for i in range(len(self._joints))]
        counts = Counter(kind for _, kind in self._events)
        troubles = [
            _EVENTS[kind].format(n=counts[kind], gap=gap_s) for kind in _EVENTS if counts[kind]
        ]
        troubles += [text for text in (self._slow(values), self.topic_remark) if text]
        known = [said for said in joints if said.level == 'ok']
        level: Level = 'ok'
        text = f'observing {", ".join(self._joints)}'
        if not any(any(e.known) for e in self._estimates):
            level, text = 'error', f'nothing is estimated: {joints[0].message}'
        elif len(known) < len(joints):
            worst = next(said for said in joints if said.level != 'ok')
            level, text = 'warn', f'{worst.component}: {worst.message}'
        if troubles and level == 'ok':
            level, text = 'warn', '; '.join(troubles)
        elif troubles:
            text = f'{text}; {"; ".join(troubles)}'
        return [Said('observers', level, text, values), *joints]

    def _slow(self, values: Mapping[str, Any]) -> str:
        """Return that messages come more often than measurements, or ''."""
        new = [e.repeats for e in self._estimates if e.repeats is not None]
        repeats = sum(new)
        count = len(new) + repeats
        if not repeats or repeats < _REPEATS * count:
            return ''
        hz = values['rate by stamps [Hz]'] * len(new) / count
        return _SLOW.format(hz=hz, repeats=repeats, count=count)

    def _joint(self, i: int) -> Said:
        name, total = self._joints[i], len(self._estimates)
        lost = [e for e in self._estimates if not e.known[i]]
        values = {'estimates in the last second': total, 'not known': len(lost)}
        remarks = [e.remarks[name] for e in self._estimates if name in e.remarks]
        if total and not lost and remarks:
            return Said(name, 'warn', f'{len(remarks)} of {total}: {remarks[-1]}', values)
        if total and not lost:
            return Said(name, 'ok', 'estimating', values)
        causes = Counter(e.causes.get(name, 'the observers start') for e in lost)
        cause = causes.most_common(1)[0][0] if causes else 'no sample in the last second'
        if len(lost) == total:
            return Said(name, 'error', cause, values)
        return Said(name, 'warn', f'{len(lost)} of {total} estimates not known: {cause}', values)

    def _all(self, level: Level, text: str, values: Mapping[str, Any]) -> list[Said]:
        return [Said(name, level, text, values) for name in ('observers', *self._joints)]

    def _values(self) -> dict[str, Any]:
        stamps = [e.t_s for e in self._estimates]
        span = max(stamps) - min(stamps) if stamps else 0.0
        rate = (len(stamps) - 1) / span if span > 0.0 else math.nan
        return {
            'rate by stamps [Hz]': rate,
            'estimates in the last second': len(stamps),
            'estimates since the start': self._totals['estimates'],
            'samples since the start': self._totals['samples'],
            **{f'{kind} since the start': self._totals[kind] for kind in _EVENTS},
        }

    def _forget(self, now_s: float) -> None:
        # A stream may be so slow that a second has none: then the last two speak.
        while len(self._estimates) > 2 and now_s - self._estimates[0].now_s > SPAN_S:
            self._estimates.popleft()
        while self._events and now_s - self._events[0][0] > SPAN_S:
            self._events.popleft()
