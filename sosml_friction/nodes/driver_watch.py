# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the driver would move the robot, from its diagnostics."""

import time

from diagnostic_msgs.msg import DiagnosticArray

#: What it says while it moves.
FOLLOWING = 'following a trajectory'
#: Diagnostics that are older say nothing of the driver [s]; it sends them every second.
_FRESH_S = 3.0


class DriverWatch:
    """Hold what a driver, given by the full name of its node, said last of itself."""

    def __init__(self, driver: str) -> None:
        self._driver = driver.lstrip('/')
        self._name = f'{self._driver}: driver'
        self._heard_s = -_FRESH_S
        self._state, self._reason, self._commander, self._message = '', '', '', ''

    def take(self, message: DiagnosticArray) -> None:
        """Look for the driver's status in the diagnostics."""
        for status in message.status:
            if status.name == self._name:
                values = {item.key: item.value for item in status.values}
                self._heard_s = time.monotonic()
                self._state, self._reason = values.get('state', ''), values.get('fault', '')
                self._commander, self._message = values.get('commander', ''), status.message

    def follows(self, commander: str) -> bool:
        """Tell whether it said last that it follows a trajectory of ``commander``."""
        is_fresh = time.monotonic() - self._heard_s < _FRESH_S
        return is_fresh and self._commander == commander and self._message == FOLLOWING

    @property
    def said(self) -> str:
        """Return what it said last, as the second half of a sentence."""
        if time.monotonic() - self._heard_s > _FRESH_S:
            return f'no diagnostics come from {self._driver}: does it run, and is it enabled?'
        return f'{self._driver} says: {self._message}'

    def refusal(self, commander: str) -> str:
        """Return why it would not follow one of ``commander``, '' if it would or is not known."""
        if time.monotonic() - self._heard_s > _FRESH_S:
            return ''
        if self._state == 'fault':
            return (
                f'{self._driver} is in fault ({self._reason}): end the cause, then call its '
                '~/enable'
            )
        if self._state == 'disabled':
            return f'{self._driver} is disabled: call its ~/enable first'
        if self._commander not in ('', 'nobody', commander):
            return (
                f'{self._driver} is held by {self._commander}: wait until that is silent, or '
                'release it by its ~/enable with data: false'
            )
        return ''
