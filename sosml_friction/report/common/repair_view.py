# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml repair`` prints."""

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from sosml_friction.report.common.table import terminal_table


def repair_blocks(document: Mapping[str, Any]) -> Iterator[str | RenderableType]:
    """
    Return what was wrong with a bag, what was saved and what is lost, and a table of its topics.

    :param document: of :func:`~sosml_friction.bags.repair.repair_bag`.
    """
    if document['output'] is None:
        yield f'{document["path"]} is whole: nothing is written'
        return
    if document['damage']:
        yield f'Damaged: {document["damage"]}'
    lost = document['lost']
    yield (
        f'Saved {document["saved"]} messages in {document["output"]} ({document["read_before"]} '
        'are read without repair); '
        + ('how many are lost is not known' if lost is None else f'lost {lost}')
    )
    if document['left_out']:
        yield f'Left out, as not of ROS 2: {", ".join(document["left_out"])}'
    rows = [
        (name, topic['type'] or 'unknown', str(topic['messages']))
        for name, topic in document['topics'].items()
    ]
    yield terminal_table({'topic': '', 'type': '', 'messages': 'n'}, rows)
