# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml info`` prints of a bag."""

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from sosml_friction.report.common.table import terminal_table


def information_blocks(information: Mapping[str, Any]) -> Iterator[str | RenderableType]:
    """
    Return what a bag holds: sentences, then a table of its topics.

    :param information: of :func:`~sosml_friction.bags.bag_information.bag_information`.
    """
    yield (
        f'{information["path"]}: {information["messages"]} messages over '
        f'{information["duration_s"]:.2f} s'
    )
    if information['recovered']:
        yield f'Damaged: {information["recovery"]}'
        yield 'sosml repair saves what is whole behind the damage too'
    held = [name for name, there in information['descriptions'].items() if there]
    lacking = [name for name, there in information['descriptions'].items() if not there]
    yield f'Holds {", ".join(held) or "no description"}' + (
        f'; not {", ".join(lacking)}' if lacking else ''
    )
    if information['tags']:
        yield 'Conditions: ' + ', '.join(f'{k}={v}' for k, v in information['tags'].items())
    motion = information['joint_states']
    if motion is None:
        yield f'No motion: {information["joint_states_problem"]}'
    else:
        for joint, what in motion['measured'].items():
            yield f'Joint {joint}: {", ".join(what) or "nothing measured"}'
        yield (
            f'joint_states: {motion["samples"]} samples at {motion["rate_hz"]:.4g} Hz, '
            f'{motion["gaps"]} gaps (longest step {motion["longest_step_s"]:.4g} s), '
            f'{motion["repeated_stamps"]} repeated and {motion["backward_stamps"]} backward stamps'
        )
    rows = [
        (name, topic['type'] or 'unknown', str(topic['messages']))
        for name, topic in information['topics'].items()
    ]
    yield terminal_table({'topic': 'w', 'type': 'w', 'messages': 'n'}, rows)
    if motion is not None and not information['recovered']:
        yield f'Next: sosml fit {information["path"]}'
