# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo itself, an optional dependency: the one place where it is imported."""

from pathlib import Path
from typing import Any

from sosml_friction.exceptions import ConfigurationError


def engine() -> Any:
    """
    Return the module ``mujoco``.

    :raises ConfigurationError: if it is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise ConfigurationError(
            f'MuJoCo is not here ({error}): install it with pip install "sosml_friction[mujoco]"'
        ) from error
    return mujoco


def compiled(source: str | Path) -> Any:
    """
    Return the MjModel of a document, MJCF or URDF.

    :param source: its text, or the file, beside which what it includes is looked for.
    :raises ConfigurationError: if the file cannot be read or MuJoCo refuses it, with what it says.
    """
    return spec_of(source)[1]


def spec_of(source: str | Path) -> tuple[Any, Any]:
    """Return the MjSpec and the MjModel of a document; as :func:`compiled`."""
    mujoco = engine()
    if isinstance(source, Path) and not source.is_file():
        raise ConfigurationError(f'MJCF {source} cannot be read: give the path of a file')
    try:
        if isinstance(source, Path):
            spec = mujoco.MjSpec.from_file(str(source))
        else:
            spec = mujoco.MjSpec.from_string(source)
        return spec, spec.compile()
    except (ValueError, RuntimeError) as error:
        raise ConfigurationError(
            f'MuJoCo cannot read the model: {" ".join(str(error).split())}'
        ) from error


def joint_id(model: Any, name: str) -> int:
    """Return the number of a joint in an MjModel, -1 where it has none of that name."""
    mujoco = engine()
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name))
