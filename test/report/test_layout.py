# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Nothing in a report is wider than the page, and no text lies over another."""

from __future__ import annotations

import itertools
import json
import re
import shutil
import subprocess
from dataclasses import replace
from html import escape, unescape

import pytest
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text

from sosml_friction.diagnosis.residual.joint_residual import joint_residuals
from sosml_friction.identification.term_residual import along_axis
from sosml_friction.report.common import figure
from sosml_friction.report.common.figure import figures_of
from sosml_friction.report.diagnosis.html import render_diagnosis
from sosml_friction.report.fit.consolidation_view import bags_joints
from sosml_friction.report.fit.html import render_bags_report
from sosml_friction.report.fit.joint_view import joint_views
from sosml_friction.report.simulation.document import SimulatedJoint, render_simulation
from sosml_friction.report.study.results import render_study
from sosml_friction.report.terms.document import render_terms

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
CHROMIUM = CHROMIUM or shutil.which('google-chrome')
#: A phone and a screen [CSS pixels].
WIDTHS = (400, 1400)
#: Boxes of text may touch by this share of their height: they are higher than their letters.
TOUCH = 0.25
SMALLEST = 8.0
LARGEST = 2_000_000
#: Runs in each page: opens what is folded, and reports what is too wide and what overlaps.
SCRIPT = """<script>
addEventListener('load', () => {
  document.querySelectorAll('details').forEach(x => x.open = true);
  const wide = [...document.body.querySelectorAll('*')]
    .filter(x => !x.closest('.wide') && x.id !== 'tip' && x.scrollWidth
      && x.getBoundingClientRect().right > innerWidth + 1)
    .map(x => x.tagName + ': ' + x.textContent.slice(0, 40));
  if (document.documentElement.scrollWidth > innerWidth) wide.push('the page');
  document.querySelectorAll('tr').forEach(x => {
    // A sentence that is squeezed into a column of a word.
    if (x.getBoundingClientRect().height > 300) wide.push('tall: ' + x.textContent.slice(0, 40));
  });
  const over = [];
  for (const svg of document.querySelectorAll('svg')) {
    const texts = [...svg.querySelectorAll('text')].filter(x => x.textContent.trim());
    const boxes = texts.map(x => x.getBoundingClientRect());
    for (let a = 0; a < boxes.length; a++) for (let b = a + 1; b < boxes.length; b++) {
      const p = boxes[a], q = boxes[b];
      const x = Math.min(p.right, q.right) - Math.max(p.left, q.left);
      const y = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
      const least = TOUCH * Math.min(p.height, q.height, p.width, q.width);
      if (x > least && y > least)
        over.push([a, b].map(k => texts[k].textContent.trim()).join(' / '));
    }
  }
  const svg = document.querySelector('svg'), entry = svg.querySelector('.legend .entry');
  const click = () => entry.dispatchEvent(new MouseEvent('click', {bubbles: true}));
  const hidden = () => svg.querySelectorAll('.hidden').length;
  let acts = 0;
  if (entry) {
    click();
    acts += hidden() > 0;
    click();
    acts += hidden() === 0;
  }
  const mark = [...svg.querySelectorAll('g.axes use')].find(x => !x.closest('.axis, defs'));
  if (mark) {
    const box = mark.getBoundingClientRect();
    const [clientX, clientY] = [box.x + box.width / 2, box.y + box.height / 2];
    svg.dispatchEvent(new PointerEvent('pointermove', {clientX, clientY, bubbles: true}));
    acts += document.getElementById('tip').textContent.includes('velocity ');
  }
  parent.postMessage({name: NAME, width: innerWidth, wide, over, acts}, '*');
});
</script></body>"""
FRAME = """<!DOCTYPE html><body><pre id="said"></pre><script>
const said = [];
addEventListener('message', e => {
  said.push(e.data);
  document.getElementById('said').textContent = JSON.stringify(said);
});
</script>FRAMES</body>"""


@pytest.fixture(scope='module')
def pages(fit_page, bags, truth, diagnosis, tiny_study, simulated, fitted_terms):
    """Return every report by its name; that of several recordings has the figures of one."""
    drawn = {f.identifier: f.draw(tiny_study) for f in figures_of('study', tiny_study)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure, 'to_svg', lambda *drawn: '<svg></svg>')
        several = render_bags_report(bags, truth)
    rows = {'bags': [{'bag': 'a_recording_with_a_long_name'}], 'model': 'slider'}
    return {
        'fit': fit_page,
        'bags': several,
        'diagnosis': render_diagnosis(diagnosis, rows),
        'study': render_study(tiny_study, drawn),
        'simulation': render_simulation(simulated, 'Simulation'),
        'terms': render_terms(fitted_terms, 'Terms'),
    }


