# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml info`` and ``sosml repair`` print of a bag."""

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType

from sosml_friction.bags.bag_information import constant_sentences
from sosml_friction.report.common.table import FittingTable, terminal_table


def information_blocks(
    information: Mapping[str, Any], table: bool = False
) -> Iterator[str | RenderableType]:
    """
    Return what a bag holds: sentences, then a table of its topics.

    :param table: whether it is a table, whose columns options name.
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
        yield from constant_sentences(motion)
        yield (
            f'joint_states: {motion["samples"]} samples at {motion["rate_hz"]:.4g} Hz, '
            f'{motion["gaps"]} gaps (longest step {motion["longest_step_s"]:.4g} s), '
            f'{motion["repeated_stamps"]} repeated and {motion["backward_stamps"]} backward stamps'
        )
    yield _topics(information['topics'])
    if motion is not None and not information['recovered']:
        own = [' with the options that name its columns'] if table else []
        own += [] if held else [' and --model ROBOT' if own else ' with --model ROBOT']
        yield f'Next: sosml fit {information["path"]}{"".join(own)}'


def repair_blocks(document: Mapping[str, Any]) -> Iterator[str | RenderableType]:
    """Return what was wrong with a bag, what was saved, what is lost, and its topics."""
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
    yield _topics(document['topics'])


def _topics(topics: Mapping[str, Any]) -> FittingTable:
    rows = [(x, own['type'] or 'unknown', str(own['messages'])) for x, own in topics.items()]
    return terminal_table({'topic': 'w', 'type': 'w', 'messages': 'n'}, rows)
