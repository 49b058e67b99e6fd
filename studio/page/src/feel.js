// A slider for each variable of a level: the shape to first order at once, the exact one as soon as the shell has it.

import { h, choice, table, tick } from '../../../viewer/page/src/dom.js';
import { number, change, plural } from '../../../viewer/page/src/format.js';
import { get, post, bytes } from './api.js';

const shownAtOnce = 40, pause = (ms) => new Promise((done) => setTimeout(done, ms));

export class Feel {
  constructor(studio) {
    this.studio = studio;
    this.level = null;
    this.x = [];
    this.list = [];
    this.text = null;
    this.modes = new Map();
    this.times = { preview: [], exact: [], judged: [] };
    this.asked = new Map();  // of wishes that may still get a shape: {x, begin, text, level}
    this.calls = this.newest = this.shapes = 0;
    this.shows = 'patches';
  }

  panel() {
    this.head = h('div', { class: 'controls' });
    this.verdict = h('p', { class: 'status-line', 'aria-live': 'polite' });
    this.values = h('div', {});
    this.sliders = h('div', { class: 'sliders' });
    this.extras = h('div', { class: 'controls' });
    return [h('p', { class: 'hint' }, 'Drag a variable: the shape follows to first order at once, then exactly, with what the guard says and the built-in quantities. Programs are not asked.'),
      this.head, this.verdict, this.values, this.extras, this.sliders];
  }

  /** Begins, or shows again what was felt; anew when the case is another one. */
  show() {
    this.isOpen = true;
    if (!this.studio.editor.text.trim()) { this.verdict.textContent = 'There is no case yet: propose one under Case.'; return; }
    if (this.text === this.studio.editor.text && this.last) { this.studio.scene.setPositions(this.last); this.colour(); this.draw(); }
    if (this.text !== this.studio.editor.text) this.begin(null);
  }

  hide() {
    const { scene, runs } = this.studio;
    if (this.isOpen && scene) { scene.setEnvelope(null); scene.setField(null); scene.setPositions(scene.body.start); runs.best = 0; }
    this.isOpen = false;
  }

  /** The answer to a wish that is the newest; null: another one came. Its shape is shown if it has a `begin`. */
  async wish(more, begin = 0) {
    const call = ++this.calls, { text } = this, { wish } = await post('feel', { text, ...more });
    if (begin) this.asked.set(wish, { x: more.x, begin, text, level: more.level });
    if (call !== this.calls) return null;
    if (wish < this.newest) this.shapes = 0;  // the studio was started again
    this.newest = wish;
    for (let wait = 12; ; wait = Math.min(40, wait * 1.1)) {
      const state = await get('api/felt_state');
      this.noteModes(state);
      if (state.shapes !== this.shapes) this.taking = this.takeShape(state.shape_of, state.shapes);
      await this.taking;
      if (call !== this.calls) return null;
      if (state.done > wish || (state.done === wish && state.answer.status === 'overtaken')) throw new Error('Another page of this studio has asked meanwhile; move a slider to ask again.');
      if (state.done === wish) return state.answer;
      await pause(wait);
    }
  }

  /** The exact shape of a wish, before it is judged; a second one where the first was refused. That of an older wish brings
   * the first-order shape closer. */
  async takeShape(wish, shapes) {
    this.shapes = shapes;
    const of = this.asked.get(wish), { scene } = this.studio;
    for (const older of [...this.asked.keys()]) if (older < wish) this.asked.delete(older);
    if (!of || of.text !== this.text || of.level !== this.level) return;
    let p = null;
    try { p = new Float32Array(await bytes(`api/felt/shape?of=${wish}`)); } catch { return; }  // empty: the next one is there already
    if (shapes !== this.shapes || this.asked.get(wish) !== of || of.text !== this.text || of.level !== this.level || p.length !== scene.body.start.length) return;
    this.last = p;
    this.exactX = of.x;
    if (!this.isOpen) return;
    if (of.x.some((v, k) => v !== this.x[k])) { this.preview(); return; }
    scene.viewer.hurry();
    scene.setPositions(p);
    scene.viewer.afterDraw = () => this.note('exact', of.begin);
  }

  noteModes(state) {
    this.numModes = state.modes;
    this.hasEnvelope = state.envelope;
    if (this.envelopeTick) this.envelopeTick.querySelector('input').disabled = !state.envelope;
    document.documentElement.dataset.modes = String(state.modes);
  }

