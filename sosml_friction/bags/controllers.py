# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What is recorded of the joints' controllers, for a simulation of the closed loop.

A bag has an entry for each joint in its tag ``controller.<joint>``, JSON, or all of them in the
latched topic ``controller_configuration``, where ``ros2 bag record`` made it. ``kind`` says what
else is in an entry:

- ``cascade`` (or none): ``kp``, ``kv``, ``scale`` and ``limit``, a position loop about a velocity
  loop (:class:`~sosml_friction.simulation.cascade_loop.CascadeController`).
- ``pd``: ``kp`` [Nm/rad or N/m], ``kd`` [Nm s/rad or N s/m], ``limit`` [Nm or N], ``rate_limit``
  [Nm/s or N/s], ``rate`` [Hz], ``velocity_window`` [samples]: what
  :class:`~sosml_friction.actuators.driver.drive_motion.DriveMotion` commands, the inverse
  dynamics of the driver's model at the reference plus kp (q_r - q) + kd (q_r' - q').
- ``actuator``: the loop is the actuator's own and not known; ``reason`` says so.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from sosml_friction.exceptions import BagError

if TYPE_CHECKING:
    from sosml_friction.bags.bag import Bag

#: Tags that begin so hold the controller of a joint.
CONTROLLER_TAG = 'controller.'
CONTROLLER_TOPIC = 'controller_configuration'
CASCADE, PD, ACTUATOR = 'cascade', 'pd', 'actuator'
#: What an entry must have, and what it may have, by kind.
_NEEDED = {
    CASCADE: ('kp', 'kv'),
    PD: ('kp', 'kd', 'limit', 'rate_limit', 'rate', 'velocity_window'),
    ACTUATOR: (),
}
_ALLOWED = {CASCADE: ('scale', 'limit'), PD: (), ACTUATOR: ('reason',)}


def read_controllers(bag: Bag) -> dict[str, dict[str, Any]]:
    """
    Return the entry of each joint whose controller a bag names; ``kind`` is always in it.

    :raises BagError: if an entry cannot be read.
    """
    texts = {
        key.removeprefix(CONTROLLER_TAG): value
        for key, value in bag.tags.items()
        if key.startswith(CONTROLLER_TAG)
    }
    where = f'the tags of {bag.path}'
    if not texts:
        text = bag.text(CONTROLLER_TOPIC)
        return {} if text is None else parse_controllers(text, f'{CONTROLLER_TOPIC} of {bag.path}')
    return {joint: _entry(joint, _json(text, where), where) for joint, text in texts.items()}


def parse_controllers(text: str, where: str) -> dict[str, dict[str, Any]]:
    """
    Read the text of ``controller_configuration``; ``where`` is for the error sentence.

    :raises BagError: if it is not JSON of that form.
    """
    document = _json(text, where)
    if not isinstance(document, dict):
        raise BagError(f'{where} names no joints: write an entry for each')
    return {str(joint): _entry(str(joint), entry, where) for joint, entry in document.items()}


def controller_tags(entries: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return the tags of a bag that hold these entries."""
    return {f'{CONTROLLER_TAG}{joint}': json.dumps(entry) for joint, entry in entries.items()}


def _json(text: str, where: str) -> Any:
    try:
        return json.loads(text)
    except ValueError as error:
        raise BagError(f'the controller in {where} is {text!r}: write it as JSON') from error


def _entry(joint: str, entry: Any, where: str) -> dict[str, Any]:
    kind = entry.get('kind', CASCADE) if isinstance(entry, dict) else None
    if kind not in _NEEDED:
        raise BagError(
            f'the controller of {joint} in {where} is {entry!r}: give it a kind, one of '
            f'{", ".join(_NEEDED)}'
        )
    numbers = {key: x for key, x in entry.items() if key not in ('kind', 'reason')}
    allowed = {'kind', *_NEEDED[kind], *_ALLOWED[kind]}
    if (
        not set(_NEEDED[kind]) <= set(entry) <= allowed
        or not all(isinstance(x, int | float) for x in numbers.values())
        or any(isinstance(x, bool) or math.isnan(x) for x in numbers.values())
    ):
        raise BagError(
            f'the controller of {joint} in {where} is {entry!r}: one of kind {kind} has the '
            f'numbers {", ".join(_NEEDED[kind]) or "none"}'
        )
    return {'kind': kind, **entry}
