# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of a gear that gives: the body is not where its motor is."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.moved_body import mass_and_slope
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Gear, SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term

#: Share of critical damping in the gear.
_DAMPING = 0.05
#: Share of the band above which a resonance is stiff: where noise of position n, whitened, is as
#: strong at all frequencies f, its product with its own column is the integral of
#: f^2 / (f^2 - f_r^2) up to the band's f_b, negative for f_r > f_b / 1.2, where
#: ln((1 + x) / (x - 1)) = 2 x has its solution x = f_b / f_r.
_STIFF = 1.0 / 1.2
#: Steps of the integration in one cycle of the resonance.
_STEPS = 25.0
#: A body of less than this share of its rotor is rounding of their sum.
_LEAST_BODY = 1e-9


class TransmissionTerm(Term):
    """
    State a gear that gives: its column is simulated, so that its amplitude is 1 where it is right.

    The motor angle is measured. The body follows it through the gear, driven by the effort that
    the nominal body would need to follow exactly.
    """

    amplitudes: ClassVar[Mapping[str, str]] = {'amplitude': '1'}
    # The body behind it may be off by a factor of two, and the column is not exact. Past its
    # resonance a softer gear makes the opposite effort, which resembles a stiffer one's.
    amplitude_range: ClassVar[tuple[float, float]] = (0.4, 1.8)
    at_reversals: ClassVar[bool] = True
    axis = 'effort'
    # Load and inertia in the equation are the nominal body's.
    with_body = ('stiffness',)
    # The blind plant's stiffness is within two standard errors in 5 of 7, its gap in none of 3.
    size_known = False

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether there is a body for a gear to move beside the rotor."""
        robot = signals.robot
        own = robot.inertia(np.median(signals.q, axis=0))[joint, joint]
        return bool(own > (1.0 + _LEAST_BODY) * robot.armature[joint])

    @abstractmethod
    def gear(self, joint: int, inner: Inner) -> Gear:
        """Return the gear."""

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the effort of the deflection, (N, n, 1)."""
        gear = self.gear(joint, inner)
        return transmission_column(signals, joint, gear.stiffness, gear.gap)

    def is_stiff(self, signals: Recording, joint: int, inner: Inner) -> bool:
        """Tell whether noise of position looks like less than nothing of this gear."""
        stiffness = self.gear(joint, inner).stiffness
        resonance = np.sqrt(stiffness / _inertia_behind(signals, joint)) / (2.0 * np.pi)
        return bool(resonance > _STIFF * signals.band.cutoff)

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """Return the gear; one that gives ``amplitude`` times as much is softer and wider."""
        own, size = self.gear(joint, inner), float(amplitude[0])
        return SimulatedGear(Gear(joint, own.stiffness / size, own.gap * size, own.damping))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible: the simulation is right at 1."""
        low, high = self.amplitude_range
        if not low < fit.amplitude[0] < high:
            return f'its effort would have to be {fit.amplitude[0]:.2f} times what it makes'
        return ''


class SimulatedGear(SimulatedTerm):
    """A gear with its numbers."""

    def __init__(self, gear: Gear) -> None:
        self._gear = gear

    def gear(self) -> Gear:
        """Return the gear."""
        return self._gear


def gear_of(joint: int, stiffness: float, gap: float) -> Gear:
    """Return a gear with the damping that all have."""
    return Gear(joint, stiffness, gap, _DAMPING)


@compiled
def deflection(
    load: FloatArray, inertia: FloatArray, stiffness: float, gap: float, step: float, substeps: int
) -> tuple[FloatArray, FloatArray]:
    """
    Return d = q_body - q_motor and d'', (N,), of a body driven through a spring with a gap.

        M d'' + c d' + K dead(d, gap) = -load,  c = 2 zeta sqrt(K M),

    load the torque that the body would need to follow its motor exactly; semi-implicit steps.

    :param load: (N,) [Nm or N]; inertia M (N,) [kg m2 or kg]; stiffness K; gap [rad or m].
    """
    d_out, a_out = np.empty(len(load)), np.empty(len(load))
    side = -1.0 if load[0] > 0.0 else 1.0
    d = -load[0] / stiffness + side * 0.5 * gap
    v = 0.0
    h = step / substeps
    for k in range(len(load)):
        a = 0.0
        damping = 2.0 * _DAMPING * np.sqrt(stiffness * inertia[k])
        for _ in range(substeps):
            if d > 0.5 * gap:
                torque = stiffness * (d - 0.5 * gap)
            elif d < -0.5 * gap:
                torque = stiffness * (d + 0.5 * gap)
            else:
                torque = 0.0
            a = (-load[k] - torque - damping * v) / inertia[k]
            v += h * a
            d += h * v
        d_out[k], a_out[k] = d, a
    return d_out, a_out


def transmission_column(
    signals: Recording, joint: int, stiffness: float, gap: float
) -> FloatArray:
    """Return (N, n, 1): what the effort is more than with a stiff gear, first order in d."""
    mass, slope = mass_and_slope(signals)
    if ('load', joint) not in signals.cache:
        # A resonance would amplify noise, and noise of position is in what is left of effort, too.
        rotors = np.diag(signals.robot.armature)
        doubt = np.broadcast_to(signals.doubted, signals.q.shape)
        noise = _solved(mass + rotors, doubt)
        rotor = signals.robot.armature[joint] * (signals.a - noise)[:, joint]
        signals.cache[('load', joint)] = (signals.rigid - doubt)[:, joint] - rotor
    load = signals.cache[('load', joint)]
    inertia = np.ascontiguousarray(mass[:, joint, joint])
    frequency = np.sqrt(stiffness / float(inertia.min())) / (2.0 * np.pi)
    substeps = max(1, int(np.ceil(_STEPS * frequency * signals.band.step)))
    d, a = deflection(load, inertia, stiffness, gap, signals.band.step, substeps)
    return np.asarray(mass[:, :, joint] * a[:, None] + slope[:, :, joint] * d[:, None])[:, :, None]


def _solved(M: FloatArray, x: FloatArray) -> FloatArray:
    """Return M^-1 x along a motion, (N, n); the least where a joint moves nothing."""
    try:
        result = np.linalg.solve(M, x[:, :, None])
    except np.linalg.LinAlgError:
        result = np.linalg.pinv(M, hermitian=True) @ x[:, :, None]
    return np.asarray(result[:, :, 0])


def resonances(signals: Recording, joint: int) -> FloatArray:
    """
    Return stiffnesses with resonances from a thirtieth of the band to just above it.

    Of a band of 25 to 50 Hz that is 0.8 to 1.6 Hz: what is softer is seen to swing. As many as a
    small grid has (band_rows.SMALL_GRID): of a larger one only some lines are no noise.
    """
    frequencies = signals.band.cutoff * np.geomspace(1.0 / 30.0, 1.2, 12)
    return np.asarray(_inertia_behind(signals, joint) * (2.0 * np.pi * frequencies) ** 2)


def _inertia_behind(signals: Recording, joint: int) -> float:
    """Return the inertia of the body behind a gear, in the middle of the motion."""
    whole = signals.robot.inertia(np.median(signals.q, axis=0))[joint, joint]
    return max(float(whole - signals.robot.armature[joint]), 1e-9)
