# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml model`` says of a model that it made."""

import math
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from rich.console import RenderableType

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.report.common.table import terminal_table

FORMAT = 'sosml_friction/model_made/1'
#: How the entry command of a folder begins that may be made anew.
_OURS = 'sosml model '
#: Where the provenance has the SHA-256 of each file as it was written.
_HASHES = 'sha256'


def check_model_folder(folder: Path, force: bool = False) -> None:
    """
    Refuse a folder that holds something else than a model as ``sosml model`` made it.

    :raises ConfigurationError: with the folder, and the files that were changed.
    """
    try:
        if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
            return
        model = read_model(folder)
        is_ours = str(model.provenance.get('command', '')).startswith(_OURS)
        changed = _changed(folder, model)
    except (OSError, ConfigurationError):
        is_ours = False
    if not is_ours:
        raise ConfigurationError(
            f'{folder} exists and was not made by sosml model, so it is not overwritten: choose '
            'another place with --out'
        )
    if changed and not force:
        raise ConfigurationError(
            f'{" and ".join(changed)} in {folder} changed since sosml model made the folder, so '
            'it is not overwritten: choose another place with --out, or say --force'
        )


def with_hashes(model: RobotModelFile) -> RobotModelFile:
    """Return the model with what its files are known by, in its provenance."""
    return replace(model, provenance={**model.provenance, _HASHES: _hashes(model)})


def _hashes(model: RobotModelFile) -> dict[str, str]:
    own = {key: value for key, value in model.provenance.items() if key != _HASHES}
    texts = {
        'model.yaml': replace(model, provenance=own).to_yaml(),
        'robot.urdf': '\n'.join((model.urdf or '').splitlines()),
    }
    return {name: sha256(text.encode()).hexdigest() for name, text in texts.items()}


def _changed(folder: Path, model: RobotModelFile) -> list[str]:
    """Return the files of a model that are not as they were written, comments included."""
    known = model.provenance.get(_HASHES, {})
    changed = [name for name, own in _hashes(model).items() if known.get(name) != own]
    rewritten = (folder / 'model.yaml').read_text(encoding='utf-8') != model.to_yaml()
    return list(dict.fromkeys([*(['model.yaml'] if rewritten else []), *changed]))


def model_document(model: RobotModelFile, robot: Robot) -> dict[str, Any]:
    """Return the object of ``sosml model --json``; what is not known is null."""
    missing = model.provenance.get('not_known', {})
    return {
        'format': FORMAT,
        'name': model.name,
        'joints': {
            name: {
                'effort_unit': unit,
                'armature': joint.armature.to_dict(),
                'lower_limit': _known(limit.lower),
                'upper_limit': _known(limit.upper),
                'velocity_limit': _known(limit.velocity),
                'effort_limit': _known(limit.effort),
                'not_known': dict(missing.get(name, {})),
            }
            for (name, joint), unit, limit in zip(
                model.joints.items(), robot.effort_units, robot.limits, strict=True
            )
        },
        'held': dict(robot.held),
        'followers': {name: mimic.leader for name, mimic in robot.followers.items()},
        'assumed': list(model.provenance.get('assumed', [])),
    }


def model_sentences(model: RobotModelFile, robot: Robot, folder: Path) -> list[str]:
    """Return what was made, what was assumed, and what is left to be stated."""
    said = [f'{folder} has the model {model.name}: robot.urdf and model.yaml.']
    said += [f'Assumed: {text}.' for text in model.provenance.get('assumed', [])]
    for name, mimic in robot.followers.items():
        said.append(f'Joint {name} follows {mimic.leader}, with its body.')
    said += [f'{text[:1].upper()}{text[1:]}.' for text in robot.remarks]
    if model.unknown_armature:
        said.append(
            f'Not known: the armature of {", ".join(model.unknown_armature)}. sosml fit finds it '
            f'from a recording; or write it into {folder / "model.yaml"}, or state it with '
            '--armature where the model is used; 0 if the bodies of the URDF have it.'
        )
    return said


def model_table(model: RobotModelFile, robot: Robot) -> RenderableType:
    """Return the joints, with what the URDF leaves open."""
    missing = model.provenance.get('not_known', {})
    rows = []
    for (name, joint), unit in zip(model.joints.items(), robot.effort_units, strict=True):
        rotor = joint.armature
        known = 'not known' if math.isnan(rotor.value) else f'{rotor.value:g} {rotor.unit}'
        # The name of what is missing, and of a body the link.
        open_ = '; '.join(f'{key}: {why}' for key, why in missing.get(name, {}).items())
        rows.append((name, unit, known, open_ or 'friction: sosml fit finds it from a recording'))
    return terminal_table({'joint': 'w', 'effort': '', 'armature': 'w', 'not known': ''}, rows)


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
