# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A node that can end its own program."""

import difflib

from rclpy.node import Node

from sosml_friction.exceptions import ConfigurationError


class ProgramNode(Node):
    """
    Let a callback end the program :func:`~sosml_friction.nodes.run.run_node` runs.

    Raising would do it too, but the EventsExecutor prints the traceback of whatever a callback
    raises, and a user is owed a sentence.
    """

    outcome: BaseException | None = None

    def refuse_unknown_parameters(self) -> None:
        """
        Refuse parameters that were given but are none of the node's: ROS would not say a word.

        :raises ConfigurationError: naming the parameter and the one that may have been meant.
        """
        for name in getattr(self, '_parameter_overrides', {}):
            if not self.has_parameter(name):
                known = [known for known in self._parameters if '.' not in known or '.' in name]
                close = difflib.get_close_matches(name, known, 1)
                meant = f'did you mean {close[0]}?' if close else 'see docs/parameters.md'
                raise ConfigurationError(f'{self.get_name()} has no parameter {name}: {meant}')

    def end(self, outcome: BaseException | None = None) -> None:
        """
        End the program after the present callback.

        :param outcome: why, as if it had been raised; None for a good end.
        """
        if self.outcome is None:
            self.outcome = outcome or SystemExit(0)
