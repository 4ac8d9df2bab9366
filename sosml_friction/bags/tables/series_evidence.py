# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What series of numbers say of themselves: which is time, which is the slope of which."""

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.sampling import RATES, repeated_rows
from sosml_friction.bags.tables.header_words import read_header
from sosml_friction.bags.tables.units import TIME_UNITS, UNITS
from sosml_friction.bags.wrap import wrap_period

#: Stamps that rise by less than 1 are ms where they would be hours in s, else they may be of 1 to
#: 10 Hz in s. Chosen, no measurement.
_HOURS = 3600.0
#: Units of time that a step tells: those whose decades are apart. Spreadsheets count days.
_TOLD = ('s', 'ms', 'us', 'ns', 'd')
#: Least cosine between the steps of one series and the integral of another that is its slope.
SLOPE = 0.95
#: Cosine of a slope that is one in whatever units, and how near 1 its factor is in the right ones.
SURE, _SAME = 0.999, 0.01
#: Time over which steps are taken, in samples: longer than the noise of an encoder.
_SAMPLES = 8
#: How much of the steps of time may be 0: a logger that writes a sample twice.
_REPEATED = 0.05
#: Share of steps of 1 that makes a count: it may begin anew, or lack a sample. Chosen, no
#: measurement.
_COUNTED = 0.9
#: What nanoseconds beside whole seconds are called.
FINE = re.compile('n(ano_?)?sec(ond)?s?$|nanos$')


class Time(NamedTuple):
    """
    Name the series that is time, its unit, and why; '' where none is, or no unit is told.

    ``nanoseconds``: the series that is added to one of whole seconds, or ''.
    """

    name: str
    unit: str
    reason: str
    nanoseconds: str = ''


class Slope(NamedTuple):
    """
    Say that ``velocity`` is the slope of ``position`` by time.

    ``cosine`` of the steps of one with the integral of the other over the same time; ``factor``:
    slope of position [its unit/s] per unit of velocity. ``told``: the cosine about their means, if
    that is less: what hardly changes is the slope of any clock, and of a shaft at one speed.
    """

    position: str
    velocity: str
    cosine: float
    factor: float
    told: float


def find_time(series: Mapping[str, NDArray[Any]], stated: str = '') -> Time:
    """Return which series is time (``stated``, if known), and its unit by name, else by rate."""
    # What logs each sample twice has a time all the same.
    fresh = ~repeated_rows(series.values()) if series else slice(None)
    series = {name: values[fresh] for name, values in series.items()}
    parts = _seconds_and_nanoseconds(series, stated)
    if parts is not None:
        return parts
    rising = {}
    unfit = []
    for name, values in series.items() if not stated else ():
        steps = np.diff(values)
        if read_header(name).quantity in UNITS and 'time' not in name.lower():
            # A shaft that turns one way grows all the time too.
            continue
        grows = len(steps) > 0 and np.isfinite(values).all() and (steps >= 0).all()
        if grows and (steps > 0).mean() >= 1.0 - _REPEATED:
            rising[name] = float(np.std(steps) / np.mean(steps))
        elif grows and read_header(name).quantity == 'time':
            unfit.append(f': {name} {_repeats(steps)}')
        elif not np.isfinite(values).all() and read_header(name).quantity == 'time':
            unfit.append(f': {name} has no number at index {int(np.argmin(np.isfinite(values)))}')
        elif (steps < 0).any() and read_header(name).quantity == 'time':
            unfit.append(f': {name} goes back at index {int(np.argmax(steps < 0)) + 1}')
    by_name = [name for name in rising if read_header(name).quantity == 'time']
    if stated:
        chosen, why = stated, 'stated'
    elif not rising:
        return Time('', '', f'no column grows all the time{"".join(unfit)}')
    elif len(by_name) == 1:
        chosen, why = by_name[0], 'its name says so, and it grows all the time'
    elif len(rising) == 1:
        chosen, why = next(iter(rising)), 'the only column that grows all the time'
    else:
        # A count of the samples is more even than any clock.
        clocks = [name for name in rising if not counts_samples(series[name])]
        among = by_name or clocks or list(rising)
        chosen = min(among, key=lambda name: rising[name])
        others = ', '.join(name for name in among if name != chosen)
        why = f'it grows all the time, in more even steps than {others} does'
    steps = np.diff(series[chosen])
    if not len(steps):
        return Time(chosen, '', why)
    step = float(np.median(steps))
    word = read_header(chosen)
    if word.quantity == 'time' and word.unit:
        return Time(chosen, word.unit, f'{why}; its name has the unit')
    if word.strange:
        return Time(chosen, '', f'{why}; {word.objection}')
    if word.quantity != 'time' and counts_samples(series[chosen]):
        why += '; it counts up by 1: ms at 1 kHz, or a count of the samples'
        return Time(chosen, '', why)
    if step == 0.0:
        return Time(chosen, '', f'{why}; it {_repeats(steps)}')
    for unit in _TOLD:
        ns = TIME_UNITS[unit]
        rate = 1e9 / (step * ns) if step > 0.0 else 0.0
        may_be_s = unit == 'ms' and step < 1.0 and float(np.ptp(series[chosen])) < _HOURS
        if may_be_s and rate < RATES[1]:
            return Time(chosen, '', f'{why}; its step of {step:.4g} may be one in s or in ms')
        if RATES[0] <= rate < RATES[1] and (unit == 'd' or _fits(series[chosen], ns)):
            return Time(chosen, unit, f'{why}; in {unit} its median step makes {rate:.4g} Hz')
    return Time(chosen, '', f'{why}; its median step of {step:.4g} fits no unit')