  async begin(level) {
    this.verdict.textContent = 'Preparing the variables …';
    this.sliders.replaceChildren();
    this.values.replaceChildren();
    this.extras.replaceChildren();
    this.last = this.start = null;
    this.modes.clear();
    this.asked.clear();
    try {
      this.text = this.studio.editor.text;
      const found = await this.wish(level === null ? {} : { level });
      if (!found) return;
      if (found.error) throw new Error(found.error);
      this.level = found.level;
      this.list = found.variables;
      this.x = this.exactX = this.list.map(() => 0);
      const levels = Array.from({ length: found.levels[1] - found.levels[0] + 1 }, (_, k) => [String(found.levels[0] + k), `level ${found.levels[0] + k}`]);
      this.head.replaceChildren(choice('Variables of', levels, String(this.level), (v) => this.begin(Number(v))),
        h('button', { type: 'button', id: 'feel-start', onclick: () => this.change('start shape', this.x.map(() => 0)) }, 'Start shape'),
        found.leaves_out_programs ? h('span', { class: 'hint' }, 'Programs and what depends on them are left out.') : '');
      this.envelopeTick = tick('envelope of all shapes within the limits', false, (v) => this.showEnvelope(v));
      this.envelopeTick.querySelector('input').disabled = true;
      this.shows = 'patches';
      this.extras.replaceChildren(choice('Colours', [['patches', 'as chosen above'], ['slope', 'sensitivity of the objective'], ['motion', 'displacement from the start']], this.shows,
        (v) => { this.shows = v; if (v === 'slope' && !this.slope) this.ask(); else this.colour(); }), this.envelopeTick);
      this.draw();
      await this.ask();
      this.fetchModes();
    } catch (error) {
      this.text = null;
      this.verdict.textContent = error.message;
      document.documentElement.dataset.felt = 'error';
    }
  }

  /** Modes of the sliders that are shown, one after another, while nothing else is asked. */
  async fetchModes() {
    const text = this.text, level = this.level, size = this.studio.scene.body.start.length;
    const most = Math.max(4, Math.floor(3e8 / (4 * size)));
    for (let j = 0; j < Math.min(this.list.length, most);) {
      if (!this.isOpen || this.text !== text || this.level !== level) return;
      if (j >= this.numModes) { this.noteModes(await get('api/felt_state')); if (j >= this.numModes) { await pause(250); continue; } }
      await this.mode(j);
      ++j;
    }
  }

  async mode(j) {
    if (this.modes.has(j)) return this.modes.get(j);
    if (j >= this.numModes) return null;
    try {
      const found = new Float32Array(await bytes(`api/felt/mode?j=${j}`));
      this.modes.set(j, found.length === this.studio.scene.body.start.length ? found : null);
    } catch { this.modes.set(j, null); }
    document.documentElement.dataset.fetched = String(this.modes.size);
    return this.modes.get(j);
  }

  /** Sets all variables; can be undone. */
  change(words, x) {
    const before = this.x.slice(), after = x.slice();
    this.studio.history.add(words, () => this.set(before), () => this.set(after));
    this.set(after);
  }

  set(x) { this.x = x.slice(); this.preview(); this.draw(); this.ask(); }

  /** The last exact shape, moved to first order to where the sliders are. */
  preview() {
    const { scene } = this.studio, base = this.last || scene.body.start;
    if (!this.isOpen) return;
    const p = this.buffer && this.buffer.length === base.length ? this.buffer : (this.buffer = new Float32Array(base.length));
    p.set(base);
    let isMoved = false;
    for (let j = 0; j < this.x.length; ++j) {
      const step = this.x[j] - this.exactX[j], mode = step === 0 ? null : this.modes.get(j);
      if (!mode) continue;
      isMoved = true;
      for (let k = 0; k < p.length; ++k) p[k] += step * mode[k];
    }
    if (isMoved) scene.preview(p);
  }

  draw() {
    const shape = this.list.map((v, i) => [v, i]).filter(([v]) => !v.is_parameter);
    const steep = this.rates && Math.max(...this.rates.map(Math.abs), 1e-300);
    const one = ([v, i]) => {
      let from = null;
      const out = h('output', {}, number(this.x[i], 3));
      const input = h('input', { type: 'range', min: v.lower, max: v.upper, step: (v.upper - v.lower) / 400, value: this.x[i], 'aria-label': v.name, 'data-variable': v.name,
        onpointerenter: () => this.mode(i), onfocus: () => this.mode(i), onpointerdown: () => { from = this.x.slice(); },
        oninput: () => {
          const begin = performance.now(), before = from || this.x.slice();
          this.x = this.x.slice();
          this.x[i] = Math.min(v.upper, Math.max(v.lower, Number(input.value)));
          out.textContent = number(this.x[i], 3);
          const after = this.x.slice();
          this.studio.history.add(v.name, () => this.set(before), () => this.set(after), `slider ${v.name}`);
          this.preview();
          this.studio.scene.viewer.afterDraw = () => this.note('preview', begin);
          this.ask(begin);
        }, onchange: () => { from = null; } });
      const rate = this.rates ? h('span', { class: 'rate', title: `derivative of ${this.slopeName}: ${number(this.rates[i], 3)} per unit`, 'aria-hidden': 'true' },
        h('i', { class: this.rates[i] < 0 ? 'less' : 'more', style: `width:${(50 * Math.abs(this.rates[i])) / steep}%` })) : '';
      return h('div', { class: 'slider' }, h('span', {}, v.name, rate), input, out);
    };
    const open = this.sliders.querySelector('details') && this.sliders.querySelector('details').open;
    this.sliders.replaceChildren(h('h3', {}, plural(shape.length, 'variable')), ...shape.slice(0, shownAtOnce).map(one),
      shape.length > shownAtOnce ? h('details', { open }, h('summary', {}, `${shape.length - shownAtOnce} more`), ...shape.slice(shownAtOnce).map(one)) : '');
  }

