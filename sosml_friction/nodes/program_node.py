# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A node that can end its own program."""

from __future__ import annotations

from rclpy.node import Node


class ProgramNode(Node):
    """
    Let a callback end the program :func:`~sosml_friction.nodes.run.run_node` runs.

    Raising would do it too, but the EventsExecutor prints the traceback of whatever a callback
    raises, and a user is owed a sentence.
    """

    outcome: BaseException | None = None

    def end(self, outcome: BaseException | None = None) -> None:
        """
        End the program after the present callback.

        :param outcome: why, as if it had been raised; None for a good end.
        """
        if self.outcome is None:
            self.outcome = outcome or SystemExit(0)
