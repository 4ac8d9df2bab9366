# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What no working actuator measures, whatever its type."""

from dataclasses import dataclass

from sosml_friction.actuators.measurement import Measurement


@dataclass(frozen=True)
class Plausibility:
    """
    Judge one measurement; NaN is not measured and not judged. One odd value may be noise.

    |current| <= current_factor * ``current`` + current_slack: a current ripples. |v - speed| <=
    speed_factor |speed| + speed_slack: the slope of positions lags behind the actuator's own
    speed. |step| <= step_factor * ``velocity`` * seconds + ``step_slack``: a joint does not jump.
    temperature >= coldest: a sensor that is cut off reads absolute zero.

    :param current: the most it is commanded, or limits itself to [A].
    :param velocity: the joint's limit [rad/s or m/s].
    :param step_slack: what noise may add to a step [rad or m].
    """

    current: float
    velocity: float
    step_slack: float
    current_factor: float = 1.5
    current_slack: float = 0.5
    speed_factor: float = 0.3
    speed_slack: float = 0.6
    step_factor: float = 2.0
    coldest: float = -40.0

    def doubt(self, measured: Measurement, v: float, step: float, seconds: float) -> str:
        """
        Return what cannot be true if it lasts, '' if nothing.

        :param v: the slope of the last positions [rad/s or m/s].
        :param step: from the position before to this one [rad or m], in ``seconds`` [s].
        """
        if abs(measured.current) > self.current_factor * self.current + self.current_slack:
            return (
                f'reports {measured.current:.2f} A where its limit is {self.current:g} A: its '
                'current sensor or its own limit is wrong'
            )
        if abs(v - measured.speed) > self.speed_slack + self.speed_factor * abs(measured.speed):
            return (
                f'reports {measured.speed:.2f} per second, its position says {v:.2f}: one of its '
                'sensors is wrong'
            )
        if abs(step) > self.step_factor * self.velocity * seconds + self.step_slack:
            return (
                f'jumps by {step:.4f} within {1e3 * seconds:.1f} ms, where its limit is '
                f'{self.velocity:g} per second: its position sensor is wrong'
            )
        if measured.temperature < self.coldest:
            return (
                f'reports {measured.temperature:.0f} degC, below {self.coldest:g}: its '
                'temperature sensor is wrong'
            )
        return ''
