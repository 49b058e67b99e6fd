// A slider for each variable of a level, and the exact shape at their values.

import { h, choice, table } from '../../../viewer/page/src/dom.js';
import { number, change, plural } from '../../../viewer/page/src/format.js';
import { post, bytes, newest } from './api.js';

const shownAtOnce = 40;

export class Feel {
  constructor(studio) {
    this.studio = studio;
    this.level = null;
    this.x = [];
    this.list = [];
    this.before = [];
    this.text = null;
    this.ask = newest(() => this.shape());
  }

  panel() {
    this.head = h('div', { class: 'controls' });
    this.verdict = h('p', { class: 'status-line', 'aria-live': 'polite' });
    this.values = h('div', {});
    this.sliders = h('div', { class: 'sliders' });
    return [h('p', { class: 'hint' }, 'What each variable of the case does, at its exact shape. Values are scaled; programs are not asked.'), this.head, this.verdict, this.values, this.sliders];
  }

  /** Begins, or shows again what was felt; anew when the case is another one. */
  show() {
    if (!this.studio.editor.text.trim()) { this.verdict.textContent = 'There is no case yet: propose one under Case.'; return; }
    this.isOpen = true;
    if (this.text === this.studio.editor.text && this.last) this.studio.scene.setPositions(this.last);
    if (this.text !== this.studio.editor.text) this.begin(null);
  }

  hide() {
    if (this.isOpen && this.studio.scene) { this.studio.scene.setPositions(this.studio.scene.body.start); this.studio.runs.best = 0; }
    this.isOpen = false;
  }

  async begin(level) {
    this.verdict.textContent = 'Preparing the variables …';
    this.sliders.replaceChildren();
    this.values.replaceChildren();
    this.last = this.start = null;
    try {
      this.text = this.studio.editor.text;
      const found = await post('variables', { text: this.text, ...(level === null ? {} : { level }) });
      this.level = found.level;
      this.list = found.variables;
      this.x = this.list.map(() => 0);
      this.before = [];
      const levels = Array.from({ length: found.levels[1] - found.levels[0] + 1 }, (_, k) => [String(found.levels[0] + k), `level ${found.levels[0] + k}`]);
      this.head.replaceChildren(choice('Variables of', levels, String(this.level), (v) => this.begin(Number(v))),
        h('button', { type: 'button', onclick: () => { if (this.before.length) this.set(this.before.pop()); } }, 'Undo'),
        h('button', { type: 'button', id: 'feel-start', onclick: () => { this.before.push(this.x.slice()); this.set(this.x.map(() => 0)); } }, 'Start shape'),
        found.leaves_out_programs ? h('span', { class: 'hint' }, 'Programs and what depends on them are left out.') : '');
      this.draw();
      await this.ask();
    } catch (error) {
      this.text = null;
      this.verdict.textContent = error.message;
    }
  }

  set(x) { this.x = x; this.draw(); this.ask(); }

  draw() {
    const shape = this.list.map((v, i) => [v, i]).filter(([v]) => !v.is_parameter);
    const one = ([v, i]) => {
      const input = h('input', { type: 'range', min: v.lower, max: v.upper, step: (v.upper - v.lower) / 400, value: this.x[i], 'aria-label': v.name, 'data-variable': v.name,
        onpointerdown: () => this.before.push(this.x.slice()),
        oninput: () => { this.x[i] = Math.min(v.upper, Math.max(v.lower, Number(input.value))); out.textContent = number(this.x[i], 3); this.ask(); } });
      const out = h('output', {}, number(this.x[i], 3));
      return h('div', { class: 'slider' }, h('span', {}, v.name), input, out);
    };
    this.sliders.replaceChildren(h('h3', {}, plural(shape.length, 'variable')), ...shape.slice(0, shownAtOnce).map(one),
      shape.length > shownAtOnce ? h('details', {}, h('summary', {}, `${shape.length - shownAtOnce} more`), ...shape.slice(shownAtOnce).map(one)) : '');
  }

  async shape() {
    const begin = performance.now();
    try {
      const found = await post('feel', { text: this.text, level: this.level, x: this.x });
      const { scene } = this.studio;
      if (found.has_shape) {
        this.last = new Float32Array(await bytes('api/felt'));
        if (this.isOpen && this.last.length === scene.body.start.length) scene.setPositions(this.last);
      }
      this.seconds = (performance.now() - begin) / 1000;
      this.start = this.start || found.values;
      this.verdict.textContent = found.status === 'ok' ? `A valid shape, in ${number(this.seconds, 2)} s` : `${found.status}: ${found.reason}`;
      this.values.replaceChildren(Object.keys(found.values).length === 0 ? '' : table('Quantities', [['', false], ['start', true], ['now', true], ['change', true]],
        Object.entries(found.values).map(([name, value]) => [name, number(this.start[name]), number(value), change(this.start[name], value)])));
      document.documentElement.dataset.felt = `${found.status} ${this.x.filter((v) => v !== 0).length}`;
    } catch (error) { this.verdict.textContent = error.message; }
  }
}
