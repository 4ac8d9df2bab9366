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


def compiled(text: str, folder: Path | None = None) -> Any:
    """
    Return the MjModel of a document, MJCF or URDF.

    :param folder: where included files and meshes are looked for, None for the current one.
    :raises ConfigurationError: if MuJoCo refuses it, with what it says.
    """
    mujoco = engine()
    try:
        spec = mujoco.MjSpec.from_string(text)
        if folder is not None:
            spec.modelfiledir = str(folder.resolve())
        return spec.compile()
    except (ValueError, RuntimeError) as error:
        raise ConfigurationError(
            f'MuJoCo cannot read the model: {" ".join(str(error).split())}'
        ) from error


def joint_id(model: Any, name: str) -> int:
    """Return the number of a joint in an MjModel, -1 where it has none of that name."""
    mujoco = engine()
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name))
