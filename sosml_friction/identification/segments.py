# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Windows of steady motion, and what each says of friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.signal_noise import signal_noise

#: Windows of the second difference, in multiples of ``window_s``: see find_segments.
_WINDOWS = (1, 2, 4)
#: A sample is a gross error if its distance from the segment's median is above this multiple of
#: the 90 % quantile of those distances. Chosen, no measurement.
_GROSS = 5.0
_POSITIVE = ('window_s', 'minimum_s')


@dataclass(frozen=True)
class SegmentSettings:
    """
    Say what counts as steady motion.

    A sample is steady while the speed, as a position difference over ``window_s`` (longer where
    the resolution of position asks for it), changes by less than ``relative_change`` of itself per
    second beyond what resolution and noise of position can make, and is above ``zero_band``
    [rad/s or m/s]. A run of steady samples is cut by ``trim_s`` at its beginning, where the
    observer still settles (``short_trim`` times that where the joint moves in one direction for
    less than ``short_s``: it begins with a reversal, which an observer takes longest to settle
    after), and by ``window_s`` at its end; it is used if ``minimum_s`` is left and
    the speeds of its three thirds differ by less than ``total_change`` of the whole's.

    Friction is curved near standstill, so that its mean is not its value at the mean speed. Two
    more reasons therefore reject a window. Its speed ripples (stick-slip): its standard deviation
    over ``window_s``, resolution subtracted, is more than ``largest_ripple`` of itself. Or it
    creeps, slower than ``slowest_share`` of the fastest window, where friction is not yet full.
    """

    window_s: float = 0.05
    relative_change: float = 0.5
    zero_band: float = 1e-3
    trim_s: float = 0.15
    short_s: float = 1.0
    short_trim: float = 1.5
    minimum_s: float = 0.15
    total_change: float = 0.2
    largest_ripple: float = 0.08
    slowest_share: float = 0.02

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value >= 0.0 or (name in _POSITIVE and value == 0.0):
                raise ConfigurationError(
                    f'segment setting {name} is {value}: it must be '
                    f'{"positive" if name in _POSITIVE else "0 or more"}'
                )


@dataclass(frozen=True)
class Segment:
    """
    Hold one steady window of one joint: samples first .. last inclusive.

    ``velocity`` is (q_last - q_first) / (t_last - t_first) [rad/s or m/s]. ``rejected`` is empty
    for a window that is used, else the reason it is not.
    """

    first: int
    last: int
    start_s: float
    end_s: float
    velocity: float
    rejected: str = ''


