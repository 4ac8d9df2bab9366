# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Ripple of the speed on plateaus, told from the encoder's noise, and what it does to a fit."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.polynomial import Legendre
from scipy.signal.windows import dpss
from scipy.stats import chi2
from scipy.stats import f as f_distribution

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.data_finding import NOTE, WARNING, DataFinding
from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.segments import Segment, SegmentSettings, find_segments
from sosml_friction.model.laws import FrictionLaw, make_friction_law, unit_of
from sosml_friction.observers.signal_noise import signal_noise

#: Thomson's multitaper: half of the bandwidth in units of 1 / length, and the tapers whose leakage
#: is small at it.
_HALF_BAND, _TAPERS = 2.5, 4
#: Over what the position is smoothed to find plateaus that slower ripple hides [s].
_WINDOWS_S = (0.2, 0.8)
#: An encoder's noise is taken to be white within this factor: less than that is no ripple.
_WHITE = 2.0
#: Of the band of the ripple more than this share has to be seen on a plateau.
_FEWEST = 0.5
#: Probability of an error of the first kind, of a joint.
_CHANCE = 0.01
#: Degree of what says at which speeds a plateau was: it follows a loop that settles. Chosen, no
#: measurement: 5 and 9 give the same.
_DEGREE = 9
#: Step of the differences that make the gradient of the law, as a share of a parameter.
_STEP = 1e-5


@dataclass(frozen=True)
class PlateauRipple:
    """
    Hold the ripple of one joint on one plateau, from ``start_s`` to ``end_s`` at ``velocity``.

    ``ripple`` is the root mean square of the speed about its trend, the encoder's noise taken off,
    ``ripple_error`` its standard error, ``position`` that of the position, ``noise`` what the
    encoder's noise makes of the speed in the same band of frequencies. ``p_value``: how often that
    noise alone would look like it. ``kind``: empty where it is not seen (above 1 % of a joint);
    ``stick-slip`` where a sine of that size stops the joint; ``limit cycle`` where half of it is
    in one line, at ``frequency`` [Hz] (as of cogging, whose frequency follows the speed); else
    ``ripple``. ``bias`` is the mean of the fitted law
    over the ripple minus the law at the mean speed [Nm or N].
    """

    start_s: float
    end_s: float
    velocity: float
    ripple: float
    ripple_error: float
    position: float
    noise: float
    p_value: float
    frequency: float
    kind: str = ''
    bias: float = math.nan


def measure_ripple(time: FloatArray, q: FloatArray) -> tuple[PlateauRipple, ...]:
    """
    Return the ripple on each plateau of one joint.

    The spectrum of the position about a cubic (Thomson's multitaper) holds ripple; the encoder's
    noise, which is white, of the median over the upper half of the frequencies or what rounding
    makes, if that is more; and lines at multiples of speed over resolution, which rounding makes
    as well and which are left out. Ripple is where the mean over the plateaus is above twice the
    noise and above what noise reaches by chance (chi2), and in the strongest line of a plateau if
    it is above chance (F) and larger than one of rounding. What the spectrum has there beyond the
    noise, times (2 pi f)^2, is that of the speed.
    """
    quantum = signal_noise(q)[0]
    spectra = [_Spectrum(time, q, own, quantum) for own in _plateaus(time, q)]
    spectra = [own for own in spectra if own.usable]
    if not spectra:
        return ()
    grid = min((own.f for own in spectra), key=lambda f: float(f[1]))
    known = np.array([np.interp(grid, s.f, s.seen.astype(float)) > 0.5 for s in spectra])
    ratios = np.array([np.interp(grid, s.f, s.power / s.noise) for s in spectra])
    count = known.sum(axis=0)
    mean = np.sum(ratios * known, axis=0) / np.maximum(count, 1)
    dof = 2 * _TAPERS * np.maximum(count, 1)
    chance = chi2.isf(_CHANCE / len(grid), dof) / dof
    shared = (mean > np.maximum(chance, _WHITE)) & (count > 0)
    shape = np.where(shared, mean - 1.0, 0.0)
    return tuple(own.ripple(np.interp(own.f, grid, shape), len(spectra)) for own in spectra)


