# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Joint friction without a torque sensor: observe it, identify it, diagnose the model.

::

    import sosml_friction as sf

    log = sf.load('recording.csv', 'mapping.yaml')  # or a bag
    model = sf.Model.read('robot')
    print(sf.fit(log, model).summary())
    print(sf.diagnose(log, model).summary())

Everything is loaded when it is first used, so that the import itself takes no time.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sosml_friction.api.diagnose import Diagnosis, diagnose
    from sosml_friction.api.fit import Fit, fit
    from sosml_friction.api.load import load
    from sosml_friction.api.model import Model
    from sosml_friction.api.observe import Observation, observe
    from sosml_friction.api.simulate import Simulation, simulate
    from sosml_friction.api.term_fit import Terms
    from sosml_friction.bags.joint_log import JointLog
    from sosml_friction.exceptions import SosmlFrictionError

#: setup.py reads it here; package.xml repeats it, and a test compares them.
__version__ = '0.1.0'

__all__ = [
    'Diagnosis',
    'Fit',
    'JointLog',
    'Model',
    'Observation',
    'Simulation',
    'SosmlFrictionError',
    'Terms',
    '__version__',
    'diagnose',
    'fit',
    'load',
    'observe',
    'simulate',
]

_HOMES = {
    'Diagnosis': 'api.diagnose',
    'Fit': 'api.fit',
    'JointLog': 'bags.joint_log',
    'Model': 'api.model',
    'Observation': 'api.observe',
    'Simulation': 'api.simulate',
    'SosmlFrictionError': 'exceptions',
    'Terms': 'api.term_fit',
    'diagnose': 'api.diagnose',
    'fit': 'api.fit',
    'load': 'api.load',
    'observe': 'api.observe',
    'simulate': 'api.simulate',
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    value = getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
