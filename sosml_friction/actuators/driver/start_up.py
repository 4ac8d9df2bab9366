# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The start-up of an actuator as a list of steps: ask, check, say. No input or output here.

An :class:`~sosml_friction.actuators.actuator.Actuator` gives its steps; :class:`StartUp` walks
through them; :func:`~.checks.run_start_ups` sends and receives.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sosml_friction.actuators.bus.frame import Frame

ATTEMPTS = 3
ANSWER_TIMEOUT_NS = 200_000_000


class Request(NamedTuple):
    """
    A frame to send and the key of the one reply it must bring.

    ``patience_ns``: 0 for a reply that belongs to the cycle; else the cycle does not wait for it,
    and it is late only after that time.
    """

    frame: Frame
    key: Hashable
    patience_ns: int = 0


@dataclass(frozen=True)
class Check:
    """
    Hold what one step of a start-up found.

    ``step``: version, model, status, position, watchdog, ...; ``result``: what was found, in
    words; ``problem``: why the joint must not be enabled, '' if nothing speaks against it;
    ``warning``: what its user should know all the same.
    """

    joint: str
    step: str
    result: str
    problem: str = ''
    warning: str = ''


@dataclass(frozen=True)
class Step:
    """
    Describe one step.

    ``requests`` are made when the step begins; where it returns none, nothing is asked. Before,
    the bus is only listened to for ``pause_ns``, or until ``heard`` is true. ``check`` is called
    when all replies are in; ``unanswered`` instead when they are not after all attempts: by
    default the actuator's silence is then a problem.
    """

    name: str
    requests: Callable[[], list[Request]]
    check: Callable[[], Check | None]
    pause_ns: int = 0
    heard: Callable[[], bool] = lambda: False
    attempts: int = ATTEMPTS
    unanswered: Callable[[], Check | None] | None = None


class StartUp:
    """
    Walk through the steps of one actuator; a problem ends the walk.

    Per round: listen for :attr:`pause_ns` (stop when :meth:`heard`), send :meth:`requests`,
    collect replies for :data:`ANSWER_TIMEOUT_NS`, then tell :meth:`take` which keys are missing.

    :param silence: the sentence for an actuator that does not answer.
    """

    def __init__(self, joint: str, steps: Sequence[Step], silence: str = '') -> None:
        self.joint = joint
        self._silence = silence
        self.checks: list[Check] = []
        self._steps = list(steps)
        self._attempt = 0

    @property
    def done(self) -> bool:
        """Tell whether there is nothing left to ask."""
        return not self._steps or bool(self.problem)

    @property
    def problem(self) -> str:
        """Return why the joint must not be enabled, '' if nothing was found yet."""
        return next((check.problem for check in self.checks if check.problem), '')

    @property
    def pause_ns(self) -> int:
        """Return how long to listen before asking; only before the first attempt of a step."""
        return 0 if self.done or self._attempt else self._steps[0].pause_ns

    def heard(self) -> bool:
        """Tell whether listening has brought what it was for."""
        return self.done or self._steps[0].heard()

    def requests(self) -> list[Request]:
        """Return what to ask in this round, nothing when done."""
        return [] if self.done else self._steps[0].requests()

    def take(self, missing: set[Hashable], asked: Sequence[Request]) -> None:
        """End a round: of what was ``asked`` the keys ``missing`` had no reply."""
        if self.done:
            return
        step = self._steps[0]
        if any(request.key in missing for request in asked):
            self._attempt += 1
            if self._attempt < step.attempts:
                return
            silent = Check(self.joint, step.name, 'no answer', problem=self._silence)
            check = silent if step.unanswered is None else step.unanswered()
        else:
            check = step.check()
        self._attempt = 0
        del self._steps[0]
        if check is not None:
            self.checks.append(check)
