# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint whose controller and wanted position a recording holds."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import CASCADE, read_controllers
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.wrap import near_turn
from sosml_friction.simulation.cascade_loop import CascadeController


@dataclass(frozen=True)
class ControlledJoint:
    """
    Hold a joint's controller and its wanted position on the stamps of the log (N,).

    ``injected`` (N,) [Nm or N]: what was added to the controller's output; None for nothing.
    """

    controller: CascadeController
    reference: FloatArray
    injected: FloatArray | None = None


def recorded_controllers(bag: Bag, log: JointLog) -> dict[str, ControlledJoint]:
    """
    Return the joints whose cascade of loops and wanted position a bag holds.

    :raises BagError: if gains are recorded that cannot be read.
    """
    entries = read_controllers(bag)
    cascades = {name: entry for name, entry in entries.items() if entry['kind'] == CASCADE}
    recorded = bag.reference() if cascades else None
    if recorded is None:
        return {}
    added = bag.injected()
    wanted = _on_stamps(log, recorded)
    injected = {} if added is None else _on_stamps(log, added)
    joints = {}
    for name, entry in cascades.items():
        if name not in wanted or name not in log.names:
            continue
        if name in log.wraps:
            measured = log.q[:, log.names.index(name)]
            wanted[name] = near_turn(wanted[name], measured, log.wraps[name])
        gains = {key: float(value) for key, value in entry.items() if key != 'kind'}
        # A joint without such a signal has NaN throughout.
        own = injected.get(name, np.full(len(log), np.nan))
        joints[name] = ControlledJoint(
            CascadeController(**gains), wanted[name], own if np.isfinite(own).any() else None
        )
    return joints


def _on_stamps(
    log: JointLog, recorded: tuple[IndexArray, tuple[str, ...], FloatArray]
) -> dict[str, FloatArray]:
    """Return a signal of each joint on the stamps of a log (N,), NaN where it has none."""
    t_ns, names, values = recorded
    order = np.argsort(t_ns, kind='stable')
    at = order[np.clip(np.searchsorted(t_ns[order], log.t_ns), 0, len(t_ns) - 1)]
    same = t_ns[at] == log.t_ns
    return {
        name: np.where(same, column, np.nan)
        for name, column in zip(names, values[at].T, strict=True)
    }
