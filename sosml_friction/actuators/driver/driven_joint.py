# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One joint as the driver keeps it: what it measured last, and what speaks against driving it."""

import math

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.lateness import Lateness
from sosml_friction.actuators.driver.report import JointReport
from sosml_friction.motion.velocity import WindowedSlope

# A joint that is faster than this many times its limit is a fault.
SPEED_FACTOR = 1.2
# A joint that moves less than the first share of its tracking limit while its reference moves more
# than the second is stuck.
STILL_SHARE, STUCK_SHARE = 0.01, 0.25
# For as many cycles in a row a measurement may be one that cannot be true.
DOUBTFUL_CYCLES = 25


class DrivenJoint:
    """
    Keep one joint: its actuator, velocity, silence, and the faults that are its own.

    ``v``: the slope of its last positions, NaN until the window is full, by which the loop damps;
    ``sampled_v``: of those alone whose time is known, by which it is judged; ``known_v``: the last
    ``v`` that was known: after a hiccup of the host the window fills anew for a few cycles, and a
    joint damped by an old velocity is better off than an undamped one. ``away``: it must be asked
    anew before it is driven. ``late``: nobody knows when it measured what it answered last.
    """

    def __init__(self, actuator: Actuator, configuration: DriverConfiguration) -> None:
        self.actuator = actuator
        self.name = actuator.name
        self._configuration = configuration
        window = configuration.velocity_window
        self._slope = WindowedSlope(window, window * configuration.period_ns)
        self._sampled_slope = WindowedSlope(window, window * configuration.period_ns)
        self._missed = 0
        self._latency_ns = 0
        self._lateness = Lateness(configuration.period_ns)
        self.late = False
        self.begin()

    def begin(self) -> None:
        """Start anew where it is: what was measured before belongs to another drive."""
        self._slope.reset()
        self._sampled_slope.reset()
        self.v = self.sampled_v = math.nan
        self.known_v = 0.0
        self.away = False
        self._silent_since: int | None = None
        self._silence_ns = 0
        self._start_problem = ''
        # Where it was when it last answered, and whether it was switched on anew since.
        self._trusted_q = self.q
        self._restarted = False
        self.enable()

    def enable(self) -> None:
        """Forget what has happened: the drive begins."""
        self.note_events()
        self._last_q, self._last_ns = math.nan, 0
        self._impulse, self._driven_s = 0.0, 0.0
        self._doubtful = 0
        self._doubt = ''
        self._still_q = self._still_reference = math.nan

    def note_events(self) -> None:
        """Count the watchdog's trips and the restarts up to now as known."""
        self._timeouts, self._restarts = self.actuator.timeouts, self.actuator.restarts

    @property
    def q(self) -> float:
        """Return the last position [rad or m]."""
        return self.actuator.measurement.q

    @property
    def stamp_ns(self) -> int:
        """Return when the last position was asked for, and measured [ns]."""
        return self.actuator.measurement.stamp_ns

    # ---- what a cycle brings

    def take(self, start_ns: int) -> None:
        """Take the measurement of a cycle that began at ``start_ns`` and brought all replies."""
        self._latency_ns = self.actuator.measurement.received_ns - start_ns
        self.late = self._lateness.is_late(self._latency_ns)
        if not self.late:
            self.sampled_v = self._sampled_slope.update(self.stamp_ns, self.q)
        if self.late and self._latency_ns > self._slope.gap_ns:
            # Its time may be any within more than a whole window: no slope comes of it.
            self._slope.reset()
            self.v = math.nan
        else:
            # The loop takes what is newest, whatever its time.
            self.v = self._slope.update(self.stamp_ns, self.q)
        if not math.isnan(self.v):
            self.known_v = self.v
        step, seconds = self.q - self._last_q, (self.stamp_ns - self._last_ns) * 1e-9
        if seconds * 1e9 > self._slope.gap_ns:
            # After a silence, or at the beginning: what drove it meanwhile is not known.
            self._impulse, self._driven_s = 0.0, 0.0
        else:
            self._impulse += self.actuator.measurement.tau * seconds
            self._driven_s += seconds
        self._last_q, self._last_ns = self.q, self.stamp_ns
        doubt = self.actuator.doubt(self.v, step, seconds)
        self._doubtful = self._doubtful + 1 if doubt else 0
        self._doubt = doubt

    def take_effort(self) -> float:
        """
        Return the mean effort since the last sample [Nm or N], and begin that of the next.

        What is measured at the end of a cycle held in it; a cycle may have given no sample.
        """
        impulse, seconds = self._impulse, self._driven_s
        self._impulse, self._driven_s = 0.0, 0.0
        return impulse / seconds if seconds > 0.0 else self.actuator.measurement.tau

    @property
    def timely(self) -> bool:
        """Tell whether the last replies came soon enough to be no answers to the cycle before."""
        return self._latency_ns * 1e-9 <= 0.5 * self._configuration.reply_timeout

    def hear(self) -> None:
        """Take note that it has answered in time."""
        self._silent_since = None
        self._silence_ns = 0

    def wait(self, start_ns: int, now_ns: int, *, missed: bool) -> None:
        """Count a cycle, begun at ``start_ns``, that brought no timely answer."""
        self._missed += missed
        if self._silent_since is None:
            self._silent_since = start_ns
        self._silence_ns = now_ns - self._silent_since

    def trust(self) -> None:
        """Remember where it is, for a return from a restart."""
        if not self.away:
            self._trusted_q = self.q

    # ---- what speaks against driving it

    @property
    def answers(self) -> bool:
        """Tell whether the last cycle brought a timely answer."""
        return self._silent_since is None

    @property
    def silent(self) -> bool:
        """Tell whether it has been silent for longer than it may."""
        return self._silence_ns >= self._configuration.silence_ns

    def problem(self) -> str:
        """Return what stands against driving it now, '' if nothing."""
        if self.silent:
            time_ms = self._silence_ns * 1e-6
            return f'{self.actuator.silence()} (no timely answer for {time_ms:.0f} ms)'
        return (
            self.actuator.fault()
            or self._start_problem
            or self.actuator.out_of_band()
            or self._too_fast()
            or (self._doubt if self._doubtful >= DOUBTFUL_CYCLES else '')
        )

    def _too_fast(self) -> str:
        # With a position whose time is not known, any joint that moves may seem too fast.
        limit = self.actuator.limits.velocity
        if abs(self.sampled_v) > SPEED_FACTOR * limit:
            return (
                f'joint {self.name} moves at {self.sampled_v:.3f} per second, above '
                f'{SPEED_FACTOR:g} times its limit {limit:g}'
            )
        return ''

    def event(self) -> str:
        """Return what has happened to it since the last cycle, '' if nothing."""
        if self.actuator.restarts > self._restarts:
            self.away = self._restarted = True
            return f'joint {self.name}: the motor was switched on anew while it was driven'
        if self.actuator.timeouts > self._timeouts:
            return (
                f"joint {self.name}: the motor's own watchdog switched it off: commands came "
                'too late or not at all'
            )
        return ''

    def tracking_problem(self, reference: float) -> str:
        """Return how it fails to follow ``reference`` [rad or m], '' if it does follow."""
        q, limit = self.q, self.actuator.configuration.tracking_limit
        if not abs(reference - q) <= limit:
            return (
                f'joint {self.name} is at {q:.4f} where its reference is {reference:.4f}, '
                f'further than tracking_limit {limit:g}: something holds or drives it'
            )
        if not abs(q - self._still_q) <= STILL_SHARE * limit:
            self._still_q, self._still_reference = q, reference
        travel = abs(reference - self._still_reference)
        if travel > STUCK_SHARE * limit:
            return (
                f'joint {self.name} stays at {q:.4f} while its reference moved by '
                f'{travel:.4f}: it is blocked, its brake is closed or its encoder is stuck'
            )
        return ''

    def come_back(self, problem: str) -> None:
        """
        Take it back after its start-up, which found ``problem`` or ''.

        A motor that is moved while it is off may lose whole turns, of its own or of the output.
        Within the joint's limits nothing else tells.
        """
        self._restarted |= self.actuator.restarts > self._restarts
        distance = abs(self.q - self._trusted_q)
        if not problem and self._restarted and distance > self.actuator.restart_distance():
            problem = (
                f'joint {self.name} was switched off and came back {distance:.3f} from where it '
                'was: it may have lost count of its turns: move it back to where it was, or check '
                'its angle and configure the driver anew'
            )
        self._start_problem = problem
        self.away = bool(problem)
        self._restarted &= bool(problem)

    def report(self, problem: str, reference: float) -> JointReport:
        """Return a snapshot: its problem, and its reference, NaN while not driven."""
        actuator = self.actuator
        return JointReport(
            **vars(actuator.measurement),
            name=self.name,
            v=self.v,
            flags=actuator.flags(),
            missed=self._missed,
            problem=problem,
            warning=actuator.warning(),
            latency=self._latency_ns * 1e-9,
            usual_latency=(self._lateness.usual_ns or 0) * 1e-9,
            tracking_error=reference - self.q,
            timeouts=actuator.timeouts,
            restarts=actuator.restarts,
        )