def _plateaus(time: FloatArray, q: FloatArray) -> list[Segment]:
    """Return the plateaus by the least smoothing that shows them, in order of time."""
    found: list[Segment] = []
    if len(time) < 8 * _TAPERS:
        return found
    step = float(np.median(np.diff(time)))
    for window in (0.0, *_WINDOWS_S):
        # A mean over a Hann window of twice that length; NaN at the ends.
        half = round(window / step)
        smooth = np.full(len(q), np.nan)
        if len(q) <= 2 * half + 1:
            break
        kernel = np.hanning(2 * half + 3)[1:-1]
        smooth[half : len(q) - half] = np.convolve(q, kernel / kernel.sum(), 'valid')
        settings = SegmentSettings(
            trim_s=max(window, SegmentSettings.trim_s), largest_ripple=math.inf
        )
        found += [
            own
            for own in find_segments(time, smooth, settings)
            if not own.rejected
            and own.last - own.first > 8 * _TAPERS
            and own.end_s - own.start_s > _HALF_BAND * window
            and all(own.first > k.last or own.last < k.first for k in found)
        ]
    return sorted(found, key=lambda own: own.first)


@lru_cache(maxsize=32)
def _tapers(count: int) -> FloatArray:
    """Return the tapers of a plateau of so many samples; equal plateaus have the same ones."""
    return np.asarray(dpss(count, _HALF_BAND, _TAPERS))


