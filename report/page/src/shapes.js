// The section with the shapes: 3D view, sections, a slider through the designs, and the colours.

import { h, section, choice, slider, tick, newId } from '../../../viewer/page/src/dom.js';
import { number, change } from '../../../viewer/page/src/format.js';
import { Shape } from './shape.js';
import { acrossOf } from '../../../viewer/page/src/surface.js';
import { Viewer, likelyUp } from '../../../viewer/page/src/viewer.js';
import { scaleOf, colorAt, gradient, patchColors, plain, css } from '../../../viewer/page/src/colors.js';
import { SectionPlot } from './section_plot.js';

const axes = ['x', 'y', 'z'];

/** The choices for colour: [value, words][]. */
function colourChoices(data) {
  const list = [['plain', 'nothing']];
  data.tree.forEach((level, k) => { if (k > 0) list.push([`patches:${k}`, `patches of level ${k}`]); });
  if (data.frames.length > 0) list.push(['outward', 'displacement, outward'], ['size', 'displacement, magnitude']);
  const names = new Set(data.frames.flatMap((frame) => Object.keys(frame.fields)));
  for (const name of names) list.push([`field:${name}`, name === 'sensitivity' ? 'sensitivity of the objective' : name]);
  return list;
}

/// Normal to y; for a body flat in y (a wing in the x-z plane) along its length, where a section shows its profile.
function tellingAxis(size) {
  const largest = Math.max(...size);
  return size[1] < 0.3 * largest && size[1] === Math.min(...size) ? size.indexOf(largest) : 1;
}

class Panel {
  constructor(shape, run) {
    this.shape = shape;
    this.run = run;
    this.data = shape.data;
    this.frame = Math.max(0, this.data.frames.length - 1);
    this.colour = this.data.frames.length > 0 ? 'outward' : (this.data.tree.length > 1 ? 'patches:1' : 'plain');
    this.factor = 1;
    this.plane = { axis: tellingAxis(shape.size), at: 0, shown: false, cut: false };
    this.selected = null;  // {level, id}
    this.colours = new Map();
  }

  build() {
    this.canvas = h('canvas', { class: 'view', tabindex: 0, role: 'img', 'aria-describedby': 'view-keys',
      'aria-label': 'The surface in three dimensions: start and design' });
    this.names = h('div', { class: 'names', 'aria-hidden': 'true' });
    this.picked = h('p', { class: 'picked', 'aria-live': 'polite' }, 'Click the surface to identify a patch.');
    this.legend = h('div', { class: 'legend' });
    this.told = h('output', { class: 'told', id: newId('told') });
    this.plot = new SectionPlot();
    return [
      h('div', { class: 'controls' }, this.controls()),
      h('div', { class: 'stage' }, this.canvas, this.names),
      this.legend, this.designs(), this.told, this.picked,
      h('p', { class: 'hint', id: 'view-keys' },
        'Drag to rotate, scroll or pinch to zoom, right button to pan. Keyboard: arrow keys rotate, + and \u2212 zoom, Home resets the view.'),
      this.sections(),
    ];
  }

  controls() {
    const views = [['iso', 'Oblique'], ['front', 'Front'], ['side', 'Side'], ['top', 'Top'], ['back', 'Back'], ['below', 'Below']];
    return [
      choice('Colour', colourChoices(this.data), this.colour, (v) => { this.colour = v; this.repaint(); }),
      choice('Show', [['both', 'start and design'], ['one', 'design alone'], ['over', 'design, start as wireframe']], 'both', (v) => {
        this.viewer.both = v === 'both';
        this.viewer.overlay = v === 'over';
        this.nameViews();
        this.viewer.draw();
      }),
      choice('Exaggerate', ['1', '2', '5', '10', '20'].map((v) => [v, `${v} ×`]), '1', (v) => { this.factor = Number(v); this.move(); }),
      choice('Up', axes.map((a, k) => [String(k), a]), String(likelyUp(this.shape.size)), (v) => this.viewer.setUp(Number(v))),
      h('span', { class: 'buttons', role: 'group', 'aria-label': 'View from' },
        views.map(([v, words]) => h('button', { type: 'button', onclick: () => this.viewer.look(v) }, words))),
    ];
  }

  designs() {
    const { frames } = this.data;
    if (frames.length === 0) return h('p', {}, 'No design has been accepted: this is the start surface.');
    const { label, input } = slider('Accepted design', { min: 0, max: frames.length - 1, step: 1, value: this.frame, id: 'design' },
      (v) => this.show(v));
    this.input = input;
    const step = (d) => { input.value = Math.min(frames.length - 1, Math.max(0, this.frame + d)); this.show(Number(input.value)); };
    this.playing = h('button', { type: 'button', onclick: () => this.play() }, 'Play');
    return h('div', { class: 'controls' }, label,
      h('span', { class: 'buttons' }, h('button', { type: 'button', onclick: () => step(-1) }, 'Previous'),
        h('button', { type: 'button', onclick: () => step(1) }, 'Next'), this.playing));
  }

