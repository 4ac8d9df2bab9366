# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How a diagnosis looks at data, and what it takes to name a cause."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class DiagnosisSettings:
    """
    Say how data are seen and when a cause is named.

    ``band`` [Hz]: both sides of the model are low-passed there; None for the frequency at which
    the noise of position, as inertial effort, reaches that of effort, at most ``widest_band``.
    ``tolerance``: relative error of a nominal parameter that is normal and no cause; within it
    parameters are refitted freely. ``blocks`` stretches of time make ``folds`` folds, each left
    out in turn. ``floor``: smallest held-out gain (share of the whitened residual's energy) that
    counts, times 1 + ln(points of the candidate's grid). A named cause is the whole of its axis
    unless a free curve explains more than ``axis_share`` of what both explain. ``most_causes``:
    largest number of named causes for each joint of the robot, and ``most_terms`` with their
    harmonics. ``moving_only``: whether friction where a joint stops or turns around is unknown in
    any case, and not only where the data contradict what the model says there.
    ``free_inertia``: joints whose rotor is refitted freely; ``unknown_armature``: joints of whose
    rotor nothing is known. ``own_friction``: whether each recording has Coulomb and viscous
    friction and a bias of its own. ``trust``: the tolerance of a group of nominal parameters
    (:mod:`sosml_friction.diagnosis.trust`) where it is another.
    """

    band: float | None = None
    widest_band: float = 60.0
    tolerance: float = 0.035
    blocks: int = 14
    folds: int = 7
    axis_share: float = 0.03
    floor: float = 0.005
    most_causes: int = 4
    most_terms: int = 10
    moving_only: bool = False
    free_inertia: tuple[str, ...] = ()
    unknown_armature: tuple[str, ...] = ()
    own_friction: bool = False
    trust: Mapping[str, float] = field(default_factory=dict)
