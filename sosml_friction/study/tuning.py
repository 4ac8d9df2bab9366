# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Search for the best point with an exact number of evaluations, several problems at once."""

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from sosml_friction.arrays import FloatArray

#: Size of the first simplex, and of those after the search has come to rest, of the unit cube.
_SIMPLEX, _SMALLER = 0.1, 0.03


class _SpentError(Exception):
    """The evaluations are used up."""


class _Together:
    """
    Let problems in threads of their own share one evaluation.

    A run of an observer serves all its joints, whose gains are searched independently: each thread
    brings the point of its joint, the last to come evaluates them all.
    """

    def __init__(
        self, objective: Callable[[FloatArray], FloatArray], problems: int, dimensions: int
    ) -> None:
        self._objective = objective
        self._points = np.empty((problems, dimensions))
        self._values = np.empty(problems)
        self._barrier = threading.Barrier(problems, self._evaluate)

    def _evaluate(self) -> None:
        self._values[:] = self._objective(self._points.copy())

    def value(self, problem: int, point: FloatArray) -> float:
        self._points[problem] = point
        self._barrier.wait()
        return float(self._values[problem])

    def abort(self) -> None:
        self._barrier.abort()


def minimise(
    objective: Callable[[FloatArray], FloatArray], problems: int, dimensions: int, evaluations: int
) -> tuple[FloatArray, FloatArray]:
    """
    Minimise functions over the unit cube, each with exactly ``evaluations`` evaluations.

    The first half, rounded down to a power of two, is a Sobol sequence (the same for every problem
    of that dimension, its first point the middle); from the best of it goes a Nelder-Mead search
    within the cube, started again with a smaller simplex about its best point where it comes to
    rest early.

    :param objective: takes points (problems, dimensions), returns values (problems,); a value
        depends on the point of its problem alone. Not a number counts as infinite.
    :return: best points (problems, dimensions) and their values (problems,).
    """
    together = _Together(objective, problems, dimensions)
    with ThreadPoolExecutor(problems) as threads:
        try:
            found = [
                threads.submit(_search, together, problem, dimensions, evaluations)
                for problem in range(problems)
            ]
            # The one that failed first, not those it left waiting.
            errors = [e for f in found if (e := f.exception()) is not None]
            for error in sorted(errors, key=lambda e: isinstance(e, threading.BrokenBarrierError)):
                raise error
        except BaseException:
            together.abort()
            raise
    points, values = zip(*(f.result() for f in found), strict=True)
    return np.array(points), np.array(values)


def _search(
    together: _Together, problem: int, dimensions: int, evaluations: int
) -> tuple[FloatArray, float]:
    best, best_value, left = np.full(dimensions, 0.5), np.inf, evaluations

    def value(point: FloatArray) -> float:
        nonlocal best, best_value, left
        if left == 0:
            raise _SpentError
        left -= 1
        result = together.value(problem, point)
        if not np.isfinite(result):
            result = np.finfo(float).max
        if result < best_value:
            best, best_value = point.copy(), result
        return result

    try:
        first = 2 ** int(np.log2(max(evaluations // 2, 1)))
        # A Sobol sequence begins in a corner, which is moved to the middle of the cube.
        for point in (qmc.Sobol(dimensions, scramble=False).random(first) + 0.5) % 1.0:
            value(point)
        size = _SIMPLEX
        while True:
            # Within the cube, one corner at the best point.
            steps = np.diag(np.where(best + size <= 1.0, size, -size))
            minimize(
                value,
                best,
                method='Nelder-Mead',
                bounds=[(0.0, 1.0)] * dimensions,
                options={
                    'initial_simplex': np.vstack([best, best + steps]),
                    'maxfev': evaluations + 1,
                    'xatol': 1e-3,
                    'fatol': np.inf,
                },
            )
            size = _SMALLER
    except _SpentError:
        return best, best_value
