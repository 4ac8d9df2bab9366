# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Text files that a user names."""

from pathlib import Path

from sosml_friction.exceptions import ConfigurationError


def read_text(path: str | Path, what: str) -> str:
    """
    Return the text of a file in UTF-8.

    :param what: what the file is, for the error sentence.
    :raises ConfigurationError: if it cannot be read, or is no text.
    """
    try:
        return Path(path).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(
            f'{what} {path} cannot be read: give the path of a file'
        ) from error
