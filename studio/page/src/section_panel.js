// A cut by a plane that is dragged: start and now, with what an airfoil is measured by.

import { h, choice, slider, tick, table } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { airfoilOf } from '../../../viewer/page/src/airfoil.js';

const space = 'http://www.w3.org/2000/svg';
const svg = (tag, attributes, ...children) => {
  const element = document.createElementNS(space, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
};
const path = (lines) => lines.map((line) => `M${line.map(([a, b]) => `${a.toPrecision(6)} ${(-b).toPrecision(6)}`).join('L')}`).join('');
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const s = Math.hypot(...a) || 1; return a.map((v) => v / s); };

export class Section {
  constructor(studio) {
    this.studio = studio;
    this.isOn = false;
    this.byChord = true;
    this.kind = null;
    this.drawing = svg('svg', { class: 'section-plot', role: 'img', 'aria-label': 'Section of the start and of the shape shown' });
    this.facts = h('div', { class: 'section-facts', 'aria-live': 'polite' });
    this.controls = h('div', { class: 'controls' });
    this.element = h('section', { class: 'drawer', hidden: true, 'aria-label': 'Section' }, this.controls, h('div', { class: 'section-body' }, this.drawing, this.facts));
  }

  toggle(on = !this.isOn) {
    this.isOn = on;
    this.element.hidden = !on;
    document.documentElement.classList.toggle('cuts', on);
    const { toolButtons } = this.studio;
    if (toolButtons) toolButtons.cut.setAttribute('aria-pressed', String(on));
    if (on) this.begin(); else this.clear();
  }

  clear() {
    const { scene } = this.studio;
    if (!scene) return;
    scene.setLines('cut', [], 0);
    scene.setLines('cut of the start', [], 0);
    scene.cutPlane(null);
    this.studio.handles();
  }

  /** The body is another one. */
  reset() { this.kind = null; if (this.isOn) this.begin(); }

  begin() {
    const { scene } = this.studio, { body } = scene, { axes, symmetry } = body.facts;
    if (this.kind === null) {  // across the wing, or across the body
      const across = symmetry ? symmetry.normal : axes ? cross(axes.up, axes.downstream) : [0, 1, 0];
      this.kind = String(across.map(Math.abs).indexOf(Math.max(...across.map(Math.abs))));
      this.setNormal(this.kind);
      this.share = body.facts.symmetry && body.facts.symmetry.is_half ? 0.5 : 0.75;
    }
    this.options();
    this.update();
  }

  setNormal(kind) {
    this.kind = kind;
    const { camera } = this.studio.scene.viewer;
    if (kind === 'view') this.normal = [camera.matrix.elements[0], camera.matrix.elements[1], camera.matrix.elements[2]];
    else if (kind === 'flat') this.normal = [camera.matrix.elements[4], camera.matrix.elements[5], camera.matrix.elements[6]];
    else this.normal = [0, 1, 2].map((c) => (String(c) === kind ? 1 : 0));
  }