def find_segments(time: FloatArray, q: FloatArray, settings: SegmentSettings) -> list[Segment]:
    """
    Return the steady windows of one joint, rejected ones that last ``window_s`` included.

    Acceleration is the second difference of position over a window w. A quantum d of position
    makes it wrong by up to 2 d / w^2, white noise s by sqrt(6) s / w^2 (four times that is
    allowed). Of w = ``window_s`` and its double and fourfold, each sample takes the shortest whose
    error is less than the change looked for.

    :param time: seconds (N,); a step longer than ``window_s``, or not forwards, ends a window.
    :param q: position (N,) [rad or m]; NaN ends a window.
    """
    forwards = np.diff(time)[np.diff(time) > 0.0]
    if len(forwards) == 0:
        return []
    step = float(np.median(forwards))
    half = max(1, round(0.5 * settings.window_s / step))
    if len(time) < 8 * half:
        return []
    quantum, noise = signal_noise(q)
    steady = np.zeros(len(time), dtype=bool)
    way = np.zeros(len(time))
    open_ = np.ones(len(time), dtype=bool)
    for factor in _WINDOWS:
        width = half * factor
        if len(time) < 8 * width:
            break
        speed = centred_difference(time, q, width)
        acceleration = centred_difference(time, speed, width)
        error = (2.0 * quantum + 4.0 * np.sqrt(6.0) * noise) / (2 * width * step) ** 2
        change = settings.relative_change * np.abs(np.nan_to_num(speed))
        # NaN at the ends of a longer window: what a shorter one said stays.
        takes = open_ & np.isfinite(acceleration)
        steady[takes] = (
            (np.abs(speed) > settings.zero_band) & (np.abs(acceleration) < change + error)
        )[takes]
        way[takes] = np.sign(speed[takes])
        open_ &= change < error
    steady[1:] &= (np.diff(time) <= settings.window_s) & (np.diff(time) > 0.0)
    breaks = np.flatnonzero((np.diff(steady.astype(int)) != 0) | (np.diff(way) != 0)) + 1
    segments = []
    speed = centred_difference(time, q, half)
    direction = np.sign(np.where(np.abs(speed) > settings.zero_band, speed, 0.0))
    for run in np.split(np.arange(len(time)), breaks):
        if steady[run[0]] and time[run[-1]] - time[run[0]] >= settings.window_s:
            way_s = _half_cycle(time, direction, int(run[len(run) // 2]))
            longer = settings.short_trim if way_s < settings.short_s else 1.0
            trim = longer * settings.trim_s
            segments.append(
                _trimmed(time, q, run, replace(settings, trim_s=trim), quantum + 4.0 * noise)
            )
    error = np.hypot(quantum / np.sqrt(6.0), np.sqrt(2.0) * noise) / (2 * half * step)
    segments = [_without_ripple(segment, speed, error, settings) for segment in segments]
    return _without_creep(segments, settings)


def _half_cycle(time: FloatArray, direction: FloatArray, k: int) -> float:
    """Return for how long the joint moves in the direction that it has at sample k [s]."""
    other = np.flatnonzero(direction == -direction[k])
    before, after = other[other < k], other[other > k]
    begin = time[before[-1]] if len(before) else -np.inf
    end = time[after[0]] if len(after) else np.inf
    return float(end - begin)


def _trimmed(
    time: FloatArray, q: FloatArray, run: IndexArray, settings: SegmentSettings, resolution: float
) -> Segment:
    # Observers lag, so that they still settle at the beginning of a window. The end is trimmed,
    # too, because the difference over a window sees a change of speed late.
    begin, end = time[run[0]] + settings.trim_s, time[run[-1]] - settings.window_s
    kept = run[(time[run] >= begin) & (time[run] <= end)]
    if len(kept) < 4 or time[kept[-1]] - time[kept[0]] < settings.minimum_s:
        reason = f'steady for only {time[run[-1]] - time[run[0]]:.2f} s'
        return _segment(time, q, run[0], run[-1], reason)
    segment = _segment(time, q, kept[0], kept[-1], '')
    marks = kept[np.linspace(0, len(kept) - 1, 4).astype(int)]
    thirds = np.diff(q[marks]) / np.diff(time[marks])
    slack = 2.0 * resolution / float(np.diff(time[marks]).min())
    varies = float(np.ptp(thirds))
    if varies > settings.total_change * abs(segment.velocity) + slack:
        reason = f'speed varies by {100.0 * varies / abs(segment.velocity):.0f} % within it'
        return replace(segment, rejected=reason)
    return segment


def _without_ripple(
    segment: Segment, speed: FloatArray, error: float, settings: SegmentSettings
) -> Segment:
    inside = speed[segment.first : segment.last + 1]
    if segment.rejected or not np.isfinite(inside).any():
        return segment
    ripple = np.sqrt(max(float(np.nanvar(inside)) - error**2, 0.0)) / abs(segment.velocity)
    if ripple <= settings.largest_ripple:
        return segment
    return replace(segment, rejected=f'speed ripples by {100.0 * ripple:.0f} %')


def _without_creep(segments: list[Segment], settings: SegmentSettings) -> list[Segment]:
    used = [abs(segment.velocity) for segment in segments if not segment.rejected]
    slowest = settings.slowest_share * max(used, default=0.0)
    reason = f'slower than {100.0 * settings.slowest_share:.0f} % of the fastest window'
    return [
        replace(segment, rejected=reason)
        if not segment.rejected and abs(segment.velocity) < slowest
        else segment
        for segment in segments
    ]


def _segment(time: FloatArray, q: FloatArray, first: int, last: int, rejected: str) -> Segment:
    span = time[last] - time[first]
    velocity = float((q[last] - q[first]) / span) if span > 0.0 else np.nan
    return Segment(
        int(first), int(last), float(time[first]), float(time[last]), velocity, rejected
    )


def centred_difference(time: FloatArray, x: FloatArray, half: int) -> FloatArray:
    """
    Return (x_{k+half} - x_{k-half}) / (t_{k+half} - t_{k-half}), in the shape of x.

    NaN at the ends, where time does not go forwards, and across a hole.

    :param time: (N,) [s].
    :param x: (N,), or a column for each joint (N, n).
    """
    result = np.full(x.shape, np.nan)
    span = time[2 * half :] - time[: -2 * half]
    usual = float(np.median(span)) if len(span) else 0.0
    forwards = (span > 0.0) & (span < 2.0 * usual)
    # Time along the rows, however many columns there are.
    known = span[forwards].reshape(-1, *[1] * (x.ndim - 1))
    result[half:-half][forwards] = (x[2 * half :] - x[: -2 * half])[forwards] / known
    return result


def unsure_sign(v: FloatArray, zero_band: float, half: int) -> BoolArray:
    """
    Return where the sign of velocity is not known, (N,): within ``half`` samples of another sign.

    The velocity is a mean over a window. Near a start, stop or reversal it does not say on which
    side of it a sample is. Standstill, |v| <= ``zero_band``, is a sign of its own.
    """
    way = np.where(np.abs(v) > zero_band, np.sign(v), 0.0)
    highest, lowest = (f(way, 2 * half + 1) for f in (maximum_filter1d, minimum_filter1d))
    return np.array(highest != lowest)


def segment_levels(segments: Sequence[Segment], tau_f: FloatArray) -> FloatArray:
    """
    Return the level of an observer's output in each segment, (K,) [Nm or N].

    The mean without gross errors (samples more than five times the 90 % quantile away from the
    median). The error by a quantised position has a mean of about zero over steady motion, but is
    not symmetric: the median is off by 1 % of the friction on the emulated RMD-X. NaN where less
    than half of a segment's samples have an estimate.
    """
    levels = np.full(len(segments), np.nan)
    for k, segment in enumerate(segments):
        inside = tau_f[segment.first : segment.last + 1]
        known = inside[np.isfinite(inside)]
        if 2 * len(known) >= len(inside):
            distance = np.abs(known - np.median(known))
            levels[k] = np.mean(known[distance <= _GROSS * np.quantile(distance, 0.9)])
    return levels
