# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X is asked before it may be enabled, and what is made of its answers."""

import math
from typing import Any

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.driver.start_up import Check, Request, Step
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import Protocol
from sosml_friction.actuators.rmd_x.configuration import MOTOR_TURN, NO_TURN, RmdXConfiguration
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

# A motor whose watchdog has tripped says so once a second.
WATCHDOG_LISTEN_NS = 1_200_000_000
# Counts and angle of one position may differ by noise and by what the joint moved between [rad].
_SCALE_SLACK = 0.02
_MODEL_BLOCKS = 3


class RmdXStartUp(Actuator):
    """
    Give the steps version, model, status, position and watchdog of one motor, not driven yet.

    They only read, but for the motor's watchdog (0xB3) where ``motor_watchdog_ms`` asks for it.
    ``protocol``: variant of the protocol, None before it is known; ``date``: the firmware's;
    ``blocks``: the model's name in parts; ``angle`` [rad]: of 0x92; ``counts_turns`` [rad]: 0x92
    minus the angle by counts, whole turns. ``watchdog_off`` says that the watchdog did not trip,
    '' if it did or was not judged.
    """

    configuration: RmdXConfiguration

    def __init__(
        self, configuration: RmdXConfiguration, limits: JointLimits, rate: float, **rest: Any
    ) -> None:
        super().__init__(configuration, limits, rate, **rest)
        self.protocol: Protocol | None = None
        self.date = 0
        self.blocks: dict[int, str] = {}
        self.angle = math.nan
        self.counts_turns = 0.0
        self.watchdog_off = ''
        self._wanted_ns = configuration.motor_watchdog_ms * 1_000_000
        self._turn_offset = 0.0
        self._seen = 0
        self._trips = False
        self._written = False
        self.ask_angle = self.request(
            rmd_x.ReadEncoder() if configuration.counts_per_turn else rmd_x.ReadAngle()
        )
        self.ask_status = self.request(rmd_x.ReadStatus())
        self.ask_uptime = self.request(rmd_x.ReadUptime())

    @property
    def reply_id(self) -> int:
        return rmd_x.REPLY_BASE + self.configuration.can_id

    def request(self, message: rmd_x.Request, patience_ns: int = 0) -> Request:
        """Return the frame that says ``message`` to this motor, and the key of its reply."""
        frame = rmd_x.encode_request(self.configuration.can_id, message)
        return Request(frame, (self.reply_id, int(message.command)), patience_ns)

    def counted(self, counts: float) -> float:
        """Return the angle of encoder counts [rad]."""
        return 2.0 * math.pi * counts / self.configuration.counts_per_turn

    def set_turn_offset(self, offset: float) -> None:
        """Take the encoder to have lost this angle [rad]."""
        self.measurement.q += offset - self._turn_offset
        self._turn_offset = offset

    def _check(self, step: str, result: str, problem: str = '', warning: str = '') -> Check:
        return Check(self.name, step, result, problem, warning)

    def _silent(self) -> Check:
        return self._check('watchdog', 'no answer', self.silence())

    def start_up(self, *, read_only: bool, watchdog: bool = True) -> list[Step]:
        """Return version, model, status, position and, if asked for, watchdog."""
        steps = [
            Step('version', self._ask_version, self._check_version),
            *(self._model_step(block) for block in range(1, _MODEL_BLOCKS + 1)),
            Step('status', lambda: [self.ask_status, self.ask_uptime], self._check_status),
            Step('position', self._ask_position, self.check_position),
        ]
        if not watchdog:
            return steps
        self._written = False
        if not self._wanted_ns or read_only:
            return [*steps, self._watchdog_step(last=True)]
        write = Step('watchdog written', self._write_watchdog, lambda: None)
        return [*steps, self._watchdog_step(last=False), write, self._watchdog_step(last=True)]

    def _ask_version(self) -> list[Request]:
        self.protocol = None
        self.blocks.clear()
        return [self.request(rmd_x.ReadVersion())]

    def _check_version(self) -> Check:
        text = f'firmware {self.date}'
        try:
            self.protocol = Protocol.of_version(self.date)
        except CanProtocolError as error:
            return self._check('version', text, f'joint {self.name}: {error}')
        return self._check('version', f'{text}, protocol {self.protocol.value}')

    def _model_step(self, block: int) -> Step:
        def ask() -> list[Request]:
            if self.protocol is Protocol.V4_4:
                return [self.request(rmd_x.ReadModel(block))]
            return [] if block > 1 else [self.request(rmd_x.ReadModel())]

        def check() -> Check | None:
            return self._check_model() if block == _MODEL_BLOCKS else None

        return Step('model', ask, check, attempts=2, unanswered=check)

    def _check_model(self) -> Check:
        blocks = self.blocks
        model = self.measurement.model = ''.join(blocks[key] for key in sorted(blocks))
        warning = f'joint {self.name}: the motor does not tell its model (0xB5)'
        return self._check('model', model or 'no answer', warning='' if model else warning)

    def _check_status(self) -> Check:
        measured = self.measurement
        text = (
            f'{measured.temperature:.0f} degC, {measured.voltage:.1f} V, on for '
            f'{measured.uptime:.1f} s, errors: {self.flags()}'
        )
        return self._check('status', text, self.fault())

    # ---- position

    def _ask_position(self) -> list[Request]:
        # The status first: a motor whose watchdog has tripped only echoes the first question, and
        # the echo of 0x92 would be the answer "0 degrees".
        requests = [self.ask_status, self.request(rmd_x.ReadAngle())]
        # Both, where counts are used: their scale is nowhere else to be checked.
        if self.configuration.counts_per_turn:
            requests.append(self.ask_angle)
        return requests

    def check_position(self) -> Check:
        """Bring the position into the joint's band by whole turns, if there is one way only."""
        measured = self.measurement
        self.set_turn_offset(0.0)
        if self.configuration.counts_per_turn and (problem := self._compare_counts()):
            return self._check('position', f'{measured.position_raw:.0f} counts', problem)
        problem = self.out_of_band()
        if not problem:
            return self._check('position', f'{measured.q:.4f}, inside its limits')
        if self.configuration.lost_turns == NO_TURN:
            return self._check('position', f'{measured.q:.4f}, outside', problem)
        return self._correct_turns(problem)

    def _compare_counts(self) -> str:
        """Take the turns between 0x92 and counts; return why their scale is wrong, or ''."""
        raw = self.measurement.position_raw
        counted = self.counted(raw)
        rest = math.remainder(self.angle - counted, 2.0 * math.pi)
        self.counts_turns = self.angle - counted - rest
        if abs(rest) <= _SCALE_SLACK:
            return ''
        return (
            f'joint {self.name}: {raw:.0f} counts (0x60) would be {counted:.4f} rad where 0x92 '
            f'says {self.angle:.4f}: correct {self.name}.counts_per_turn, or set it to 0'
        )

    def _correct_turns(self, problem: str) -> Check:
        turn = 2.0 * math.pi
        if self.configuration.lost_turns == MOTOR_TURN:
            turn /= self.configuration.gear_ratio
        raw = self.measurement.q
        turns = lost_turns(raw, self.limits, self.margin, turn)
        if len(turns) != 1:
            found = (
                f'{len(turns)} numbers of turns of {turn:.4f} would bring it inside'
                if turns
                else f'no whole number of turns of {turn:.4f} brings it inside'
            )
            return self._check('position', f'{raw:.4f}, outside', f'{problem} ({found})')
        self.set_turn_offset(turns[0] * turn)
        q = self.measurement.q
        return self._check(
            'position',
            f'{q:.4f} after {turns[0]:+d} turns of {turn:.4f}',
            warning=f'joint {self.name}: its encoder had lost {-turns[0]:+d} turns of '
            f'{turn:.4f}; {raw:.4f} is taken for {q:.4f}',
        )

    # ---- the motor's own watchdog

    @property
    def _pause_ns(self) -> int:
        # One that is set as wanted has tripped by then; else any time will do.
        return self._wanted_ns * 3 // 2 + 20_000_000 if self._wanted_ns else WATCHDOG_LISTEN_NS

    def _watchdog_step(self, *, last: bool) -> Step:
        """
        Listen and then ask: a motor that has tripped sends 0xF1, or echoes what it is asked.

        Where any time will do, one that had tripped before the first question counts too.
        """
        begun: list[int] = []

        def heard() -> bool:
            if not begun:
                begun.append(self.timeouts if self._wanted_ns else self._seen)
            return self.timeouts > begun[0] or (last and self._trips)

        def check() -> Check | None:
            self._trips = heard()
            self._seen = self.timeouts
            return self._check_watchdog() if last else None

        # Asked even after 0xF1: the first question after it only wakes the motor up.
        return Step(
            'watchdog',
            lambda: [self.ask_status],
            check,
            self._pause_ns,
            heard,
            unanswered=lambda: check() if heard() else self._silent(),
        )

    def _check_watchdog(self) -> Check:
        pause = self._pause_ns * 1e-9
        if self._trips:
            self.watchdog_off = ''
            return self._check('watchdog', f'trips within {pause:.2g} s')
        self.watchdog_off = (
            f"joint {self.name}: the motor's own watchdog (0xB3) did not trip within {pause:.2g} "
            's: if this program is killed, the motor keeps its last current'
        )
        if self._written:
            problem = f'{self.watchdog_off}; {self.name}.motor_watchdog_ms had no effect'
            return self._check('watchdog', 'does not trip', problem)
        self.watchdog_off += f': set {self.name}.motor_watchdog_ms'
        return self._check('watchdog', 'off, or too slow', warning=self.watchdog_off)

    def _write_watchdog(self) -> list[Request]:
        """Write 0xB3, unless the motor's watchdog trips in time already: it goes to ROM."""
        if self._trips:
            return []
        self._written = True
        milliseconds = self.configuration.motor_watchdog_ms
        return [self.request(rmd_x.SetTimeout(milliseconds))]


# No motor winds up further than this before it is looked at.
_MOST_TURNS = 1000


def lost_turns(q: float, limits: JointLimits, margin: float, turn: float) -> list[int]:
    """
    Return every k, by size, for which q + k * turn is inside the joint's band.

    The band is lower - margin to upper + margin. One k: that many turns were lost. None: the
    encoder's zero is wrong. Several: the band is wider than a turn, and nobody can tell.

    :param q: the angle by the encoder [rad or m].
    :param turn: the angle of one turn at the joint [rad or m], > 0.
    """
    low, high = limits.lower - margin, limits.upper + margin
    if not math.isfinite(q):
        return []
    first, last = math.ceil((low - q) / turn), math.floor((high - q) / turn)
    if max(abs(first), abs(last)) > _MOST_TURNS:
        return []
    return sorted(range(first, last + 1), key=abs)
