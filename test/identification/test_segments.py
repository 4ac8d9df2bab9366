# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Steady windows: every plateau once, nothing else, and why not."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.segments import (
    SegmentSettings,
    find_segments,
    segment_levels,
    unsure_sign,
)
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder

#: RMD-X position, 0.01 degree.
QUANTUM = float(np.deg2rad(0.01))
SPEEDS = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7)
PLATEAUS = np.array([s * x for x in (*SPEEDS, *SPEEDS[::-1]) for s in (1, -1)])


def ladder(h):
    trajectory = speed_ladder({'a': 0.0}, {'a': 0.1}, SPEEDS, plateau_s=0.8, ramp_s=0.3)
    t = np.arange(0.0, trajectory.duration, h)
    return t, trajectory.spline()(t)[:, 0]


def quantised(q):
    return np.round(q / QUANTUM) * QUANTUM


def used(t, q, settings=None):
    return [s for s in find_segments(t, q, settings or SegmentSettings()) if not s.rejected]


@pytest.mark.parametrize('h', [0.001, 0.002, 0.005])
def test_each_plateau_of_a_quantised_ladder_is_found_once_at_its_speed(h):
    """
    0.01 degree at 200 to 1000 Hz: one count in 5 ms is 0.035 rad/s, more than the slowest plateau.

    The speed is a difference over the window: within one count over its length, and the plateau
    is 0.8 s long, of which at least half must be kept.
    """
    t, q = ladder(h)
    segments = used(t, quantised(q))
    assert len(segments) == len(PLATEAUS)
    for segment, speed in zip(segments, PLATEAUS, strict=True):
        length = segment.end_s - segment.start_s
        assert 0.4 <= length <= 0.8
        assert segment.velocity == pytest.approx(speed, abs=QUANTUM / length + 2e-3 * abs(speed))
        assert t[segment.first] == segment.start_s
        assert t[segment.last] == segment.end_s


@pytest.mark.parametrize('sigma', [0.0, 1e-5, 1e-4])
def test_each_plateau_is_found_once_under_white_noise_of_position(sigma):
    t, q = ladder(0.001)
    segments = used(t, q + sigma * np.random.default_rng(0).normal(size=len(q)))
    assert len(segments) == len(PLATEAUS)
    for segment, speed in zip(segments, PLATEAUS, strict=True):
        # Two noisy ends over the window, at 4 standard deviations.
        slack = 4.0 * np.sqrt(2.0) * sigma / (segment.end_s - segment.start_s)
        assert segment.velocity == pytest.approx(speed, abs=slack + 2e-3 * abs(speed))


@pytest.mark.parametrize('resolution', [quantised, lambda q: q])
def test_a_multisine_has_no_steady_window(resolution):
    t = np.arange(0.0, 30.0, 0.002)
    rng = np.random.default_rng(1)
    phases = rng.uniform(0.0, 2 * np.pi, 5)
    q = 0.1 * np.sin(2 * np.pi * np.outer(t, [0.2, 0.5, 0.9, 1.3, 2.1]) + phases).sum(1)
    assert used(t, resolution(q)) == []


def test_a_slow_sine_is_rejected_because_its_speed_varies():
    """0.02 Hz: steady by its acceleration over seconds, but not one speed."""
    t = np.arange(0.0, 100.0, 0.01)
    segments = find_segments(t, 0.5 * np.sin(2 * np.pi * 0.02 * t), SegmentSettings())
    assert segments
    assert all('speed varies by' in segment.rejected for segment in segments)


def test_rest_is_not_steady_motion():
    t = np.arange(0.0, 5.0, 0.002)
    rng = np.random.default_rng(2)
    for q in (np.zeros(len(t)), quantised(1e-4 * rng.normal(size=len(t)))):
        assert used(t, q) == []


def line(speed=0.3, duration=3.0, h=0.002):
    t = np.arange(0.0, duration, h)
    return t, speed * t


def test_a_nan_ends_a_window():
    t, q = line()
    q[700:710] = np.nan
    first, second = used(t, q)
    assert first.last < 700
    assert second.first >= 710
    assert first.velocity == pytest.approx(0.3, rel=1e-9)
    assert second.velocity == pytest.approx(0.3, rel=1e-9)


def test_a_gap_longer_than_the_window_ends_a_window_and_a_short_one_does_not():
    t, q = line()
    keep = np.ones(len(t), dtype=bool)
    keep[700:740] = False
    assert [s.velocity for s in used(t[keep], q[keep])] == pytest.approx([0.3, 0.3])
    keep[700:740] = True
    keep[700:710] = False
    assert [s.velocity for s in used(t[keep], q[keep])] == pytest.approx([0.3])


