// Two designs beside each other, the difference as colours.

import { h, choice } from '../../../viewer/page/src/dom.js';
import { get, bytes } from './api.js';

export class Compare {
  constructor(studio) {
    this.studio = studio;
    this.place = h('div', { class: 'controls' });
    this.element = h('details', { class: 'compare', id: 'compare', ontoggle: () => (this.element.open ? this.list() : this.end()) }, h('summary', {}, 'Compare two designs'),
      this.place, h('p', { class: 'hint' }, 'Beside each other and turning together; the colours are the second minus the first, along the normals of the start. A section shows both.'));
    this.chosen = ['start', ''];
  }

  async list() {
    const { designs } = await get('api/designs');
    const key = (d) => `${d.run}|${d.evaluation}`, words = (d) => `${d.run.replace(/^.*runs\//, '')}, ${d.evaluation === 0 ? 'best' : `evaluation ${d.evaluation}`}`;
    const all = [['start', 'start shape'], ...designs.map((d) => [key(d), words(d)])];
    if (designs.length === 0) { this.place.replaceChildren(h('p', {}, 'No run of this folder has a design yet.')); return; }
    if (!this.chosen[1]) [this.chosen[1]] = all[1];
    this.place.replaceChildren(...[0, 1].map((k) => choice(k ? 'with' : 'Compare', all, this.chosen[k], (v) => { this.chosen[k] = v; this.show(); })));
    await this.show();
  }

  async shape(key) {
    if (key === 'start') return this.studio.scene.body.start;
    const [run, evaluation] = key.split('|');
    const found = new Float32Array(await bytes(`api/design?run=${encodeURIComponent(run)}&evaluation=${evaluation}`));
    if (found.length !== this.studio.scene.body.start.length) throw new Error('That design belongs to another surface.');
    return found;
  }

  async show() {
    const { scene } = this.studio;
    try {
      const [a, b] = await Promise.all(this.chosen.map((key) => this.shape(key)));
      const n = scene.body.normals, values = new Float32Array(a.length / 3);
      for (let k = 0; k < a.length; ++k) values[Math.floor(k / 3)] += (b[k] - a[k]) * n[k];
      this.studio.runs.follows = false;
      this.isOn = true;
      scene.pair(a, b, { values, signed: true, words: 'second minus first, outward positive' });
      document.documentElement.dataset.compared = this.chosen.join(' ');
    } catch (error) { this.studio.tell(error.message); }
  }

  end() {
    if (!this.isOn) return;
    this.isOn = false;
    this.studio.scene.pair(null);
    this.studio.runs.followAgain();
  }
}
