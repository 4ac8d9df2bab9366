# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Functions of two quantities at once: what is in them, and what is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording

from sosml_friction.regression.curves.axes import LOAD, NEIGHBOURS, POSITION, SPEED, TIME
from sosml_friction.regression.curves.pairs import WAVES, Pairs
from sosml_friction.regression.curves.wandering import WANDERING_HATS, Wandering
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare


@pytest.fixture(scope='module')
def signals() -> Signals:
    """Return an arm on its sines, 60 s."""
    model = arm_model()
    t = np.arange(0.0, 60.0, 4e-3)
    q, _, _ = arm_motion(t)
    log = recording(('shoulder', 'elbow'), t, q, 0.0 * q)
    return prepare([log], model, model.make_robot(), DiagnosisSettings(band=15.0))[0]


def columns(pairs: Pairs, signals: Signals, joint: int, axes: tuple[str, str]) -> np.ndarray:
    """Return the columns (N, WAVES^2) of two quantities."""
    at = pairs.axes(joint).index(axes)
    whole = pairs.own_columns(signals, joint, ({},))[:, 0]
    assert whole.shape[1] == WAVES**2 * len(pairs.axes(joint))
    return whole[:, WAVES**2 * at : WAVES**2 * (at + 1)]


def test_every_two_quantities_of_a_joint_have_their_columns(signals):
    own = {SPEED, TIME, POSITION, LOAD, *NEIGHBOURS}
    found = Pairs([signals]).axes(0)
    assert {frozenset(pair) for pair in found} == {
        frozenset((a, b)) for a in own for b in own - {a}
    }
    assert len(found) == 15


def test_positions_at_once_span_their_product_and_no_function_of_one(signals):
    """By least squares against each, over ranks: a product of cosines is one of the columns."""
    C = columns(Pairs([signals]), signals, 0, (POSITION, NEIGHBOURS[0]))

    def share(y: np.ndarray) -> float:
        return 1.0 - np.var(y - C @ np.linalg.lstsq(C, y)[0]) / np.var(y)

    # As far as five knots follow the ranks.
    rank = np.argsort(np.argsort(signals.q, axis=0), axis=0) / len(signals.q)
    wave = np.cos(np.pi * rank)
    assert share(wave[:, 0] * wave[:, 1]) > 0.99
    centred = signals.q - signals.q.mean(axis=0)
    assert share(centred[:, 0] * centred[:, 1]) > 0.9
    assert share(wave[:, 0]) < 0.1
    assert share(wave[:, 1]) < 0.1


def test_friction_that_depends_on_speed_and_the_next_joint_changes_with_the_sign(signals):
    """s times a wave of the next joint's position is the first, of any speed."""
    C = columns(Pairs([signals]), signals, 0, (SPEED, NEIGHBOURS[0]))[:, 0]
    turned = replace(signals, sign=-signals.sign)
    assert np.abs(C).max() > 0.9
    again = columns(Pairs([turned]), turned, 0, (SPEED, NEIGHBOURS[0]))[:, 0]
    assert again == pytest.approx(-C, abs=1e-12)


def test_what_is_noise_is_no_quantity(signals):
    """A load of noise, a joint that moves in proportion, and one that stands."""
    shaken = replace(signals, shaken=np.random.default_rng(0).normal(0.0, 9.0, signals.q.shape))
    assert LOAD not in {name for pair in Pairs([shaken]).axes(0) for name in pair}
    doubted = replace(signals, doubted=signals.torque)
    assert LOAD not in {name for pair in Pairs([doubted]).axes(0) for name in pair}
    follows = replace(signals, v=signals.v[:, [0, 0]] * [1.0, 0.5])
    assert NEIGHBOURS[1] not in {name for pair in Pairs([follows]).axes(0) for name in pair}
    still = replace(signals, q=signals.q * [1.0, 0.0], v=signals.v * [1.0, 0.0])
    own = {name for pair in Pairs([still]).axes(0) for name in pair}
    assert own == {SPEED, TIME, POSITION, LOAD}


@pytest.mark.parametrize(('seconds', 'hats'), [(60.0, WANDERING_HATS), (20.0, 30)])
def test_friction_wanders_no_faster_than_rows_tell(signals, seconds, hats):
    """A hat for ten periods of 15 Hz; what there is no hat for is a column of zeros."""
    most = round(seconds / signals.band.step)
    time, sign, v, q = (x[:most] for x in (signals.time, signals.sign, signals.v, signals.q))
    part = replace(signals, time=time, sign=sign, v=v, q=q)
    C = Wandering([part]).own_columns(part, 1, ({},))[:, 0]
    assert C.shape == (len(time), WANDERING_HATS)
    assert np.count_nonzero(C.any(axis=0)) == pytest.approx(hats, abs=1)
    # Hats add to one: friction that does not wander is in them.
    assert C.sum(axis=1) == pytest.approx(sign[:, 1], abs=1e-12)