  /** How long something took that is seen now. */
  note(kind, begin) {
    const milliseconds = performance.now() - begin;
    this.times[kind].push(milliseconds);
    document.documentElement.dataset[kind] = milliseconds.toFixed(1);
  }

  /** The exact shape at the sliders; newer positions overtake older ones. */
  async ask(begin = performance.now()) {
    const x = this.x.slice();
    this.verdict.textContent = 'Computing the exact shape …';
    document.documentElement.dataset.felt = 'busy';
    try {
      const found = await this.wish({ level: this.level, x, slope: this.shows === 'slope' }, begin);
      if (!found) return;
      if (found.error) throw new Error(found.error);
      this.slope = null;
      if (found.slope && found.slope.has) await this.takeSlope(found.slope);
      else if (found.slope && this.shows === 'slope') this.studio.tell(found.slope.trouble || 'The case has no objective whose derivative needs no program.');
      if (x.every((v) => v === 0)) this.start = found.values;
      this.seconds = (performance.now() - begin) / 1000;
      this.verdict.replaceChildren(found.status === 'ok' ? h('span', { class: 'badge good' }, 'valid') : h('span', { class: 'badge bad' }, found.status.replace('_', ' ')),
        found.status === 'ok' ? ` A valid shape, in ${number(this.seconds, 2)} s` : ` ${found.reason}`);
      this.listValues(found.values);
      this.note('judged', begin);
      this.colour();
      document.documentElement.dataset.felt = `${found.status} ${this.x.filter((v) => v !== 0).length}`;
      if (!this.start && x.every((v, k) => v === this.x[k])) await this.askStart(found.values);
    } catch (error) { this.verdict.textContent = error.message; document.documentElement.dataset.felt = 'error'; }
  }

  listValues(values) {
    const start = this.start || {};
    this.values.replaceChildren(Object.keys(values).length === 0 ? '' : table('Quantities', [['', false], ['start', true], ['now', true], ['change', true]],
      Object.entries(values).map(([name, value]) => [name, number(start[name]), number(value), change(start[name], value)])));
  }

  /** A slider was moved before the start shape was answered: its values, while nothing else is asked. */
  async askStart(shown) {
    const text = this.text, level = this.level;
    const found = await this.wish({ level, x: this.x.map(() => 0), slope: false });  // the shape shown stays
    if (!found || found.error || this.text !== text || this.level !== level) return;
    this.start = found.values;
    this.listValues(shown);
  }

  /** Where the surface is to go: outward or inward, per area; and the slope along each variable. */
  async takeSlope(slope) {
    const g = new Float32Array(await bytes('api/felt/slope')), { body } = this.studio.scene, n = body.normals, values = new Float32Array(g.length / 3);
    const f = body.faceNormals(this.last || body.start), area = new Float32Array(values.length);
    body.triangles.forEach((v, corner) => { const t = 3 * Math.floor(corner / 3); area[v] += Math.hypot(f[t], f[t + 1], f[t + 2]) / 6; });
    for (let v = 0; v < values.length; ++v) values[v] = area[v] > 0 ? (g[3 * v] * n[3 * v] + g[3 * v + 1] * n[3 * v + 1] + g[3 * v + 2] * n[3 * v + 2]) / area[v] : 0;
    this.slope = { values, signed: true, words: `better ${slope.name}: inward (blue) or outward (orange), per area` };
    this.slopeName = slope.name;
    this.rates = this.list.map((_, j) => { const m = this.modes.get(j); let sum = 0; if (m) for (let k = 0; k < g.length; ++k) sum += m[k] * g[k]; return sum; });
    this.draw();
  }

  colour() {
    const { scene } = this.studio;
    if (!this.isOpen || !scene) return;
    if (this.shows === 'slope') return scene.setField(this.slope);
    if (this.shows === 'motion' && this.last) {
      const p = this.last, s = scene.body.start, values = new Float32Array(s.length / 3), n = scene.body.normals;
      for (let v = 0; v < values.length; ++v) for (let c = 0; c < 3; ++c) values[v] += (p[3 * v + c] - s[3 * v + c]) * n[3 * v + c];
      return scene.setField({ values, signed: true, words: 'displacement along the normal of the start' });
    }
    return scene.setField(null);
  }

  async showEnvelope(isShown) {
    const { scene } = this.studio;
    if (!isShown) return scene.setEnvelope(null);
    const both = new Float32Array(await bytes('api/felt/envelope')), n = both.length / 2;
    return scene.setEnvelope(both.subarray(0, n), both.subarray(n));
  }
}
