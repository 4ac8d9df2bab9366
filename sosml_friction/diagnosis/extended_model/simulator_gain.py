# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis is worth in the simulator whose model was put to the test."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class SimulatorGain:
    """
    Hold a simulator's errors before and after, by joint, and the file that it runs after.

    ``inverse``: rms of measured minus simulated effort, in the band, as a share of the measured
    effort [%]; ``forward``: rms of simulated minus measured position over ``horizon_s`` from the
    measured state, driven by the measured effort [rad or m]; pairs before and after, NaN where not
    known. ``friction``: its constants, by joint and parameter, before and after. ``on``: the
    recording; ``fitted_to``: whether the model was fitted to it. ``document``: the extended model
    in the simulator's form, ``file`` its name, ``left_out`` what of the model is not simulated,
    sentence parts.
    """

    simulator: str
    on: str
    fitted_to: bool
    inverse: Mapping[str, tuple[float, float]]
    forward: Mapping[str, tuple[float, float]]
    units: Mapping[str, str]
    friction: Mapping[str, Mapping[str, tuple[float, float]]]
    horizon_s: float
    file: str
    document: str
    left_out: Sequence[str] = field(default=())

    @property
    def sentence(self) -> str:
        """Return friction and the errors before and after."""
        levels = '; '.join(
            f'{name} {", ".join(f"{key} {_both(x)}" for key, x in own.items())}'
            for name, own in self.friction.items()
        )
        effort = ', '.join(
            f'{name} {_both(x)} %' for name, x in self.inverse.items() if math.isfinite(x[0])
        )
        place = ', '.join(
            f'{name} {_both((1e3 * x[0], 1e3 * x[1]))} m{self.units[name]}'
            for name, x in self.forward.items()
            if math.isfinite(x[0])
        )
        seen = ', to which the model was fitted (--holdout gives another)' * self.fitted_to
        said = f'Friction: {levels}. ' if levels else ''
        said += f'In {self.simulator}, on {self.on}{seen}: error of effort {effort}'
        if place:
            said += f', of a position simulated for {self.horizon_s:g} s {place}'
        if self.left_out:
            said += f'; not simulated: {", ".join(self.left_out)}'
        return f'{said}; {self.file} is that model.'

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``simulator`` of diagnosis.json."""
        return {
            'simulator': self.simulator,
            'on': self.on,
            'fitted_to': self.fitted_to,
            'file': self.file,
            'left_out': self.left_out,
            'joints': {
                name: {
                    'friction': self.friction.get(name, {}),
                    'inverse_before_percent': self.inverse[name][0],
                    'inverse_after_percent': self.inverse[name][1],
                    'forward_before': self.forward[name][0],
                    'forward_after': self.forward[name][1],
                    'unit': self.units[name],
                    'horizon_s': self.horizon_s,
                }
                for name in self.inverse
            },
        }


def _both(pair: tuple[float, float]) -> str:
    return f'{pair[0]:.3g} -> {pair[1]:.3g}'
