// The case as text, with its errors at their lines and its regions on the surface.

import { h, tick } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { get, post, marksOf, newest } from './api.js';
import { Form } from './form.js';
import { YamlEditor } from './yaml_editor.js';

export class Editor {
  constructor(studio) {
    this.studio = studio;
    this.mark = '';
    this.name = '';
    this.saved = '';
    this.found = [];
    this.form = new Form(this);
    this.shownRegions = new Set();
    this.regions = [];
    this.area = new YamlEditor('Case file, YAML. Ctrl+Space completes, Escape then Tab leaves.');
    this.area.addEventListener('input', () => this.typed());
    this.area.names = () => ({ regions: this.regions.map((r) => r.name), quantities: (this.form.facts ? this.form.facts.quantities : []).map((q) => q.name) });
    get('api/keys').then((keys) => { this.area.keys = keys.map((key) => ({ ...key, steps: key.path.split('.') })); }, () => {});
    this.errors = h('div', { class: 'errors', 'aria-live': 'polite' });
    this.list = h('div', { class: 'regions' });
    this.check = newest(() => this.ask());
  }

  get text() { return this.area.value; }
  get isChanged() { return this.text !== this.saved; }

  async load() {
    const { name, text, mark } = await get('api/case');
    if (this.isChanged && this.name && (!name || (name === this.name && mark === this.mark))) { this.changed(); return; }  // what is typed stays
    this.name = name;
    this.mark = mark;
    if (this.area.value !== text) {
      if (this.area.value.trim()) this.remember(this.area.value, text, `${name || 'no case'} opened`);
      this.area.value = text;
    }
    this.saved = this.lastText = this.text;
    this.changed();
  }

  remember(before, after, why) {
    const set = (text) => { this.area.value = text; this.lastText = text; this.changed(); };
    this.studio.history.add(why, () => set(before), () => set(after));
  }

  replace(text, why = 'case') {
    if (text === this.area.value) return;
    this.remember(this.area.value, text, why);
    this.area.value = text;
    this.lastText = text;
    this.changed();
  }

  /** Typing: one change as long as it goes on. */
  typed() {
    const before = this.lastText ?? '', after = this.area.value, set = (text) => { this.area.value = text; this.lastText = text; this.changed(); };
    this.studio.history.add('typing in the case', () => set(before), () => set(after), 'typing');
    this.lastText = after;
    this.changed();
  }

  changed() {
    this.status();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => { this.check(); this.form.refresh(); }, 200);
  }

  status() {
    if (!this.state) return;
    this.state.textContent = this.name ? `${this.name}${this.isChanged ? ', not saved' : ''}` : (this.text ? 'a new case, not saved' : 'no case yet');
  }

  goTo(line) { this.area.goTo(line); }

  async ask() {
    if (!this.text.trim()) { this.found = []; this.area.errors = []; this.errors.replaceChildren(); this.list.replaceChildren(); this.regions = []; this.show(); return; }
    try {
      const found = await post('check', { text: this.text });
      this.found = found.errors;
      this.form.errors();
      this.area.errors = found.errors;
      this.errors.replaceChildren(found.errors.length === 0 ? h('p', { class: 'good' }, 'No errors in the text and its regions.')
        : h('ul', {}, found.errors.map((e) => h('li', {}, h('button', { type: 'button', onclick: () => this.goTo(e.line) }, `line ${e.line}`), ` ${e.message}`))),
      found.ground_changed && found.errors.length === 0 ? h('p', { class: 'hint' }, 'The surface, its repairs or its patches will be prepared anew when this is saved.') : '');
      this.regions = found.regions;
      document.documentElement.dataset.errors = String(found.errors.length);
    } catch (error) { this.errors.replaceChildren(h('p', { class: 'problem' }, error.message)); }
    this.listRegions();
    this.show();
  }

  listRegions() {
    this.list.replaceChildren(...this.regions.map((r) => h('div', { class: 'region' },
      tick(`${r.name}${r.fixed ? ' (fixed)' : ''}`, this.shownRegions.has(r.name), (v) => { this.shownRegions[v ? 'add' : 'delete'](r.name); this.show(); }),
      h('span', { class: 'hint' }, r.error ? r.error : `${r.triangles} triangles, area ${number(r.area)}`))));
  }

  /** What is held in blue, regions that are ticked in green. */
  show() {
    const { scene } = this.studio;
    if (!scene) return;
    const union = (list) => {
      if (list.length === 0) return null;
      const marks = new Uint8Array(scene.body.count);
      for (const r of list) marksOf(r.marks, marks.length).forEach((m, t) => { if (m) marks[t] = 1; });
      return marks;
    };
    const whole = this.regions.filter((r) => r.marks);
    scene.held = union(whole.filter((r) => r.fixed));
    scene.shown = union(whole.filter((r) => !r.fixed && this.shownRegions.has(r.name)));
    scene.paint();
  }

  async save() {
    const { studio } = this;
    try {
      const more = this.name ? {} : { name: this.newName.value || 'case.yaml' };
      const found = await post('save', { text: this.text, mark: this.mark, ...more });
      if (found.changed) {
        studio.tell(`${this.name || more.name} has been changed by another program and was not overwritten.`);
        this.other.replaceChildren(h('p', { class: 'problem' }, 'The file on the disk differs from what this page has read.'),
          h('button', { type: 'button', onclick: () => { this.replace(found.text, 'the file of the disk'); this.saved = found.text; this.mark = found.mark; this.name = this.name || more.name; this.other.replaceChildren(); } }, 'Take the file (Undo brings this text back)'),
          h('button', { type: 'button', onclick: () => { this.mark = found.mark; this.name = this.name || more.name; this.other.replaceChildren(); this.save(); } }, 'Overwrite the file'));
        return false;
      }
      this.mark = found.mark;
      this.name = found.name;
      this.saved = this.text;
      this.status();
      studio.tell(`${found.name} is saved.`);
      return true;
    } catch (error) { studio.tell(error.message); return false; }
  }

  async propose() {
    try { await post('propose', { name: this.newName.value || 'case.yaml' }); this.studio.tell('Strake tries ways to move this surface; that takes some seconds …'); } catch (error) { this.studio.tell(error.message); }
  }

  panel() {
    this.state = h('p', { class: 'kind' });
    this.other = h('div', {});
    this.newName = h('input', { type: 'text', value: 'case.yaml', size: 14, 'aria-label': 'Name of a new case' });
    this.fresh = h('div', { class: 'controls' }, h('button', { type: 'button', id: 'propose', class: 'main', onclick: () => this.propose() }, 'Propose a case'), h('label', { class: 'control' }, h('span', {}, 'as'), this.newName));
    this.status();
    return [this.state, this.fresh, this.other,
      h('div', { class: 'controls' }, h('button', { type: 'button', id: 'save', class: 'main', onclick: () => this.save() }, 'Save'),
        h('button', { type: 'button', onclick: () => post('full_check').then(() => this.studio.tell('strake check is at work …'), (e) => this.studio.tell(e.message)) }, 'Check all of the saved case')),
      this.errors, this.form.element, h('details', { class: 'yaml', open: true }, h('summary', {}, 'The file itself (YAML)'), this.area.element),
      h('h3', {}, 'Regions'), this.list, this.form.reasons];
  }
}