class _Spectrum:
    """The spectrum of the position on one plateau: ``power`` at ``f``, white ``noise`` of it."""

    def __init__(self, time: FloatArray, q: FloatArray, at: Segment, quantum: float) -> None:
        self.at, self.quantum = at, quantum
        t, x = time[at.first : at.last + 1], q[at.first : at.last + 1]
        step = float(np.median(np.diff(t)))
        place = np.round((t - t[0]) / step).astype(int)
        n = int(place[-1]) + 1
        centred = 2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0
        trend = Legendre.fit(centred, x, 3, domain=[-1.0, 1.0])
        # A sample that is missing is 0: so white noise stays white.
        rest = np.zeros(n)
        rest[place] = x - trend(centred)
        tapers = _tapers(n)
        self.f = np.fft.rfftfreq(n, step)
        self.power = 2.0 * step * np.mean(np.abs(np.fft.rfft(tapers * rest)) ** 2, axis=0)
        self.power *= n / len(t)
        # By how much a sum over frequencies varies more than one of independent ones.
        self.overlap = n * float(np.sum(np.mean(tapers**2, axis=0) ** 2))
        self.half = _HALF_BAND * float(self.f[1])
        upper = self.f > 0.5 * self.f[-1]
        dof = 2 * _TAPERS
        self.noise = float(np.median(self.power[upper])) * dof / chi2.median(dof)
        # Rounding makes an error of quantum^2 / 12 somewhere.
        self.noise = max(self.noise, quantum**2 / 12.0 / float(self.f[-1]))
        # A median is as good as 2 / pi of the numbers.
        self.noise_dof = 2.0 / math.pi * 2.0 * np.sum(upper) / self.overlap
        self.seen = self.f > self.half + 1.5 * self.f[1]
        if self.noise > 0.0:
            path = Legendre.fit(centred, x, _DEGREE, domain=[-1.0, 1.0])
            self._leave_out_tones(path(2.0 * np.arange(n) / (n - 1) - 1.0), step)
        self.usable = self.noise > 0.0 and bool(np.any(self.seen))

    def _leave_out_tones(self, path: FloatArray, step: float) -> None:
        """
        Leave out what rounding makes of the motion, wherever it is above the noise.

        The error of rounding x to multiples of a quantum is a saw-tooth of it, the sum over k of
        quantum / (pi k) sin(2 pi k x / quantum) but for signs. So line k has the power
        (quantum / pi k)^2 / 2, blurred by the encoder's other noise s to exp(-(2 pi k s /
        quantum)^2) of it, at the frequency k v / quantum, folded at half of the sampling rate. As
        the speed v is hardly steady, it is smeared, the more the higher k is: its spectrum is that
        of exp(2 pi i k x / quantum) over a smooth path. Ripple makes bands beside a line: from
        half of the first on nothing is told.

        :param path: x (N,), a sample each ``step`` [s].
        """
        top, quantum, tapers = float(self.f[-1]), self.quantum, _tapers(len(path))
        other = max(self.noise * top - quantum**2 / 12.0, 0.0)
        for k in range(1, len(self.f)):
            line = quantum / (math.pi * k)
            blurred = line**2 / 2.0 * math.exp(-4.0 * other / line**2)
            if blurred <= 2.0 * self.half * self.noise:
                return
            phase = 2.0 * math.pi * k / quantum * (path - path[0])
            sine, cosine = (np.fft.rfft(tapers * x) for x in (np.sin(phase), np.cos(phase)))
            # Of a phase that is not known: the mean of both.
            power = step * np.mean(np.abs(sine) ** 2 + np.abs(cosine) ** 2, axis=0)
            self.seen &= 2.0 * blurred * power <= self.noise
            if k == 1:
                alias = abs((abs(self.at.velocity) / quantum + top) % (2.0 * top) - top)
                self.seen &= self.f < 0.5 * alias

    def ripple(self, shape: FloatArray, plateaus: int) -> PlateauRipple:
        """
        Return the ripple in the band that plateaus share, and in this one's strongest line.

        :param shape: what that band has beyond the noise, in units of it, at ``f``; 0 elsewhere.
        """
        at, ratio, df = self.at, self.power / self.noise, float(self.f[1])
        chance = f_distribution.isf(
            _CHANCE / (plateaus * len(self.f)), 2 * _TAPERS, self.noise_dof
        )
        top = int(np.argmax(ratio * self.seen))
        own = np.abs(self.f - self.f[top]) <= self.half
        line = float(np.sum(self.power[own])) * df
        # Rounding alone makes a line of at most quantum^2 / (2 pi^2).
        own &= bool(
            ratio[top] > max(_WHITE, chance) and line > 0.5 * (self.quantum / math.pi) ** 2
        )
        inside = ((shape > 0.0) | own) & self.seen
        weights = (2.0 * np.pi * self.f) ** 2
        # The share of the band that is not left out here.
        share = float(np.sum((weights * shape)[inside]) / max(np.sum(weights * shape), 1e-300))
        frame = (at.start_s, at.end_s, at.velocity)
        if not (own.any() or share > _FEWEST):
            return PlateauRipple(*frame, math.nan, math.nan, math.nan, math.nan, 1.0, math.nan)
        weight, power = weights[inside], self.power[inside]
        scale = 1.0 if own.any() else 1.0 / share
        excess = weight * (power - self.noise) * df
        noise = float(np.sum(weight)) * self.noise * df
        dof = 2.0 * np.sum(weight) ** 2 / (self.overlap * np.sum(weight**2))
        p_value = float(f_distribution.sf(1.0 + np.sum(excess) / noise, dof, self.noise_dof))
        variance = self.overlap * np.sum((weight * power * df) ** 2)
        variance += 2.0 * noise**2 / self.noise_dof
        size = math.sqrt(scale * max(float(np.sum(excess)), 0.0))
        near = np.abs(self.f - self.f[inside][np.argmax(excess)]) <= self.half
        above = np.maximum(self.power - self.noise, 0.0) * near * inside
        peak = float(np.sum(above * self.f) / max(np.sum(above), 1e-300))
        kind = ''
        if p_value < _CHANCE / plateaus:
            kind = 'limit cycle' if self._is_line(peak) else 'ripple'
            kind = 'stick-slip' if math.sqrt(2.0) * size >= abs(at.velocity) else kind
        return PlateauRipple(
            *frame,
            size,
            scale * math.sqrt(variance) / (2.0 * size) if size > 0.0 else math.nan,
            math.sqrt(scale * max(float(np.sum(power - self.noise)) * df, 0.0)),
            math.sqrt(noise),
            p_value,
            peak,
            kind,
        )

    def _is_line(self, peak: float) -> bool:
        """Tell whether half of the ripple up to twice its frequency is in a line that narrow."""
        around = self.seen & (self.f <= 2.0 * peak)
        excess = (2.0 * np.pi * self.f) ** 2 * (self.power - self.noise) * around
        line = np.abs(self.f - peak) <= self.half
        narrow = np.sum(around) > 2 * np.sum(line)
        return bool(narrow and 2.0 * np.sum(excess[line]) > np.sum(excess))


