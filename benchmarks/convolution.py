# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
From which length on a low-pass is faster as a product of spectra than as a sum, side by side.

``python benchmarks/convolution.py``
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.ndimage import convolve1d
from scipy.signal import oaconvolve


def best(run: Callable[[], object], runs: int = 5) -> float:
    """Return the least of some durations [s]."""
    durations = []
    for _ in range(runs):
        begin = time.perf_counter()
        run()
        durations.append(time.perf_counter() - begin)
    return min(durations)


def main() -> None:
    """Print the ratio for two joints of 200 s at 1 kHz."""
    x = np.random.default_rng(0).standard_normal((200_000, 2))
    print('weights  sum [ms]  spectra [ms]  ratio')
    for count in (31, 61, 121, 201, 401, 801, 1601):
        weights = np.hanning(count)
        direct = best(lambda w=weights: convolve1d(x, w, axis=0, mode='nearest'))
        spectra = best(lambda w=weights: oaconvolve(x, w[:, None], mode='same', axes=0))
        ratio = direct / spectra
        print(f'{count:7d}  {1e3 * direct:8.1f}  {1e3 * spectra:12.1f}  {ratio:5.1f}')


if __name__ == '__main__':
    main()