def test_time_that_does_not_go_forwards_ends_a_window_without_a_warning():
    t, q = line()
    looped, twice = np.concatenate([t, t]), np.concatenate([q, q])
    segments = used(looped, twice)
    assert [s.velocity for s in segments] == pytest.approx([0.3, 0.3])
    repeated = np.repeat(t, 2)
    find_segments(repeated, np.repeat(q, 2), SegmentSettings())
    assert find_segments(np.zeros(500), np.zeros(500), SegmentSettings()) == []


def test_a_change_of_direction_ends_a_window():
    t = np.arange(0.0, 4.0, 0.002)
    q = 0.3 * np.abs(t - 2.0)
    down, up = used(t, q)
    assert (down.velocity, up.velocity) == pytest.approx((-0.3, 0.3), rel=1e-3)


def test_a_window_that_is_too_short_says_how_long_it_was():
    t = np.arange(0.0, 6.0, 0.002)
    q = 0.05 * 0.5 * np.abs((t % 0.5) - 0.25)
    segments = find_segments(t, q, SegmentSettings())
    assert segments
    for segment in segments:
        length = segment.end_s - segment.start_s
        assert segment.rejected == f'steady for only {length:.2f} s'
        assert length < 0.25


def test_the_beginning_and_the_end_are_trimmed():
    t, q = line(duration=2.0)
    (segment,) = used(t, q, SegmentSettings(trim_s=0.4))
    assert segment.start_s >= 0.4
    assert segment.end_s <= 2.0 - 0.05
    assert used(t, q, SegmentSettings(trim_s=3.0)) == []


def test_recordings_too_short_for_a_window_have_none():
    for count in (0, 1, 2, 50):
        t = np.arange(count) * 0.002
        assert find_segments(t, 0.3 * t, SegmentSettings()) == []
    t, _ = line()
    assert find_segments(t, np.full(len(t), np.nan), SegmentSettings()) == []


def test_the_level_of_a_segment_ignores_errors_and_the_unknown_until_half_is_missing():
    t, q = line()
    (segment,) = used(t, q)
    count = segment.last - segment.first + 1
    y = np.full(len(t), 1.5)
    y[segment.first : segment.first + count // 4] = np.nan
    y[segment.first + count // 4] = 1e6
    assert segment_levels([segment], y).tolist() == [1.5]
    y[segment.first : segment.first + count // 2 + 1] = np.nan
    assert np.isnan(segment_levels([segment], y)).all()
    assert segment_levels([], y).shape == (0,)


def test_the_level_of_a_skewed_ripple_is_its_mean():
    """A sawtooth of mean 0 about 2 whose median is -0.2, as position counts make it."""
    t, q = line(duration=4.0)
    (segment,) = used(t, q)
    ripple = np.where(np.arange(len(t)) % 5 == 0, 0.8, -0.2)
    (level,) = segment_levels([segment], 2.0 + ripple)
    # A window that is no whole number of periods: one sample of 1700.
    assert level == pytest.approx(2.0, abs=2e-3)


@pytest.mark.parametrize(
    ('setting', 'words'),
    [
        ({'window_s': 0.0}, 'window_s is 0.0: it must be positive'),
        ({'minimum_s': 0.0}, 'minimum_s is 0.0: it must be positive'),
        ({'zero_band': -1.0}, 'zero_band is -1.0: it must be 0 or more'),
        ({'trim_s': float('nan')}, 'trim_s is nan'),
    ],
)
def test_settings_that_make_no_sense_are_refused(setting, words):
    with pytest.raises(ConfigurationError, match=words):
        SegmentSettings(**setting)


def test_the_sign_is_unsure_only_about_a_change_of_sign_or_a_stop():
    v = np.concatenate([np.full(20, 0.1), np.full(20, -0.1), np.full(20, 1e-4), np.full(20, 0.2)])
    unsure = np.flatnonzero(unsure_sign(v, 1e-3, 3))
    assert unsure.tolist() == [k for change in (20, 40, 60) for k in range(change - 3, change + 3)]


def test_speed_that_ripples_within_a_window_is_rejected_and_says_by_how_much():
    """
    0.1 rad/s with a sine of 2.5 Hz, of sqrt(2) r of it in speed: its standard deviation is r.

    A difference over 50 ms sees sinc(2.5 * 0.05) = 97 % of it. Each third of the window has the
    same mean speed, and the change within a second is less than 50 % of the speed and resolution.
    """
    t = np.arange(0.0, 4.0, 0.002)
    settings = SegmentSettings(relative_change=10.0)
    for ripple, rejected in ((0.06, False), (0.1, True)):
        w = 2.0 * np.pi * 2.5
        q = 0.1 * (t + np.sqrt(2.0) * ripple / w * np.sin(w * t))
        (segment,) = find_segments(t, q, settings)
        assert segment.velocity == pytest.approx(0.1, rel=0.02)
        assert bool(segment.rejected) == rejected
        if rejected:
            assert segment.rejected == 'speed ripples by 10 %'