def joint_ripple(
    joint: str,
    effort_unit: str,
    time: FloatArray,
    q: FloatArray,
    fit: LawFit | None,
    smoothed: bool = False,
) -> tuple[tuple[PlateauRipple, ...], DataFinding | None]:
    """
    Return the ripple of a joint with its bias, and what is said of it; None where none is seen.

    A warning where the joint stops, or where S or v_s is moved by more than its standard error:
    the mean of the law over the ripple is not the law at the mean speed; else a note.

    :param smoothed: whether the fit knows velocities that show the ripple.
    """
    found = measure_ripple(time, q)
    law = None if fit is None else fitted_law(fit)
    if law is not None:
        v, r = np.array([(own.velocity, own.ripple) for own in found]).reshape(-1, 2).T
        # s^2 f'' / 2, as a difference: the ripple may be as large as the bend.
        bias = 0.5 * (law.torque(v + r) + law.torque(v - r)) - law.torque(v)
        found = tuple(replace(own, bias=float(b)) for own, b in zip(found, bias, strict=True))
    seen = [own for own in found if own.kind]
    if not seen:
        return found, None
    worst = max(seen, key=lambda own: own.ripple / abs(own.velocity))
    speed = unit_of('velocity', effort_unit)
    what = worst.kind
    if what == 'limit cycle':
        period = f'{abs(worst.velocity) / worst.frequency:.2g} {speed.removesuffix("/s")}'
        what += f' of the loop, or a force that repeats every {period}'
    text = (
        f'joint {joint} does not move evenly on {len(seen)} of {len(found)} plateaus: at '
        f'{abs(worst.velocity):.2g} {speed} its speed ripples by {worst.ripple:.2g} {speed} rms '
        f'({100.0 * worst.ripple / abs(worst.velocity):.0f} % of it, {what}, '
        f'{worst.frequency:.3g} Hz; noise of the encoder there {worst.noise:.2g})'
    )
    spread = None if fit is None else band(fit, np.array([own.velocity for own in found]))
    # Half of a 95 % band is about two standard errors.
    biased = spread is not None and any(
        own.kind and abs(own.bias) > 0.5 * width for own, width in zip(found, spread, strict=True)
    )
    stops = any(own.kind == 'stick-slip' for own in seen)
    level = WARNING if stops else NOTE
    if fit is None or law is None or not biased:
        return found, DataFinding('ripple', joint, level, text)
    shift = shift_by_ripple(found, law)
    # An error that is not known is no excuse.
    small = bool(shift) and all(
        abs(own) <= fit.parameters[name].std_error for name, own in shift.items()
    )
    moved = ' and '.join(
        f'{name} by about {own:+.2g} {unit_of(name, effort_unit)}' for name, own in shift.items()
    )
    text += (
        f'. The mean of friction over that is up to {max(abs(own.bias) for own in seen):.2g} '
        f'{effort_unit} off friction at the mean speed, more than the standard error there'
        + (f'; a fit by mean speeds moves {moved}' if moved else '')
    )
    if smoothed:
        text += '; this fit looks friction up at velocities smoothed by the torque, which show it'
    elif stops or not small:
        text += ': mend the loop (a faster filter of its velocity, other gains) and record anew'
        level = WARNING
    return found, DataFinding('ripple', joint, level, text)


def shift_by_ripple(
    found: Sequence[PlateauRipple],
    law: FrictionLaw,
    shown: Callable[[float], float] = lambda frequency: 0.0,
) -> dict[str, float]:
    """
    Return by how much the biases move S and v_s in a fit [Nm or N, rad/s or m/s].

    By least squares over the plateaus, C and B being known from faster ones; empty where the law
    has no Stribeck term. A plateau on which no ripple is seen has no bias.

    A bias is as the square of what the fit's velocities do not show: s^2 f'' / 2.

    :param found: with their bias.
    :param shown: which share of a ripple of a frequency [Hz] the velocities of the fit show; 0 in
        a fit by mean speeds.
    """
    names = [name for name in ('stribeck', 'stribeck_velocity') if name in law.parameters]
    v = np.array([own.velocity for own in found])
    hidden = (own.bias * (1.0 - shown(own.frequency) ** 2) if own.kind else 0.0 for own in found)
    bias = np.array(list(hidden))
    columns = []
    for name in names:
        step = _STEP * (abs(law.parameters[name]) or 1.0)
        changed = {**law.parameters, name: law.parameters[name] + step}
        other = make_friction_law(law.identifier, changed, law.smoothing_velocity)
        columns.append((other.torque(v) - law.torque(v)) / step)
    if not names:
        return {}
    shift = np.linalg.lstsq(np.column_stack(columns), bias, rcond=None)[0]
    return dict(zip(names, shift.tolist(), strict=True))