  /** Range of the body along the normal, relative to the middle. */
  range() {
    const { start } = this.studio.scene.body;
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < start.length; k += 3) { const a = start[k] * this.normal[0] + start[k + 1] * this.normal[1] + start[k + 2] * this.normal[2]; low = Math.min(low, a); high = Math.max(high, a); }
    return [low, high];
  }

  get at() { const [low, high] = this.range(); return low + this.share * (high - low); }
  /** In the coordinates of the file. */
  get place() { return this.at + dot(this.normal, this.studio.scene.body.center); }

  moveBy(length) {
    const [low, high] = this.range();
    this.share = Math.min(1, Math.max(0, this.share + length / (high - low || 1)));
    this.sync();
    this.update();
  }

  sync() {
    if (this.position) this.position.value = 1000 * this.share;
    if (this.typed) this.typed.value = Number(this.place.toPrecision(5));
  }

  options() {
    const made = slider('at', { min: 0, max: 1000, step: 1, value: 1000 * this.share, id: 'section-at' }, (v) => { this.share = v / 1000; this.sync(); this.update(); });
    this.position = made.input;
    this.typed = h('input', { type: 'number', step: 'any', 'aria-label': 'Position of the section', value: String(Number(this.place.toPrecision(5))),
      onchange: () => { const [low, high] = this.range(), v = this.typed.valueAsNumber - dot(this.normal, this.studio.scene.body.center); if (Number.isFinite(v)) { this.share = Math.min(1, Math.max(0, (v - low) / (high - low || 1))); this.sync(); this.update(); } } });
    this.controls.replaceChildren(choice('Cut normal to', [['0', 'x'], ['1', 'y'], ['2', 'z'], ['view', 'the screen, upright'], ['flat', 'the screen, level']], this.kind, (v) => { this.setNormal(v); this.sync(); this.update(); }),
      made.label, this.typed, tick('scaled by the chord', this.byChord, (v) => { this.byChord = v; this.update(); }),
      h('button', { type: 'button', onclick: () => this.toggle(false) }, 'Close'));
  }

  /** Directions of the drawing: to the right and up. */
  frame() {
    const { axes } = this.studio.scene.body.facts, n = this.normal;
    const flat = (v) => { const d = dot(v, n), w = v.map((x, c) => x - d * n[c]); return Math.hypot(...w) > 0.2 ? unit(w) : null; };
    let right = axes && flat(axes.downstream);
    if (right) {
      const up = unit(cross(right, n));
      return [right, dot(up, axes.up) < 0 ? up.map((v) => -v) : up];
    }
    const up = (axes && flat(axes.up)) || flat([0, 0, 1]) || flat([0, 1, 0]);
    right = unit(cross(up, n));
    return [right, up];
  }

  update() {
    if (!this.isOn || !this.studio.scene) return;
    const { scene } = this.studio, { body } = scene, now = scene.model.p;
    const first = scene.compared || body.start, start = body.sectionBy(first, this.normal, this.at), changed = now !== first, is = changed ? body.sectionBy(now, this.normal, this.at) : start;
    scene.setLines('cut of the start', changed ? start : [], 0x777777);
    scene.setLines('cut', is, 0xd5005e);
    scene.cutPlane({ normal: this.normal, at: this.place });
    this.studio.handles();
    const [right, up] = this.frame(), flat = (lines) => lines.map((line) => line.map((p) => [dot(p, right), dot(p, up)]));
    this.draw(flat(start), changed ? flat(is) : null, right, up);
  }

  /** Of lines in the plane: [x downstream, z up]. */
  measured(lines) { return airfoilOf(lines); }

  draw(start, now, right, up) {
    const one = start.length > 0 ? this.measured(start) : null, other = now && now.length > 0 ? this.measured(now) : null;
    this.found = { start: one, now: other };
    const scaled = this.byChord && one && (!now || other);
    const a = scaled ? one.lines : start, b = scaled ? other && other.lines : now;
    const all = [...a, ...(b || [])].flat();
    if (all.length === 0) { this.drawing.replaceChildren(); this.facts.replaceChildren(h('p', { class: 'hint' }, 'The plane does not cut the surface.')); return; }
    const low = [0, 1].map((k) => all.reduce((m, p) => Math.min(m, p[k]), Infinity)), high = [0, 1].map((k) => all.reduce((m, p) => Math.max(m, p[k]), -Infinity));
    const size = Math.max(high[0] - low[0], high[1] - low[1], 1e-30), pad = 0.04 * size;
    this.drawing.setAttribute('viewBox', `${low[0] - pad} ${-high[1] - pad} ${high[0] - low[0] + 2 * pad} ${high[1] - low[1] + 2 * pad}`);
    this.drawing.style.aspectRatio = `${high[0] - low[0] + 2 * pad} / ${Math.max(high[1] - low[1] + 2 * pad, 0.12 * size)}`;
    this.drawing.replaceChildren(svg('path', { d: path(a), class: b ? 'start' : 'now' }), ...(b ? [svg('path', { d: path(b), class: 'now' })] : []));
    const { body } = this.studio.scene, near = (d) => body.facts.axes && Math.abs(dot(d, body.facts.axes.downstream)) > 0.7;
    const isWing = one && near(right) && one.thickness < 0.5;
    const words = (v) => { const k = v.map(Math.abs).indexOf(Math.max(...v.map(Math.abs))); return Math.abs(v[k]) > 0.999 ? 'xyz'[k] : 'oblique'; };
    if (!isWing) {
      this.facts.replaceChildren(h('p', { class: 'hint' }, `${words(right)} to the right, ${words(up)} up: ${number(high[0] - low[0], 4)} × ${number(high[1] - low[1], 4)}${scaled ? ' chords' : ''}`));
      return;
    }
    const degrees = (r) => `${number(Math.abs(r) < 1e-8 ? 0 : (r * 180) / Math.PI, 3)}°`, percent = (v) => (v === null ? '–' : `${number(Math.abs(v) < 1e-9 ? 0 : 100 * v, 4)} %`);
    const rows = [['chord', (f) => number(f.chord, 5)], ['twist, nose up', (f) => degrees(f.twist)], ['t/c', (f) => percent(f.thickness)], ['thickest at', (f) => percent(f.at)], ['camber', (f) => percent(f.camber)], ['leading-edge radius / c', (f) => percent(f.radius)]];
    this.facts.replaceChildren(table('Section', [['', false], ['start', true], ...(other ? [['now', true]] : [])], rows.map(([name, of]) => [name, of(one), ...(other ? [of(other)] : [])])));
  }
}
