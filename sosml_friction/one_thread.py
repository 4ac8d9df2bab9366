# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Linear algebra in one thread, whatever the process is set to."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

_Given = ParamSpec('_Given')
_Result = TypeVar('_Result')


def in_one_thread(function: Callable[_Given, _Result]) -> Callable[_Given, _Result]:
    """
    Keep BLAS to one thread while ``function`` runs.

    Its threads gain nothing on problems of this size; and where another program wants the
    processors they wait for each other, and the same fit takes ten times as long
    (``fit, threads`` of benchmarks/long_recordings.py).
    """

    @wraps(function)
    def limited(*args: _Given.args, **kwargs: _Given.kwargs) -> _Result:
        # It has a BLAS of its own, which cannot be limited before it is there.
        import scipy.linalg  # noqa: F401

        with threadpool_limits(limits=1, user_api='blas'):
            return function(*args, **kwargs)

    return limited
