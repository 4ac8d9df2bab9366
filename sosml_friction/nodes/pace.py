# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How many of the last cycles gave no sample, because the machine did not get to it."""

from sosml_friction.actuators.driver.report import DriverReport

#: Share of the cycles since the last look beyond which it is told. Chosen, no measurement: T1 with
#: 7 % of the cycles lost is still identified to 3 % (docs/driver.md).
_MOST = 0.05
# After less than so many cycles a share says nothing.
_FEWEST = 20


class Pace:
    """Compare what a driver has counted with what it had at the last look."""

    def __init__(self) -> None:
        self._last = (0, 0, 0, 0)
        #: What is to be said of the cycles between the last two looks; empty: nothing.
        self.remark = ''

    def look(self, report: DriverReport, skipped: int) -> None:
        """Take the counts of now; ``skipped`` cycles were due, but never ran."""
        now = (report.cycles, report.late_cycles, report.incomplete_cycles, skipped)
        ran, late, incomplete, left_out = (
            new - old for new, old in zip(now, self._last, strict=True)
        )
        due, lost = ran + left_out, late + incomplete + left_out
        if min(ran, left_out) >= 0 and due < _FEWEST:
            # A command asks for diagnostics at once: too soon to judge.
            return
        self._last, self.remark = now, ''
        if lost > _MOST * due and min(ran, left_out) >= 0:
            self.remark = (
                f'{lost} of {due} cycles gave no sample ({left_out} never ran, {late} had answers '
                f'of an unknown time, {incomplete} lacked one): the machine or the bus is too '
                'busy: end other programs, or lower rate'
            )
