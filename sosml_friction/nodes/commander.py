# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Who commands a driver: whoever moves it first, until released, silent or gone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rclpy.node import Node

# What moved so recently moves still: the driver says it 20 times a second.
_MOVING_S = 0.2


class Endpoint(NamedTuple):
    """A publisher, or a client of a service: its process (the DDS participant) and its node."""

    process: bytes
    node: str


def publishers(node: Node, topic: str) -> list[Endpoint]:
    """Return who publishes ``topic`` now."""
    return _endpoints(node, topic, False)


def callers(node: Node, service: str) -> list[Endpoint]:
    """Return who has a client of ``service``; nobody where the middleware does not tell."""
    # A request is a topic of its own, by the naming rules of ROS 2 over DDS.
    return _endpoints(node, f'rq{node.resolve_service_name(service)}Request', True)


def _endpoints(node: Node, topic: str, is_mangled: bool) -> list[Endpoint]:
    # The first 12 bytes of a GUID are the participant's, the rest is the endpoint in it.
    return [
        Endpoint(
            bytes(info.endpoint_gid[:12]),
            f'{info.node_namespace.rstrip("/")}/{info.node_name}'.lstrip('/'),
        )
        for info in node.get_publishers_info_by_topic(topic, no_mangle=is_mangled)
    ]


class Commander:
    """
    Hold who moves the joints, until ``timeout_s`` [s] after its last command and motion.

    ROS 2 does not tell in Python who sent a message or called a service, but who could have: it is
    known where there is one publisher (or client), or where the message names the node of one. A
    process is one commander, whatever nodes it has.
    """

    def __init__(self, timeout_s: float) -> None:
        self._timeout_s = timeout_s
        self._holder: frozenset[bytes] = frozenset()
        self._since_s = 0.0
        #: What to call the holder; empty where nobody holds.
        self.name = ''

    @staticmethod
    def senders(found: Iterable[Endpoint], stated: str = '') -> list[Endpoint]:
        """Return who may have sent a command that states to be of the node ``stated``."""
        found = list(found)
        named = [own for own in found if stated and own.node == stated.lstrip('/')]
        return named or found

    def moves(self, now_s: float) -> None:
        """Note that the joints move: the silence has not begun."""
        self._since_s = now_s

    def watch(self, now_s: float, present: Iterable[Endpoint]) -> None:
        """End the hold after silence, or where its holder is not ``present`` and nothing moves."""
        silence_s = now_s - self._since_s
        gone = self._holder.isdisjoint(own.process for own in present)
        if silence_s > self._timeout_s or (gone and silence_s > _MOVING_S):
            self.release()

    def refusal(self, senders: Sequence[Endpoint]) -> str:
        """Return why none of ``senders`` may command now, '' if they may."""
        processes = {own.process for own in senders}
        if not self.name or (len(processes) == 1 and processes == self._holder):
            return ''
        unsure = ''
        if not self._holder.isdisjoint(processes):
            unsure = (
                ' (ROS does not tell which: a trajectory may name its node in header.frame_id)'
            )
        return (
            f'{_names(senders)}{unsure} may not command: {self.name} holds this driver until '
            f'{self._timeout_s:g} s after its last command and motion (commander_timeout): wait, '
            'or release it by ~/enable with data: false'
        )

    def take(self, senders: Sequence[Endpoint], now_s: float) -> None:
        """Let ``senders``, one of which has commanded a motion, hold the driver."""
        holder = frozenset(own.process for own in senders)
        self._holder, self.name, self._since_s = holder, _names(senders), now_s

    def release(self) -> None:
        """Let anybody command."""
        self._holder, self.name = frozenset(), ''


def _names(senders: Sequence[Endpoint]) -> str:
    return ' or '.join(sorted({own.node for own in senders})) or 'a node that has left'
