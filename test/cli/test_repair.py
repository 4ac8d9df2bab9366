# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml repair``: what is whole of a damaged bag, in a new one."""

import shutil
import struct

import pytest
from mcap.opcode import Opcode
from slider_bags import checked

from sosml_friction.bags.bag import Bag


@pytest.fixture
def damaged(slider_bag, tmp_path):
    """Return a copy of a bag, a way to change its file, and first byte and end of its chunks."""
    folder = tmp_path / slider_bag.name
    shutil.copytree(slider_bag, folder)
    path = next(folder.glob('*.mcap'))
    data, chunks, position = bytearray(path.read_bytes()), [], 8
    while position < len(data) - 8:
        opcode, length = struct.unpack_from('<BQ', data, position)
        if opcode == Opcode.CHUNK:
            chunks.append((position, position + 9 + length))
        position += 9 + length

    def change(place, bit=1):
        data[place] ^= bit
        path.write_bytes(data)

    return folder, change, chunks


def test_a_flipped_bit_of_a_frame_loses_nothing(sosml, slider_bag, damaged, tmp_path):
    folder, change, chunks = damaged
    change(chunks[3][0], 0x40)
    whole = list(Bag.open(slider_bag).timeline())
    bag = Bag.open(folder)
    assert bag.recovered
    assert bag.messages_read < len(whole)
    code, out, _ = sosml('repair', folder, '--out', tmp_path / 'saved', '--json')
    document = checked(out, 'repair')
    assert (code, document['saved'], document['lost']) == (0, len(whole), 0)
    assert document['read_before'] == bag.messages_read
    saved = Bag.open(tmp_path / 'saved')
    assert not saved.recovered
    assert list(saved.timeline()) == whole
    assert saved.tags == Bag.open(slider_bag).tags


def test_what_is_behind_a_damaged_chunk_is_saved(sosml, slider_bag, damaged, tmp_path):
    folder, change, chunks = damaged
    change((chunks[3][0] + chunks[3][1]) // 2)
    whole = list(Bag.open(slider_bag).timeline())
    read = Bag.open(folder).messages_read
    code, out, _ = sosml('repair', folder, '--out', tmp_path / 'saved')
    assert code == 0
    found = list(Bag.open(tmp_path / 'saved').timeline())
    assert read < len(found) < len(whole)
    assert set(found) < set(whole)
    assert f'Saved {len(found)} messages' in out
    assert f'lost {len(whole) - len(found)}' in out
    assert found[-1] == whole[-1]


def test_a_bag_without_an_end_says_that_nobody_knows_what_is_lost(sosml, slider_bag, tmp_path):
    cut = tmp_path / 'cut.mcap'
    content = next(slider_bag.glob('*.mcap')).read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    out = sosml('repair', cut, '--out', tmp_path / 'saved')[1]
    assert 'how many are lost is not known' in out
    assert Bag.open(tmp_path / 'saved').messages_read == Bag.open(cut).messages_read


def test_a_whole_bag_is_left_alone(sosml, refused, slider_bag, damaged, tmp_path):
    document = checked(sosml('repair', slider_bag, '--json')[1], 'repair')
    assert document['output'] is None
    assert document['lost'] == 0
    folder, change, chunks = damaged
    change(chunks[3][0], 0x40)
    assert 'is not overwritten' in refused('repair', folder, '--out', folder)


def test_the_summary_finds_a_chunk_of_damaged_length(sosml, slider_bag, damaged, tmp_path):
    folder, change, chunks = damaged
    # The highest byte of the length: further than any file goes.
    change(chunks[3][0] + 8, 0x80)
    code, out, _ = sosml('repair', folder, '--out', tmp_path / 'saved', '--json')
    whole = list(Bag.open(slider_bag).timeline())
    assert (code, checked(out, 'repair')['lost']) == (0, 0)
    assert list(Bag.open(tmp_path / 'saved').timeline()) == whole
