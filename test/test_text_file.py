# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Text files that a user names are read, or refused in one sentence."""

import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.text_file import read_text


def test_text_in_utf_8_is_read(tmp_path):
    path = tmp_path / 'robot.urdf'
    path.write_bytes('Fußgelenk'.encode())
    assert read_text(path, 'URDF') == 'Fußgelenk'


@pytest.mark.parametrize('content', [None, b'\xff\xfe\x00'])
def test_what_is_not_there_or_no_text_is_refused_by_name(tmp_path, content):
    path = tmp_path / 'robot.urdf'
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigurationError, match=r'^URDF .*robot.urdf cannot be read: give'):
        read_text(path, 'URDF')
