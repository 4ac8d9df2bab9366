# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A robot as the forward simulation has it: bodies, friction that sticks, and terms."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.simulated_term import Body, Gear, SimulatedTerm

#: Radians of the fastest oscillation in a step, which is 0.6 % slow then; stable below 2.8.
_RADIANS = 1.0
#: Time constants of the fastest damping in a step.
_DAMPED = 1.0
_FEWEST, _MOST = 1, 500
#: Least inertia of a simulated rotor, as a share of that of its body: a lighter one would need
#: steps that cost more than they tell. Chosen, no measurement.
_LIGHTEST = 1e-3
#: Rounds in which the measured position is found from the true one.
_ROUNDS = 4


class ForwardModel:
    """
    Hold what is simulated: M q'' + C q' + g = torque - friction - loads of the terms.

    :param robot: bodies and rotors before the terms change them.
    :param displacement: over which friction turns around at a reversal (n,) [rad or m], positive:
        Dahl's state in the place of the sign, so that the arm sticks.
    :param delay: of the reported effort in addition to the terms' (n,) [s].
    :raises ConfigurationError: if a displacement is not positive, two gears are in one joint, or
        no inertia is left.
    """

    def __init__(
        self,
        robot: Robot,
        friction: JointFriction,
        displacement: FloatArray,
        terms: Sequence[SimulatedTerm] = (),
        delay: FloatArray | float = 0.0,
    ) -> None:
        self.friction = friction
        self.terms = tuple(terms)
        self.displacement = np.asarray(displacement, dtype=float)
        if not ((self.displacement > 0.0) & np.isfinite(self.displacement)).all():
            raise ConfigurationError(
                f'friction turns around over {self.displacement.tolist()}: give each joint a '
                'positive displacement'
            )
        body = Body(
            robot.inertial_parameters(),
            np.array(robot.armature, dtype=float),
            robot.gravity_acceleration,
        )
        for term in self.terms:
            term.change_body(body)
        self.rotors = body.rotors
        # Rotors are added where the gear is stiff.
        self.robot = robot.changed(body.inertias, np.zeros(robot.n), body.gravity)
        self.n = robot.n
        self.delay = np.zeros(robot.n) + delay
        for term in self.terms:
            self.delay += term.delay
        gears: dict[int, Gear] = {}
        for gear in filter(None, (term.gear() for term in self.terms)):
            if gear.joint in gears:
                first = gears[gear.joint]
                # Springs one behind the other, and their gaps.
                stiffness = 1.0 / (1.0 / first.stiffness + 1.0 / gear.stiffness)
                gear = Gear(gear.joint, stiffness, first.gap + gear.gap, gear.damping)
            gears[gear.joint] = gear
        self.gears = tuple(gears[joint] for joint in sorted(gears))

    def rigid_rotors(self) -> FloatArray:
        """Return the rotors (n,) that move with their bodies."""
        rotors = self.rotors.copy()
        rotors[[gear.joint for gear in self.gears]] = 0.0
        return rotors

    def motors(self, q: FloatArray) -> FloatArray:
        """Return the inertia (g,) of the motors before the gears that give, at a posture (n,)."""
        M = np.diag(self.robot.inertia(q))
        return np.array(
            [max(self.rotors[gear.joint], _LIGHTEST * M[gear.joint]) for gear in self.gears]
        )

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque (..., n) behind a reported effort, delays left out."""
        for term in reversed(self.terms):
            reported = term.torque(reported)
        return reported

    def true_position(self, measured: FloatArray) -> FloatArray:
        """Return where the motors are, (..., n)."""
        for term in self.terms:
            measured = term.true_position(measured)
        return measured

    def measured_position(self, true: FloatArray) -> FloatArray:
        """Return what the encoders say, (..., n): the inverse of the former, by repetition."""
        measured = np.array(true)
        for _ in range(_ROUNDS):
            measured = true - (self.true_position(measured) - measured)
        return measured

    def steps(self, q: FloatArray, effort: FloatArray, period: float) -> int:
        """
        Return in how many steps a period is to be integrated.

        A step must be short beside the period of the fastest oscillation (of a body on friction
        that builds up, on a spring or on a gear) and beside the time constant of damping.

        :param q: a posture (n,); effort (n,): the largest, of the size that friction by load has.
        :raises ConfigurationError: if more than 1000 were needed.
        """
        A = self.robot.inertia(q) + np.diag(self.rigid_rotors())
        if not (np.linalg.eigvalsh(A) > 0.0).all():
            raise ConfigurationError(
                'a joint of the model has no inertia left to be moved: give it an armature'
            )
        light = 1.0 / np.diag(np.linalg.inv(A))
        level = self.friction.level + sum(
            (term.friction_level(effort) for term in self.terms), start=np.zeros(self.n)
        )
        stiff = level / self.displacement + sum(
            (term.stiffness() for term in self.terms), start=np.zeros(self.n)
        )
        viscous = self.friction.damping
        rate = np.maximum(np.sqrt(stiff / light) / _RADIANS, viscous / light / _DAMPED)
        for gear, motor in zip(self.gears, self.motors(q), strict=True):
            i = gear.joint
            body = 1.0 / np.linalg.inv(A)[i, i]
            damping = float(gear_damping(gear.damping, gear.stiffness, A[i, i]))
            alone = min(motor, body)
            rate[i] = max(
                rate[i],
                np.sqrt((gear.stiffness + stiff[i]) / motor + gear.stiffness / body) / _RADIANS,
                (damping + viscous[i]) / alone / _DAMPED,
            )
        count = int(np.ceil(period * float(rate.max())))
        if count > _MOST:
            raise ConfigurationError(
                f'the model needs {count} steps of simulation in a sample of {period:g} s: its '
                'friction turns around over too small a displacement for its inertia, or a gear '
                'is too stiff for its motor'
            )
        return max(_FEWEST, count)


def gear_damping(
    share: FloatArray | float, stiffness: FloatArray | float, inertia: FloatArray | float
) -> FloatArray:
    """Return the damping [Nm s/rad or N s/m] of gears, 2 D sqrt(K J), by numbers or arrays."""
    return np.asarray(2.0 * share * np.sqrt(stiffness * inertia))