def _repeats(steps: NDArray[Any]) -> str:
    """Return what is wrong with stamps most of which are those before them, for a sentence."""
    share = 100.0 * float((steps == 0).mean())
    return f'repeats {share:.3g} % of its stamps, too coarse for a time'


def _fits(values: NDArray[Any], ns: int) -> bool:
    """Tell whether stamps in a unit can be those of a bag."""
    return float(np.abs(values).max()) * ns < 2**62


def counts_samples(values: NDArray[Any]) -> bool:
    """Tell whether a series grows by 1 from sample to sample, nearly all the time."""
    return len(values) > 1 and bool((np.diff(values) == 1).mean() > _COUNTED)


def _seconds_and_nanoseconds(series: Mapping[str, NDArray[Any]], stated: str) -> Time | None:
    """Return the time that two series are together, as stamps of ROS are; None if none are."""
    # TimeInNanoSec is time_in_nano_sec.
    plain = {name: re.sub('(?<=[a-z])(?=[A-Z])', '_', name).lower() for name in series}
    fine = [name for name, text in plain.items() if FINE.search(text)]
    whole = [name for name, text in plain.items() if re.search('(?<![a-z])sec(ond)?s?$', text)]
    whole = [name for name in whole if name not in fine]
    if not fine and all(name.isdecimal() for name in series):
        # Without names, as ros2 topic echo --csv writes them, they stand side by side.
        pairs = zip(series, list(series)[1:], strict=False)
        beside = [(a, b) for a, b in pairs if _goes_around(series[a], series[b])]
        whole, fine = [a for a, _ in beside], [b for _, b in beside]
    whole = [stated] if stated in whole else [] if stated else whole
    if len(fine) != 1 or len(whole) != 1:
        return None
    both = np.array([series[whole[0]], series[fine[0]]])
    if both.dtype.kind != 'i' or not ((both[1] >= 0) & (both[1] < 10**9)).all():
        return None
    steps = np.diff((both[0] - both[0, 0]) * 10**9 + both[1])
    if (steps < 0).any() or (steps == 0).mean() > _REPEATED:
        return None
    why = f'whole seconds, with {fine[0]} beside them'
    return Time(whole[0], 's', why, fine[0])


def _goes_around(whole: NDArray[Any], fine: NDArray[Any]) -> bool:
    """Tell whether a series grows by 1 where another falls by about 1e9, and rests elsewhere."""
    if whole.dtype.kind != 'i' or fine.dtype.kind != 'i':
        return False
    falls = np.diff(fine) < 0
    return bool(falls.any() and (np.diff(whole) == falls).all() and np.ptp(fine) > 5 * 10**8)


def seconds(series: Mapping[str, NDArray[Any]], time: Time) -> FloatArray:
    """Return a time whose unit is known, from its first sample on [s], (N,)."""
    own = series[time.name]
    from_start: FloatArray = (own - own[0]).astype(np.float64) * (TIME_UNITS[time.unit] * 1e-9)
    if time.nanoseconds:
        from_start = from_start + 1e-9 * (series[time.nanoseconds] - series[time.nanoseconds][0])
    return from_start


def moving(t: FloatArray, series: Mapping[str, NDArray[Any]]) -> dict[str, FloatArray]:
    """Return the series that change, unwrapped where a wrap is recognised, gaps filled in."""
    found = {}
    for name, raw in series.items():
        values = raw.astype(np.float64)
        known = np.isfinite(values)
        if known.sum() < 2 * _SAMPLES or np.ptp(values[known]) == 0.0:
            continue
        values = np.interp(np.arange(len(values)), np.flatnonzero(known), values[known])
        period = wrap_period(t, values)
        found[name] = values if period is None else np.unwrap(values, period=period)
    return found


