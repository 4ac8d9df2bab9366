# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From a bag to friction parameters and the model folder: what the tool and the node both do."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorded_robot import ModelSource, read_recorded_robot
from sosml_friction.bags.source import bag_source
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis, analyse_log
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.simulation.recorded.controlled_joint import recorded_controllers


def analyse_bag(
    path: str | Path,
    model: ModelSource = None,
    urdf: str | Path | None = None,
    settings: FitSettings | None = None,
    bandwidth: float | None = None,
    namespace: str | None = None,
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
    require: bool = True,
    command: str = '',
    compared: BodyComparison | None = None,
) -> BagAnalysis:
    """
    Run the observers over a bag and fit friction to what they say.

    The bag's own robot_description, model_description and observer_configuration are used unless
    the caller gives others; a bag without observer configuration gets one by recipe. ``model``,
    ``urdf`` and ``namespace`` are those of
    :func:`~sosml_friction.bags.recorded_robot.read_recorded_robot`, the others those of
    :func:`~sosml_friction.identification.log_analysis.analyse_log`.

    :raises BagError: if the bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, joints disagree, or an observer is
        unknown or has no gains by bandwidth.
    :raises DataError: if effort is missing or the motion cannot be fitted.
    """
    progress('reading the bag')
    recorded = read_recorded_robot(path, model, urdf, namespace)
    return analyse_log(
        recorded.log,
        recorded.nominal,
        settings,
        bandwidth,
        observers,
        effort_hold,
        recorded_configuration(recorded.bag, path),
        partial(recorded_controllers, recorded.bag),
        bag_source(path, recorded.bag),
        progress,
        require,
        command,
        compared,
    )


def recorded_configuration(bag: Bag, path: str | Path) -> ObserverConfiguration | None:
    """
    Return the observers that ran while a bag was recorded, None if it does not say.

    :param path: what to call the bag in an error.
    :raises ConfigurationError: if its observer_configuration cannot be read.
    """
    text = bag.text('observer_configuration')
    if text is None:
        return None
    return parse_configuration(text, f'observer_configuration of {path}')
