# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X is asked before it may be enabled, and what is made of its answers."""

from __future__ import annotations

import math

from sosml_friction.actuators.driver.start_up import Check, Request, Step
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.configuration import MOTOR_TURN, NO_TURN
from sosml_friction.actuators.rmd_x.motor import RmdXMotor
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.actuators.rmd_x.turns import lost_turns
from sosml_friction.exceptions import CanProtocolError

# A motor whose watchdog has tripped says so once a second.
WATCHDOG_LISTEN_NS = 1_200_000_000
# Counts and angle of one position may differ by noise and by what the joint moved between [rad].
_SCALE_SLACK = 0.02
_MODEL_BLOCKS = 3


class RmdXStartUp:
    """
    Give the steps version, model, status, position and watchdog of one motor.

    They only read, but for the motor's watchdog (0xB3) where ``motor_watchdog_ms`` asks for it.
    ``watchdog_off`` says that the watchdog did not trip, '' if it did or was not judged.
    """

    def __init__(self, actuator: RmdXMotor) -> None:
        self._own = actuator
        self.watchdog_off = ''
        self._seen = 0
        self._trips = False
        self._written = False

    @property
    def _name(self) -> str:
        return self._own.name

    def _check(self, step: str, result: str, problem: str = '', warning: str = '') -> Check:
        return Check(self._name, step, result, problem, warning)

    def _silent(self) -> Check:
        return self._check('watchdog', 'no answer', self._own.silence())

    def steps(self, *, read_only: bool, watchdog: bool) -> list[Step]:
        """Return the steps; see :meth:`Actuator.start_up`."""
        steps = [
            Step('version', self._ask_version, self._check_version),
            *(self._model_step(block) for block in range(1, _MODEL_BLOCKS + 1)),
            Step(
                'status', lambda: [self._own.ask_status, self._own.ask_uptime], self._check_status
            ),
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
        self._own.protocol = None
        self._own.blocks.clear()
        return [self._own.request(rmd_x.ReadVersion())]

    def _check_version(self) -> Check:
        text = f'firmware {self._own.date}'
        try:
            self._own.protocol = Protocol.of_version(self._own.date)
        except CanProtocolError as error:
            return self._check('version', text, f'joint {self._name}: {error}')
        return self._check('version', f'{text}, protocol {self._own.protocol.value}')

    def _model_step(self, block: int) -> Step:
        def ask() -> list[Request]:
            if self._own.protocol is Protocol.V4_4:
                return [self._own.request(rmd_x.ReadModel(block))]
            return [] if block > 1 else [self._own.request(rmd_x.ReadModel())]

        def check() -> Check | None:
            return self._check_model() if block == _MODEL_BLOCKS else None

        return Step('model', ask, check, attempts=2, unanswered=check)

    def _check_model(self) -> Check:
        blocks = self._own.blocks
        model = self._own.measurement.model = ''.join(blocks[key] for key in sorted(blocks))
        warning = f'joint {self._name}: the motor does not tell its model (0xB5)'
        return self._check('model', model or 'no answer', warning='' if model else warning)

    def _check_status(self) -> Check:
        measured = self._own.measurement
        text = (
            f'{measured.temperature:.0f} degC, {measured.voltage:.1f} V, on for '
            f'{measured.uptime:.1f} s, errors: {self._own.flags()}'
        )
        return self._check('status', text, self._own.fault())

    # ---- position

    def _ask_position(self) -> list[Request]:
        # The status first: a motor whose watchdog has tripped only echoes the first question, and
        # the echo of 0x92 would be the answer "0 degrees".
        requests = [self._own.ask_status, self._own.request(rmd_x.ReadAngle())]
        # Both, where counts are used: their scale is nowhere else to be checked.
        if self._own.configuration.counts_per_turn:
            requests.append(self._own.ask_angle)
        return requests

    def check_position(self) -> Check:
        """Bring the position into the joint's band by whole turns, if there is one way only."""
        own, measured = self._own, self._own.measurement
        own.set_turn_offset(0.0)
        if own.configuration.counts_per_turn and (problem := self._compare_counts()):
            return self._check('position', f'{measured.position_raw:.0f} counts', problem)
        problem = own.out_of_band()
        if not problem:
            return self._check('position', f'{measured.q:.4f}, inside its limits')
        if own.configuration.lost_turns == NO_TURN:
            return self._check('position', f'{measured.q:.4f}, outside', problem)
        return self._correct_turns(problem)

    def _compare_counts(self) -> str:
        """Take the turns between 0x92 and counts; return why their scale is wrong, or ''."""
        own, raw = self._own, self._own.measurement.position_raw
        counted = own.counted(raw)
        rest = math.remainder(own.angle - counted, 2.0 * math.pi)
        own.counts_turns = own.angle - counted - rest
        if abs(rest) <= _SCALE_SLACK:
            return ''
        return (
            f'joint {self._name}: {raw:.0f} counts (0x60) would be {counted:.4f} rad where 0x92 '
            f'says {own.angle:.4f}: correct {self._name}.counts_per_turn, or set it to 0'
        )

    def _correct_turns(self, problem: str) -> Check:
        own = self._own
        turn = 2.0 * math.pi
        if own.configuration.lost_turns == MOTOR_TURN:
            turn /= own.configuration.gear_ratio
        raw = own.measurement.q
        turns = lost_turns(raw, own.limits, own.margin, turn)
        if len(turns) != 1:
            found = (
                f'{len(turns)} numbers of turns of {turn:.4f} would bring it inside'
                if turns
                else f'no whole number of turns of {turn:.4f} brings it inside'
            )
            return self._check('position', f'{raw:.4f}, outside', f'{problem} ({found})')
        own.set_turn_offset(turns[0] * turn)
        q = own.measurement.q
        return self._check(
            'position',
            f'{q:.4f} after {turns[0]:+d} turns of {turn:.4f}',
            warning=f'joint {self._name}: its encoder had lost {-turns[0]:+d} turns of '
            f'{turn:.4f}; {raw:.4f} is taken for {q:.4f}',
        )

    # ---- the motor's own watchdog

    @property
    def _wanted_ns(self) -> int:
        return self._own.configuration.motor_watchdog_ms * 1_000_000

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
                begun.append(self._own.timeouts if self._wanted_ns else self._seen)
            return self._own.timeouts > begun[0] or (last and self._trips)

        def check() -> Check | None:
            self._trips = heard()
            self._seen = self._own.timeouts
            return self._check_watchdog() if last else None

        # Asked even after 0xF1: the first question after it only wakes the motor up.
        return Step(
            'watchdog',
            lambda: [self._own.ask_status],
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
            f"joint {self._name}: the motor's own watchdog (0xB3) did not trip within {pause:.2g} "
            's: if this program is killed, the motor keeps its last current'
        )
        if self._written:
            problem = f'{self.watchdog_off}; {self._name}.motor_watchdog_ms had no effect'
            return self._check('watchdog', 'does not trip', problem)
        self.watchdog_off += f': set {self._name}.motor_watchdog_ms'
        return self._check('watchdog', 'off, or too slow', warning=self.watchdog_off)

    def _write_watchdog(self) -> list[Request]:
        """Write 0xB3, unless the motor's watchdog trips in time already: it goes to ROM."""
        if self._trips:
            return []
        self._written = True
        milliseconds = self._own.configuration.motor_watchdog_ms
        return [self._own.request(rmd_x.SetTimeout(milliseconds))]