  play() {
    if (this.timer) { clearInterval(this.timer); this.timer = null; this.playing.textContent = 'Play'; return; }
    this.playing.textContent = 'Stop';
    if (this.frame === this.data.frames.length - 1) this.show(0);
    this.timer = setInterval(() => {
      if (this.frame >= this.data.frames.length - 1) return this.play();
      this.show(this.frame + 1);
    }, 500);
  }

  sections() {
    const s = this.shape;
    const range = slider('at', { min: 0, max: 1000, step: 1, value: 500, id: 'section-at' }, (v) => {
      this.plane.at = (v / 1000 - 0.5) * s.size[this.plane.axis];
      this.cut();
    });
    this.sectionAt = h('output', { class: 'told' });
    return h('div', { class: 'sections' }, h('h3', {}, 'Section through both'),
      h('div', { class: 'controls' },
        choice('Plane normal to', axes.map((a, k) => [String(k), a]), String(this.plane.axis), (v) => {
          this.plane.axis = Number(v);
          range.input.value = 500;
          this.plane.at = 0;
          this.cut();
        }), range.label, this.sectionAt,
        tick('Show the plane', false, (v) => { this.plane.shown = v; this.cut(); }),
        tick('Clip the view at the plane', false, (v) => { this.plane.cut = v; this.cut(); })),
      this.plot.element);
  }

  nameViews() {
    const { frames } = this.data;
    const words = frames.length === 0 ? 'start' : `evaluation ${frames[this.frame].evaluation}${this.frame === frames.length - 1 ? ' (best)' : ''}`;
    if (!this.viewer.width) return;
    this.names.replaceChildren(...this.viewer.panes.map(([model, x, y]) =>
      h('span', { style: `left: ${x}px; top: ${y}px` }, model === this.viewer.start ? 'start' : words)));
  }

  show(frame) {
    this.frame = frame;
    if (this.input) this.input.value = frame;
    return this.move();
  }

  async move() {
    const { frames } = this.data, turn = (this.turn = (this.turn || 0) + 1);
    const frame = frames[this.frame];
    const moved = frame ? await this.shape.moved(frame) : null;
    if (turn !== this.turn) return;
    this.moved = moved;
    this.viewer.design.setPositions(this.shape.positions(moved, this.factor));
    if (frame) {
      const words = `evaluation ${frame.evaluation}, level ${frame.level}: ${this.run.is_fit ? 'mean square distance' : 'objective'} ${number(frame.objective)}`
        + ` (${change(frames[0].objective, frame.objective)} from the first)`;
      this.told.textContent = words;
      this.input.setAttribute('aria-valuetext', words);
    }
    this.nameViews();
    await this.repaint();
    this.cut();
  }

  cut() {
    const { axis, at, shown, cut } = this.plane;
    this.viewer.setPlane(axis, at, shown, cut);
    this.sectionAt.textContent = `${axes[axis]} = ${number(at + this.shape.center[axis], 4)} ${this.run.units}`;
    const parts = (p) => this.shape.section(p, axis, at);
    const [u, w] = acrossOf(axis);
    this.plot.show(parts(this.shape.start), parts(this.viewer.design.p), {
      names: [axes[u], axes[w]], center: [this.shape.center[u], this.shape.center[w]], units: this.run.units });
  }

  patchColoursOf(level) {
    if (!this.colours.has(level))
      this.colours.set(level, patchColors(this.shape.labels[level], this.data.tree[level].patches.length, this.shape.triangles));
    return this.colours.get(level);
  }

  /** Values at the vertices of a frame, or null where they are not known. */
  async valuesAt(frame, moved) {
    if (this.colour === 'outward') return this.shape.outward(moved);
    if (this.colour === 'size') return this.shape.lengths(moved);
    const field = frame.fields[this.colour.slice('field:'.length)];
    return field ? this.shape.numbers(field) : null;
  }

  async repaint() {
    const { viewer } = this;
    const [kind, level] = this.colour.split(':');
    const marked = this.selected ? this.shape.labels[this.selected.level] : null;
    const fade = (t, out, at) => {
      if (!marked || marked[t] === this.selected.id) return;
      for (let c = 0; c < 3; ++c) out[at + c] = 0.35 * out[at + c] + 0.65 * 236;
    };
    const both = [viewer.start, viewer.design];
    if (kind === 'plain' || kind === 'patches') {
      const label = kind === 'patches' ? this.shape.labels[Number(level)] : null;
      const colors = label ? this.patchColoursOf(Number(level)) : null;
      for (const model of both)
        model.setColors((t, v, out, at) => {
          const c = colors ? colors[label[t]] : plain;
          out[at] = c[0]; out[at + 1] = c[1]; out[at + 2] = c[2];
          fade(t, out, at);
        });
      this.legend.replaceChildren(kind === 'patches' ? h('span', {}, 'Neighbours differ in colour; lines are borders of patches.') : '');
    } else {
      await this.paintValues(both, fade);
    }
    const lines = marked ? this.selected.level : (kind === 'patches' ? Number(level) : 0);
    const borders = lines > 0 ? this.bordersOf(lines) : new Uint32Array(0);
    for (const model of both) if (model.p) model.setBorders(borders);
    viewer.draw();
  }