def slopes(t: FloatArray, series: Mapping[str, FloatArray]) -> list[Slope]:
    """Return, surest first, each pair (N,) of which one is the slope of the other by t [s]."""
    names = list(series)
    if len(names) < 2 or len(t) < 3 * _SAMPLES:
        return []
    table = np.column_stack([series[name] for name in names])
    middle = 0.5 * (table[1:] + table[:-1]) * np.diff(t)[:, None]
    integral = np.vstack([np.zeros(len(names)), np.cumsum(middle, axis=0)])
    width = min(_SAMPLES, len(t) // 3)
    step = table[width:] - table[:-width]
    added = integral[width:] - integral[:-width]
    cosine, varied = (
        _cosines(step - m * np.mean(step, axis=0), added - m * np.mean(added, axis=0))
        for m in (0.0, 1.0)
    )
    found = []
    for i, j in np.argwhere(np.abs(cosine) >= SLOPE).tolist():
        # The faster half, by the median: a velocity may be clipped, and is noisy at rest.
        size = np.abs(added[:, j])
        fast = size >= np.median(size[size > 0.0])
        ratio = float(np.median(step[fast, i] / added[fast, j]))
        if i != j:
            told = min(cosine[i, j], varied[i, j], key=abs)
            found.append(Slope(names[i], names[j], float(cosine[i, j]), ratio, float(told)))
    return sorted(found, key=lambda slope: -abs(slope.cosine))


def _cosines(step: FloatArray, added: FloatArray) -> FloatArray:
    """Return the cosine of each column of one table with each of another, 0 where one is 0."""
    sizes = (np.sqrt(np.sum(x**2, axis=0)) for x in (step, added))
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.nan_to_num((step.T @ added) / np.outer(*sizes))


def step_by_slopes(stamps: FloatArray, series: Mapping[str, FloatArray]) -> float:
    """Return the power of ten of s in which most slopes have the unit of position, 0 if none."""
    factors = np.array([s.factor for s in slopes(stamps, series) if s.cosine > SURE])
    step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    # A velocity per sample is a slope in a unit that makes 1 Hz.
    votes = {
        size: int((np.abs(factors / size - 1.0) < _SAME).sum())
        for size in (10.0**-k for k in range(10))
        if RATES[0] * step * size <= 1.0 < RATES[1] * step * size
    }
    best = max(votes, key=lambda size: votes[size], default=0.0)
    return best if best and votes[best] and 2 * votes[best] >= len(factors) else 0.0


def lead(t: FloatArray, first: FloatArray, second: FloatArray) -> float:
    """Return by how much ``first`` comes before ``second``, which are nearly the same [s]."""
    rate = np.gradient(second, t)
    apart = (first - np.mean(first)) - (second - np.mean(second))
    return float(apart @ rate / (rate @ rate))


def roughness(values: FloatArray) -> float:
    """Return the step from sample to sample as a share of the whole spread."""
    spread = float(np.std(values))
    return float(np.std(np.diff(values))) / spread if spread > 0.0 else math.inf


def noise(values: FloatArray) -> float:
    """Return what is not smooth from sample to sample as a share of the spread; jumps are few."""
    spread = float(np.std(values))
    return float(np.median(np.abs(np.diff(values, n=3)))) / spread if spread > 0.0 else 0.0


def explained(t: FloatArray, effort: FloatArray, position: FloatArray, angle: float) -> float:
    """
    Return the share of a series' variance that the motion of a joint explains beyond its place.

    It is what direction, speed and acceleration explain beside a function of position, which
    anything slow may look like.

    :param angle: of a unit of position [rad].
    """
    spread = float(np.sum((effort - np.mean(effort)) ** 2))
    if spread == 0.0:
        return 0.0
    width = min(_SAMPLES, len(t) // 3)
    flat = np.ones(width) / width
    smooth = np.convolve(np.pad(position, width, mode='edge'), flat, mode='same')[width:-width]
    v = np.gradient(smooth, t)
    place = [np.ones_like(t), position, np.sin(angle * position), np.cos(angle * position)]
    left = []
    for columns in (place, [*place, np.sign(v), v, np.gradient(v, t)]):
        design = np.column_stack([c / (np.abs(c).max() or 1.0) for c in columns])
        rest = effort - design @ np.linalg.lstsq(design, effort, rcond=None)[0]
        left.append(float(rest @ rest))
    return (left[0] - left[1]) / spread
