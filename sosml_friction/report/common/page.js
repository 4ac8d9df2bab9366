'use strict';
const tip = document.getElementById('tip');
for (const svg of document.querySelectorAll('svg[data-axes]')) {
  const axes = JSON.parse(svg.dataset.axes), whole = svg.getAttribute('viewBox');
  const groups = [...svg.querySelectorAll('g.axes')].filter(g => !g.closest('.legend'));
  const place = e => new DOMPoint(e.clientX, e.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const shown = e => !e.closest('.hidden, .axis, .legend, defs');
  // The colour and dashes of an element: what a legend's entry and its curves have in common.
  const look = e => {
    const s = e.style, line = s.stroke && s.stroke !== 'none';
    return (line && e.tagName === 'path' ? s.stroke : s.fill || s.stroke) + '|' +
      (e.tagName === 'path' ? s.strokeDasharray : '');
  };
  for (const legend of svg.querySelectorAll('g.legend')) {
    const texts = [...legend.querySelectorAll('text')];
    for (const text of texts) {
      const handle = text.parentNode.previousElementSibling;
      if (!handle) continue;
      const looks = new Set([...handle.querySelectorAll('path[style], use')]
        .filter(e => !e.closest('defs')).map(look));
      const own = [...svg.querySelectorAll('g.axes path[style], g.axes use')]
        .filter(e => !e.closest('.axis, .legend, defs') && looks.has(look(e)));
      if (!own.length) continue;
      for (const e of [handle, text]) {
        e.classList.add('entry');
        e.addEventListener('click', () => {
          const off = text.classList.toggle('off');
          handle.classList.toggle('off', off);
          own.forEach(x => x.classList.toggle('hidden', off));
        });
      }
    }
  }
  // Corners of all curves and marks of an axes, once it is pointed at.
  const corners = groups.map(() => null);
  const read = k => corners[k] = corners[k] || [...groups[k].querySelectorAll('path[style], use')]
    .filter(e => !e.closest('.axis, .legend, defs') && e.style.clipPath !== 'none')
    .flatMap(e => {
      if (e.tagName === 'use') return [[+e.getAttribute('x'), +e.getAttribute('y'), e]];
      let x = 0, y = 0, found = [];
      for (const m of e.getAttribute('d').matchAll(/([MLml])\s*(-?[\d.]+)[ ,](-?[\d.]+)/g)) {
        const step = m[1] > 'Z';
        x = step ? x + +m[2] : +m[2];
        y = step ? y + +m[3] : +m[3];
        found.push([x, y, e]);
      }
      return found;
    });
  const value = (place, from, to, [low, high, log]) => {
    const share = (place - from) / (to - from);
    return log ? low * (high / low) ** share : low + share * (high - low);
  };
  const say = (x, label) => {
    const [, name, unit] = label.match(/^(.*?)\s*(?:\[(.*)\])?$/);
    return `${name} ${Number(x.toPrecision(4))}${unit ? ' ' + unit : ''}`;
  };
  svg.addEventListener('pointermove', e => {
    const p = place(e);
    const k = axes.findIndex(({box}) => p.x >= box[0] && p.x <= box[2] && p.y >= box[1] && p.y <= box[3]);
    tip.style.display = 'none';
    if (k < 0 || !groups[k]) return;
    let best = 15, at = null;
    for (const c of read(k)) {
      const far = Math.hypot(c[0] - p.x, c[1] - p.y);
      if (far < best && shown(c[2])) { best = far; at = c; }
    }
    if (!at) return;
    const {box, x, y} = axes[k];
    const first = axes.find((a, i) => i <= k && a.box[1] === axes[k].box[1] && a.y[3]);
    tip.textContent = say(value(at[0], box[0], box[2], x), x[3]) + ', ' +
      say(value(at[1], box[3], box[1], y), y[3] || (first ? first.y[3] : ''));
    tip.style.display = 'block';
    tip.style.left = Math.min(e.pageX + 12, innerWidth - tip.offsetWidth - 4) + 'px';
    tip.style.top = e.pageY + 14 + 'px';
  });
  svg.addEventListener('pointerleave', () => tip.style.display = 'none');
  let from = null, frame = null;
  svg.addEventListener('pointerdown', e => {
    if (e.pointerType !== 'mouse' || e.button || e.target.closest('.entry')) return;
    from = e;
    frame = document.body.appendChild(document.createElement('div'));
    frame.id = 'zoom';
  });
  const stop = () => { frame && frame.remove(); from = frame = null; };
  addEventListener('pointermove', e => {
    if (!from) return;
    Object.assign(frame.style, {
      left: Math.min(e.pageX, from.pageX) + 'px', top: Math.min(e.pageY, from.pageY) + 'px',
      width: Math.abs(e.pageX - from.pageX) + 'px', height: Math.abs(e.pageY - from.pageY) + 'px'});
  });
  addEventListener('pointerup', e => {
    if (!from) return;
    const a = place(from), b = place(e);
    const width = Math.abs(a.x - b.x), height = Math.abs(a.y - b.y);
    if (width > 8 && height > 8) {
      svg.setAttribute('viewBox', [Math.min(a.x, b.x), Math.min(a.y, b.y), width, height].join(' '));
      svg.style.aspectRatio = whole.split(' ').slice(2).join(' / ');
    }
    stop();
  });
  svg.addEventListener('dblclick', () => svg.setAttribute('viewBox', whole));
}
