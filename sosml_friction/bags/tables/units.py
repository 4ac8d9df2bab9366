# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The units of columns: what one is in SI, and how it is written."""

import math
import re

#: Of a kilogram and a pound at standard gravity [N], of an inch and a foot [m].
_KGF, _LBF, _INCH, _FOOT = 9.80665, 4.4482216152605, 0.0254, 0.3048
#: How counts are written.
_COUNTS = 'counts count cts cnt lsb pulses pulse pls'

# By quantity and unit: its factor to SI, of time to ns, None where the mapping must give it, and
# how it is written: in small letters, without points, dashes and blanks. Letters alone count in
# brackets or behind a word only.
_TABLE: dict[str, dict[str, tuple[float | None, str]]] = {
    'time': {
        's': (10**9, 's sec secs second seconds'),
        'ms': (10**6, 'ms msec msecs millis millisec milliseconds'),
        'us': (10**3, 'us usec usecs micros microsec microseconds'),
        'ns': (1, 'ns nsec nsecs nanosec nanoseconds'),
        'min': (60 * 10**9, 'min mins minutes'),
        'h': (3600 * 10**9, 'h hr hrs hours'),
        'd': (86_400 * 10**9, 'd days'),
    },
    'position': {
        'rad': (1.0, 'rad rads radian radians'),
        'deg': (math.pi / 180.0, 'deg degs degree degrees °'),
        'turns': (2.0 * math.pi, 'turn turns rev revs revolution revolutions'),
        'm': (1.0, 'm meter meters metre metres'),
        'mm': (1e-3, 'mm'),
        'counts': (None, f'{_COUNTS} ticks tick inc incs'),
        'mrad': (1e-3, 'mrad'),
        'gon': (math.pi / 200.0, 'gon'),
        'arcmin': (math.pi / 10_800.0, 'arcmin'),
        'arcsec': (math.pi / 648_000.0, 'arcsec'),
        'cm': (1e-2, 'cm'),
        'um': (1e-6, 'um'),
        'in': (_INCH, 'in inch'),
    },
    'velocity': {
        'rad/s': (1.0, 'rad/s rads radps rads1'),
        'deg/s': (math.pi / 180.0, 'deg/s degs degps dps °/s'),
        'rpm': (math.pi / 30.0, 'rpm 1/min u/min rev/min r/min min1 turns/min'),
        'turns/s': (2.0 * math.pi, 'turns/s turn/s rev/s r/s rps'),
        'm/s': (1.0, 'm/s mps ms1'),
        'mm/s': (1e-3, 'mm/s mmps'),
        'counts/s': (None, 'counts/s count/s ticks/s inc/s cts/s cnt/s'),
        'mrad/s': (1e-3, 'mrad/s'),
        'cm/s': (1e-2, 'cm/s'),
        'm/min': (1.0 / 60.0, 'm/min'),
        'mm/min': (1e-3 / 60.0, 'mm/min'),
        'in/s': (_INCH, 'in/s'),
    },
    'effort': {
        'Nm': (1.0, 'nm newtonmeter newtonmeters'),
        'mNm': (1e-3, 'mnm'),
        'N': (1.0, 'n newton newtons'),
        'kN': (1e3, 'kn'),
        'A': (None, 'a amp amps ampere amperes arms'),
        'mA': (None, 'ma'),
        'V': (None, 'v volt volts'),
        'mV': (None, 'mv'),
        'percent': (None, '% percent pct'),
        'counts': (None, _COUNTS),
        'cNm': (1e-2, 'cnm ncm'),
        'kNm': (1e3, 'knm'),
        'kgf.m': (_KGF, 'kgfm kgm'),
        'kgf.cm': (1e-2 * _KGF, 'kgfcm kgcm'),
        'gf.cm': (1e-5 * _KGF, 'gfcm gcm'),
        'lbf.ft': (_LBF * _FOOT, 'lbfft lbft ftlbf ftlb ftlbs'),
        'lbf.in': (_LBF * _INCH, 'lbfin lbin inlbf inlb inlbs'),
        'ozf.in': (_LBF * _INCH / 16.0, 'ozfin ozin inozf inoz'),
        'mN': (1e-3, 'mn'),
        'kgf': (_KGF, 'kgf'),
        'lbf': (_LBF, 'lbf'),
    },
    'temperature': {'degC': (1.0, 'c degc °c celsius'), 'K': (1.0, 'k kelvin')},
    'injected': {'Nm': (1.0, 'nm'), 'N': (1.0, 'n'), 'A': (None, 'a'), 'V': (None, 'v')},
}
#: Factors to SI by unit, by quantity.
UNITS: dict[str, dict[str, float | None]] = {
    quantity: {unit: factor for unit, (factor, _) in _TABLE[quantity].items()}
    for quantity in ('position', 'velocity', 'effort', 'temperature')
}
#: What one is in nanoseconds.
TIME_UNITS = {unit: int(factor or 0) for unit, (factor, _) in _TABLE['time'].items()}
#: Unit by how it is written, by quantity.
WRITTEN = {
    quantity: {word: unit for unit, (_, words) in units.items() for word in words.split()}
    for quantity, units in _TABLE.items()
}
#: All that a unit is written as.
SPELLINGS = frozenset(word for words in WRITTEN.values() for word in words)
KELVIN_OFFSET = -273.15
LINEAR_UNITS = frozenset((
    'm', 'mm', 'cm', 'um', 'in', 'm/s', 'mm/s', 'cm/s', 'm/min', 'mm/min', 'in/s',
    'N', 'kN', 'mN', 'kgf', 'lbf',
))  # fmt: skip
ANGULAR_UNITS = frozenset(
    unit
    for quantity in ('position', 'velocity', 'effort')
    for unit, factor in UNITS[quantity].items()
    if factor is not None and unit not in LINEAR_UNITS
)


def known_unit(text: str, quantity: str) -> str:
    """Return the unit of a quantity however it is written, '' if it is none that is known."""
    units = _TABLE[quantity]
    return text if text in units else WRITTEN[quantity].get(plain_unit(text), '')


def known_units(quantity: str) -> str:
    """Return the units of a quantity, for a sentence."""
    return ', '.join(_TABLE[quantity])


#: Signs that look alike: of micro, and of degrees.
_ALIKE = str.maketrans({'µ': 'u', 'μ': 'u', 'º': '°', '˚': '°'})


def plain_unit(text: str) -> str:
    """Return a unit without what it may be written with: N·m and N-m are Nm, deg/sec is deg/s."""
    bare = re.sub(r'[\s·⋅.*_-]', '', text.lower()).translate(_ALIKE)
    return re.sub('/sec(ond)?$', '/s', bare)
