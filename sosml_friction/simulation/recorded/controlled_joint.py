# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint whose controller and wanted position a recording holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import CASCADE, read_controllers
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.simulation.cascade_loop import CascadeController

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ControlledJoint:
    """Hold a joint's controller and its wanted position on the stamps of the log (N,)."""

    controller: CascadeController
    reference: FloatArray


def recorded_controllers(bag: Bag, log: JointLog) -> dict[str, ControlledJoint]:
    """
    Return the joints whose cascade of loops and wanted position a bag holds.

    :param log: the motion of the bag; wanted positions are taken by its stamps.
    :raises BagError: if gains are recorded that cannot be read.
    """
    entries = read_controllers(bag)
    cascades = {name: entry for name, entry in entries.items() if entry['kind'] == CASCADE}
    recorded = bag.reference() if cascades else None
    if recorded is None:
        return {}
    t_ns, names, wanted = recorded
    order = np.argsort(t_ns, kind='stable')
    at = order[np.clip(np.searchsorted(t_ns[order], log.t_ns), 0, len(t_ns) - 1)]
    same = t_ns[at] == log.t_ns
    joints = {}
    for name, entry in cascades.items():
        if name not in names or name not in log.names:
            continue
        gains = {key: float(value) for key, value in entry.items() if key != 'kind'}
        controller = CascadeController(**gains)
        reference = np.where(same, wanted[at, names.index(name)], np.nan)
        joints[name] = ControlledJoint(controller, reference)
    return joints