  bordersOf(level) {
    this.borders = this.borders || new Map();
    if (!this.borders.has(level)) this.borders.set(level, this.shape.borders(this.shape.labels[level]));
    return this.borders.get(level);
  }

  async paintValues(both, fade) {
    const { frames } = this.data, first = frames[0], frame = frames[this.frame];
    const values = await this.valuesAt(frame, this.moved);
    const before = await this.valuesAt(first, await this.shape.moved(first));
    const isDisplacement = this.colour === 'outward' || this.colour === 'size';
    const signed = this.colour === 'outward' || this.colour === 'field:sensitivity'
      || [values, before].some((list) => list && list.some((x) => x < 0) && list.some((x) => x > 0));
    const scale = scaleOf([values, isDisplacement ? null : before].filter(Boolean).flatMap((list) => Array.from(list)), signed, !isDisplacement);
    [[both[0], isDisplacement ? new Float32Array(this.shape.vertices) : before], [both[1], values]].forEach(([model, list]) => {
      model.setColors((t, v, out, at) => {
        if (list) colorAt(scale, list[v], out, at);
        else { out[at] = plain[0]; out[at + 1] = plain[1]; out[at + 2] = plain[2]; }
        fade(t, out, at);
      });
    });
    this.explain(scale, values && before);
  }

  explain(scale, isKnown) {
    const words = {
      outward: `displacement along the normals, outward positive, ${this.run.units || 'length of the surface'}`,
      size: `displacement, ${this.run.units || 'length of the surface'}`,
      'field:sensitivity': 'change of the objective per outward displacement and area (colours saturate at the 1st and 99th percentile)',
    }[this.colour] || this.colour.slice('field:'.length);
    this.legend.replaceChildren(
      h('span', {}, number(scale.low, 3)),
      h('span', { class: 'bar', style: `background: ${gradient(scale.map)}` }),
      h('span', {}, number(scale.high, 3)), h('span', { class: 'what' }, words),
      isKnown ? '' : h('span', {}, 'Grey: unknown for this design.'));
  }

  /** Highlights a patch, or none. */
  select(level, id) {
    this.selected = level > 0 ? { level, id } : null;
    if (this.onselect) this.onselect(this.selected);
    return this.repaint();
  }

  pick(event) {
    const box = this.canvas.getBoundingClientRect();
    const t = this.viewer.triangleAt(event.clientX - box.left, event.clientY - box.top);
    if (t < 0) { this.picked.textContent = 'No patch there.'; return this.select(0, 0); }
    const [kind, wanted] = this.colour.split(':');
    const level = kind === 'patches' ? Number(wanted) : this.data.tree.length - 1;
    if (level < 1) { this.picked.textContent = `Triangle ${t}.`; return undefined; }
    const id = this.shape.labels[level][t], patch = this.data.tree[level].patches[id];
    this.picked.textContent = `Patch ${patch.name} of level ${level}, triangle ${t}.`;
    return this.select(level, id);
  }

  async begin() {
    this.viewer = new Viewer(this.canvas, this.shape);
    this.viewer.onresize = () => this.nameViews();
    this.viewer.start.setPositions(this.shape.start);
    let from = null;
    this.canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY]; });
    this.canvas.addEventListener('pointerup', (e) => {
      if (from && Math.hypot(e.clientX - from[0], e.clientY - from[1]) < 4) this.pick(e);
    });
    await this.move();
    this.viewer.resize();
  }
}

/** Fills `place` with the section; returns the panel, or null where there are no shapes or no WebGL. */
export async function shapes(run, place) {
  const body = h('div', {});
  place.append(section('shapes', 'Shape', body));
  if (!run.shapes) { body.append(h('p', {}, 'This page has no shapes: the folder contains none (output.paraview: none), or they could not be read.')); return null; }
  try {
    const panel = new Panel(await Shape.load(run.shapes), run);
    body.append(...panel.build());
    await panel.begin();
    return panel;
  } catch (error) {
    body.replaceChildren(h('p', { class: 'problem' },
      `The shapes cannot be shown here: ${error.message}. They need WebGL and a browser of 2023 or later; ParaView shows series.pvd of the folder.`));
    console.warn(error);
    return null;
  }
}

export { css };
