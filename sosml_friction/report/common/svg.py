# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Figures as vector graphics inside a page.

Matplotlib's SVG, made small and put on the paper of the page: its greys become mixtures of the
page's ink and paper, so that a dark page has a dark figure; text is text, in the page's font.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: More marks than this in a row are points of a cloud, which need no elements of their own.
_CLOUD = 40
#: Colours whose channels differ by less than this are greys.
_GREY = 32
#: Many marks of one shape and style in a row.
_PLACE = r'x="[^"]+" y="[^"]+"'
_MARKS = (
    rf'(<use xlink:href="#(\w+)" {_PLACE} style="([^"]*)"/>'
    rf'(?:\s*<use xlink:href="#\2" {_PLACE} style="\3"/>){{{_CLOUD},}})'
)
_FINE = re.compile(r'(-?\d+\.\d\d)\d+')
_SETTINGS: dict[Any, Any] = {'svg.fonttype': 'none', 'svg.hashsalt': 'sosml_friction'}


def to_svg(figure: Figure, caption: str = '', themed: bool = True) -> str:
    """
    Return the figure as an ``<svg>`` element that needs nothing else.

    Its attribute ``data-axes`` has the place and the limits of each axes, for the page's script.

    :param caption: what it shows, for those who do not see it.
    :param themed: whether its colours follow the page; else it keeps them, on white.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    stream = BytesIO()
    with rc_context(_SETTINGS):
        FigureCanvasSVG(figure).print_svg(stream, metadata={'Date': None})
    text = stream.getvalue().decode()
    text = text[text.index('<svg') :]
    text = re.sub(r' *<metadata>.*?</metadata>', '', text, flags=re.DOTALL)
    text = re.sub(r'<g id="([A-Za-z]+)[\w.]*">', _group, text)
    text = re.sub(_MARKS, lambda match: _cloud(match, text), text)
    # Places to a hundredth of a point; what is written, as the numbers of an axis, stays.
    text = re.sub(r'<[^>]*>', lambda tag: re.sub(_FINE, r'\1', tag[0]), text)
    text = re.sub(r'(?<= d=")[^"]+', _line, text)
    text = re.sub(r'; font-family: [^;"]*', '', text)
    colours: dict[str, str] = {}
    if themed:
        text = re.sub(r'#[0-9a-f]{6}\b(?=[;"])', lambda match: _colour(match[0], colours), text)
    text = re.sub(r'\s*\n\s*', '\n', text)
    width, height = 72.0 * figure.get_size_inches()
    told = escape(json.dumps([_axes(axes, width, height) for axes in figure.axes]))
    shades = ''.join(f';--{name}:{value}' for name, value in colours.items())
    least = min(0.8 * width, 600.0)
    head = (
        f'<svg class="{"themed" if themed else "plain"}" role="img" '
        f'aria-label="{escape(caption)}" style="min-width:{least:.0f}px{shades}" '
        f'viewBox="0 0 {width:g} {height:g}" data-axes="{told}" '
        'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
    )
    return re.sub(r'<svg[^>]*>', lambda _: head, text, count=1).strip()


def _group(match: re.Match[str]) -> str:
    """Keep what the script looks for; other names would be there once for each figure."""
    kind = {'axes': 'axes', 'legend': 'legend', 'matplotlib': 'axis'}.get(match[1].lower())
    return f'<g class="{kind}">' if kind else '<g>'


def _cloud(match: re.Match[str], text: str) -> str:
    """Return many equal round marks as one path of dots, others as they are."""
    marks, name, style = match[1], match[2], match[3]
    shape = re.search(rf'<path id="{name}" d="M 0 (\d[\d.]*) ?\s*C', text)
    fill = re.search(r'fill: (#\w+)', style)
    if shape is None or fill is None:
        return marks
    opacity = re.search(r'(?:fill-)?opacity: ([\d.]+)', style)
    points = [(float(x), float(y)) for x, y in re.findall(r'x="([^"]+)" y="([^"]+)"', marks)]
    pale = f'; stroke-opacity: {opacity[1]}' if opacity else ''
    return (
        f'<path d="{_steps(points, "m", "h0")}" style="fill: none; stroke: {fill[1]}; '
        f'stroke-width: {2.0 * float(shape[1]):g}; stroke-linecap: round{pale}"/>'
    )


def _line(match: re.Match[str]) -> str:
    """Return a long line of straight pieces in steps of a tenth of a point."""
    if match[0].count('L') < _CLOUD or re.search(r'[^MLz\d\s.-]', match[0]):
        return ' '.join(match[0].split())
    pieces = [
        [(float(x), float(y)) for x, y in re.findall(r'(-?[\d.]+) (-?[\d.]+)', piece)]
        for piece in match[0].split('M')[1:]
    ]
    end = 'z' if match[0].rstrip().endswith('z') else ''
    return ''.join(_steps(piece, 'l') for piece in pieces) + end


def _steps(points: Sequence[tuple[float, float]], step: str, after: str = '') -> str:
    """Return points as a path of one absolute move and steps, exact to a tenth of a point."""
    tenths = [(round(10.0 * x), round(10.0 * y)) for x, y in points]
    (x, y), *rest = tenths
    text = f'M{x / 10:g} {y / 10:g}{after}'
    for u, v in rest:
        # A step to where it is draws a dot, and nothing of a line.
        if after or (u, v) != (x, y):
            text += f'{step}{(u - x) / 10:g} {(v - y) / 10:g}{after}'
            x, y = u, v
    return text


def _colour(colour: str, known: dict[str, str]) -> str:
    """
    Return a name for a colour, and remember what it stands for on the page.

    A grey is a mixture of ink and paper, another colour has as much ink in it as the page wants.
    """
    channels = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    if max(channels) - min(channels) < _GREY:
        ink = round(100.0 - sum(channels) / 7.65)
        name, value = f'g{ink}', f'var(--ink) {ink}%,var(--paper)'
    else:
        name, value = f'c{colour[1:]}', f'{colour} var(--hue),var(--ink)'
    known[name] = f'color-mix(in srgb,{value})'
    return f'var(--{name})'


def _axes(axes: Axes, width: float, height: float) -> dict[str, Any]:
    """Return where an axes is [points from the top left], and what its axes say."""
    box = axes.get_position()
    x, y = axes.get_xlim(), axes.get_ylim()
    place = (box.x0 * width, (1.0 - box.y1) * height, box.x1 * width, (1.0 - box.y0) * height)
    return {
        'box': [round(float(edge), 1) for edge in place],
        'x': [*map(float, x), axes.get_xscale() == 'log', axes.get_xlabel()],
        'y': [*map(float, y), axes.get_yscale() == 'log', axes.get_ylabel()],
    }
