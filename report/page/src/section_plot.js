// Start and design in a section plane, to the same scale.

import { h } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';

const space = 'http://www.w3.org/2000/svg';

function svg(tag, attributes, ...children) {
  const element = document.createElementNS(space, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const path = (lines) => lines.map((line) => `M${line.map(([a, b]) => `${a.toPrecision(6)} ${(-b).toPrecision(6)}`).join('L')}`).join('');

export class SectionPlot {
  constructor() {
    this.drawing = svg('svg', { class: 'section-plot', role: 'img', 'aria-label': 'Section of start and design' });
    this.words = h('p', { class: 'hint' });
    this.element = h('figure', {}, this.drawing, h('figcaption', {},
      h('span', { class: 'key start' }, 'start (dashed)'), ' ', h('span', { class: 'key design' }, 'design'), ' ', this.words));
  }

  show(start, design, { names, center, units }) {
    const all = [...start, ...design];
    this.words.textContent = all.length === 0 ? 'The plane does not cut the surface.' : '';
    if (all.length === 0) return this.drawing.replaceChildren();
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    for (const point of all.flat())
      point.forEach((v, k) => { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); });
    const size = Math.max(high[0] - low[0], high[1] - low[1], 1e-30), pad = 0.03 * size;
    const width = high[0] - low[0] + 2 * pad, height = high[1] - low[1] + 2 * pad;
    this.drawing.setAttribute('viewBox', `${low[0] - pad} ${-high[1] - pad} ${width} ${height}`);
    this.drawing.style.aspectRatio = `${width} / ${Math.max(height, 0.05 * width)}`;
    this.drawing.replaceChildren(
      svg('path', { d: path(start), class: 'start' }), svg('path', { d: path(design), class: 'design' }));
    const step = 10 ** (Math.floor(Math.log10(size)) - 3);  // values far below the size are noise
    const tidy = (v) => number(Math.round(v / step) * step, 6);
    this.words.textContent = `${names[0]} from ${tidy(low[0] + center[0])} to ${tidy(high[0] + center[0])}, `
      + `${names[1]} from ${tidy(low[1] + center[1])} to ${tidy(high[1] + center[1])} ${units}`;
    return undefined;
  }
}
