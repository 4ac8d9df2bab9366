# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Samples leave the cycle's thread; a publisher that raises or hangs is told once."""

from __future__ import annotations

import threading

from sosml_friction.actuators.driver.sample_relay import SampleRelay


def test_all_samples_arrive_in_order_before_it_ends():
    seen, failures = [], []
    relay = SampleRelay(seen.append, failures.append, 1000)
    relay.start()
    for sample in range(500):
        relay.put(sample)
    assert relay.stop(30.0)
    assert seen == list(range(500))
    assert (failures, relay.dropped) == ([], 0)


def test_a_publisher_that_raises_is_told_with_its_reason():
    failed = threading.Event()
    failures = []

    def publish(_):
        raise ValueError('no publisher')

    def on_failure(reason):
        failures.append(reason)
        failed.set()

    relay = SampleRelay(publish, on_failure, 10)
    relay.start()
    relay.put(1)
    assert failed.wait(30.0)
    relay.join(30.0)
    relay.put(2)
    assert len(failures) == 1
    assert 'no publisher' in failures[0]
    assert isinstance(relay.error, ValueError)
    assert relay.dropped == 1


def test_a_publisher_that_hangs_is_told_when_the_queue_is_full_and_nobody_waits_for_it():
    entered, release = threading.Event(), threading.Event()
    failures = []

    def publish(_):
        entered.set()
        release.wait(60.0)

    relay = SampleRelay(publish, failures.append, 5)
    relay.start()
    relay.put(0)
    assert entered.wait(30.0)
    for sample in range(1, 9):
        relay.put(sample)
    assert failures == ['5 samples wait to be published: the publisher hangs']
    assert relay.dropped == 3
    assert not relay.stop(0.0)
    release.set()
    relay.join(30.0)
