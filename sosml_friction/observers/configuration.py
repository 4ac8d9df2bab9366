# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which observers run, with which gains: written into every bag so that it can be run again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.registry import make_observer
from sosml_friction.yaml_text import parse_yaml

FORMAT = 'sosml_friction/observers/1'


@dataclass(frozen=True)
class ObserverConfiguration:
    """
    Hold everything that, with a recording and a model, determines the estimates.

    ``gains[observer][gain]`` has one value for each of ``joints``, in that order, and so has
    ``effort_hold``, where empty means ``start`` for all.
    """

    joints: tuple[str, ...]
    gains: Mapping[str, Mapping[str, Sequence[float]]]
    effort_hold: Sequence[str] = ()
    velocity_source: str = 'message'
    maximum_gap_s: float = 0.05

    def make_estimator(self, robot: Robot) -> FrictionEstimator:
        """
        Build the estimator.

        :raises ConfigurationError: if an observer is unknown, or gains or joints do not fit.
        """
        if self.joints != robot.names:
            raise ConfigurationError(
                f'the observers are configured for {", ".join(self.joints)} where the model has '
                f'{", ".join(robot.names)}: use one order of the same joints'
            )
        return FrictionEstimator(
            robot,
            [make_observer(name, gains) for name, gains in self.gains.items()],
            list(self.effort_hold) or 'start',
            self.velocity_source,
            self.maximum_gap_s,
        )

    def to_yaml(self) -> str:
        """Return the text that :func:`parse_configuration` reads, floats to the last bit."""
        document: dict[str, Any] = {
            'format': FORMAT,
            'joints': list(self.joints),
            'effort_hold': list(self.effort_hold),
            'velocity_source': self.velocity_source,
            'maximum_gap_s': self.maximum_gap_s,
            'gains': {
                name: {gain: [float(x) for x in values] for gain, values in gains.items()}
                for name, gains in self.gains.items()
            },
        }
        return yaml.safe_dump(document, sort_keys=False)


def parse_configuration(text: str, where: str) -> ObserverConfiguration:
    """
    Read what :meth:`ObserverConfiguration.to_yaml` wrote.

    :param where: the file or topic it came from, for the error sentence.
    :raises ConfigurationError: if it is not YAML of this format or lacks an entry.
    """
    document = parse_yaml(text, where)
    try:
        if not isinstance(document, dict) or document.get('format') != FORMAT:
            raise ConfigurationError(f'{where} has no entry format: {FORMAT}')
        lacking = [
            key
            for key in ('joints', 'gains', 'effort_hold', 'velocity_source', 'maximum_gap_s')
            if key not in document
        ]
        if lacking:
            raise ConfigurationError(
                f'{where} lacks {", ".join(lacking)}: write it as the observer node does'
            )
        return ObserverConfiguration(
            tuple(document['joints']),
            {str(name): dict(gains) for name, gains in document['gains'].items()},
            tuple(document['effort_hold']),
            document['velocity_source'],
            float(document['maximum_gap_s']),
        )
    except (AttributeError, TypeError, ValueError) as error:
        raise ConfigurationError(
            f'{where} is not an observer configuration: {" ".join(str(error).split())}'
        ) from error
