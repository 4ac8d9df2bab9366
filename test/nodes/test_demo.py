# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How the demo calls the services of nodes that are still starting, or too busy to be heard."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip('rclpy')

from rclpy.task import Future
from std_srvs.srv import Trigger

from sosml_friction.exceptions import ActuatorError
from sosml_friction.nodes import demo_client


class Service:
    """Stands in for a client of a service that gives these answers in turn; None: none at all."""

    def __init__(self, *answers: Trigger.Response | None) -> None:
        self.answers = list(answers)
        self.asked = 0
        self.forgotten: list[Future] = []

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, request: Any) -> Future:
        future = Future()
        answer = self.answers[min(self.asked, len(self.answers) - 1)]
        self.asked += 1
        if answer is not None:
            future.set_result(answer)
        return future

    def remove_pending_request(self, future: Future) -> None:
        self.forgotten.append(future)


@pytest.fixture
def client_of(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a maker of the demo's own node, on a clock that each spin moves by 0.1 s."""
    clock = [0.0]
    monkeypatch.setattr(demo_client, 'time', SimpleNamespace(monotonic=lambda: clock[0]))

    def spin_once(timeout_sec: float) -> None:
        clock[0] += timeout_sec

    def make(service: Service) -> demo_client.DemoClient:
        node: Any = SimpleNamespace(
            create_subscription=lambda *_: None, create_client=lambda *_: service
        )
        executor: Any = SimpleNamespace(spin_once=spin_once)
        return demo_client.DemoClient(node, executor, [], lambda what, share=None: None)

    return make


YES, NO = Trigger.Response(success=True), Trigger.Response(success=False, message='not yet')


def test_a_node_that_says_no_or_nothing_is_asked_until_it_says_yes(client_of):
    service = Service(NO, None, YES)
    client_of(service).call(Trigger, 'node/start', Trigger.Request())
    assert service.asked == 3
    assert len(service.forgotten) == 1


def test_what_was_begun_is_not_begun_again_for_a_reply_that_was_lost(client_of):
    service = Service(None)
    client_of(service).call(Trigger, 'node/start', Trigger.Request(), lambda: service.asked == 1)
    assert service.asked == 1


@pytest.mark.parametrize(('answer', 'words'), [(None, 'no answer'), (NO, 'not yet')])
def test_a_node_that_never_says_yes_is_told_with_its_last_answer(client_of, answer, words):
    service = Service(answer)
    with pytest.raises(ActuatorError, match=f'node/start did not succeed within 60 s: {words}'):
        client_of(service).call(Trigger, 'node/start', Trigger.Request())
    assert service.asked > 10