@pytest.fixture(scope='module')
def drawings(analysis, truth, bags, diagnosis, tiny_study, simulated, fitted_terms):
    """Return every figure of every report by its name."""
    view = joint_views(analysis, truth)[0]
    views = {
        'fit': [view, replace(view, truth=None)],
        'bags': [bags_joints(bags)['shoulder']],
        'diagnosis': [*joint_residuals(diagnosis), diagnosis],
        'study': [tiny_study],
        'simulation': [SimulatedJoint(simulated, 0)],
        'terms': along_axis(fitted_terms, fitted_terms.terms[0]),
    }
    return {
        f'{report} {one.identifier} {k}': one.draw(view)
        for report, some in views.items()
        for k, view in enumerate(some)
        for one in figures_of(report, view)
    }


class Recorder(RendererAgg):
    """Draws, and keeps the box of each text that is drawn: ticks out of sight are not."""

    def __init__(self, drawing):
        super().__init__(*(drawing.bbox.size), drawing.dpi)
        self.boxes = []

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        if s.strip() and mtext is not None:
            self.boxes.append((s, mtext.get_window_extent(self)))


def overlapping(drawing):
    """Return the pairs of texts of a figure that lie over one another."""
    recorder = Recorder(drawing)
    drawing.draw(recorder)
    found = []
    for (one, p), (other, q) in itertools.combinations(recorder.boxes, 2):
        x = min(p.x1, q.x1) - max(p.x0, q.x0)
        y = min(p.y1, q.y1) - max(p.y0, q.y0)
        least = TOUCH * min(p.height, q.height, p.width, q.width)
        if x > least and y > least:
            found.append((one, other))
    return found


def test_no_text_of_a_figure_lies_over_another(drawings):
    assert {name: pairs for name, x in drawings.items() if (pairs := overlapping(x))} == {}


def test_overlapping_text_is_found(drawings):
    drawing = next(iter(drawings.values()))
    (one, other) = (drawing.text(0.5, 0.5, text) for text in ('first', 'second'))
    assert ('first', 'second') in overlapping(drawing)
    one.remove()
    other.remove()


def test_every_text_of_a_figure_can_be_read(drawings):
    small = {
        name: {text.get_text() for text in drawing.findobj(Text)
               if text.get_text().strip() and text.get_fontsize() < SMALLEST}
        for name, drawing in drawings.items()
    }  # fmt: skip
    assert {name: texts for name, texts in small.items() if texts} == {}


def test_what_may_be_wide_scrolls_by_itself(pages):
    for page in pages.values():
        bare = re.sub(r'<div class="wide">.*?</(?:table|svg)></div>', '', page, flags=re.DOTALL)
        body = bare[bare.index('<body>') : bare.index('<script>')]
        assert not re.search(r'<table|<svg|<img|<pre', body)
        assert not re.search(r'(?<!max-)(?<!min-)width:\s*[4-9]\d\dpx', bare)


def test_a_report_stands_alone_and_is_small(pages):
    for page in pages.values():
        assert len(page.encode()) < LARGEST
        assert not re.search(r'(?:src|href)\s*=\s*"(?!#)|@import|url\((?!#)|<link|<iframe', page)


@pytest.mark.skipif(CHROMIUM is None, reason='no Chromium is installed')
def test_no_page_is_wider_than_a_phone_or_a_screen_and_no_text_overlaps(pages, tmp_path):
    frames = ''
    for name, page in pages.items():
        script = SCRIPT.replace('NAME', json.dumps(name)).replace('TOUCH', str(TOUCH))
        (tmp_path / f'{name}.html').write_text(page.replace('</body>', script))
        for width in WIDTHS:
            source = escape((tmp_path / f'{name}.html').as_uri())
            frames += f'<iframe src="{source}" width="{width}" height="900"></iframe>'
    (tmp_path / 'all.html').write_text(FRAME.replace('FRAMES', frames))
    command = [
        *(CHROMIUM, '--headless', '--no-sandbox', '--disable-gpu', '--dump-dom'),
        *(f'--user-data-dir={tmp_path / "profile"}', '--virtual-time-budget=30000'),
        (tmp_path / 'all.html').as_uri(),
    ]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=120)
    said = re.search(r'<pre id="said">(.*?)</pre>', ran.stdout, re.DOTALL)[1]
    found = json.loads(unescape(said))
    assert len(found) == len(pages) * len(WIDTHS)
    for said in found:
        assert said['wide'] == [], said['name']
        assert said['over'] == [], said['name']
        # Curves hide and come back, and a mark says its values.
        if said['name'] == 'fit':
            assert said['acts'] == 3
