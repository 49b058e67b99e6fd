// The lines of a case that decide what a run does, as a form beside its text.

import { h } from '../../../viewer/page/src/dom.js';
import { post, newest } from './api.js';

const groups = [
  ['Body', ['surface.units', 'symmetry', 'axes']],
  ['Held', ['fixed', 'hold']],
  ['Goal', ['objective', 'constraints']],
  ['Variables', ['parameters.variables', 'parameters.fields', 'parameters.levels', 'parameters.patches_per_level', 'parameters.max_displacement', 'parameters.mirror']],
  ['Search', ['optimize.method', 'optimize.budget.evaluations', 'optimize.budget.time', 'optimize.finite_differences', 'optimize.seed']],
];
const titles = { 'surface.units': 'unit of the coordinates', symmetry: 'half model, plane', axes: 'stream and up', hold: 'held otherwise', fixed: 'regions that do not move',
  'parameters.variables': 'variables of patches', 'parameters.fields': 'displacement fields', 'parameters.levels': 'levels of patches', 'parameters.patches_per_level': 'patches per level',
  'parameters.max_displacement': 'motion limit', 'parameters.mirror': 'keep it symmetric', 'optimize.method': 'method', 'optimize.budget.evaluations': 'evaluations',
  'optimize.budget.time': 'time', 'optimize.finite_differences': 'finite differences', 'optimize.seed': 'seed' };

export class Form {
  constructor(editor) {
    this.editor = editor;
    this.element = h('form', { class: 'form', 'aria-label': 'Case', onsubmit: (e) => e.preventDefault() });
    this.reasons = h('div', { class: 'reasons' });
    this.refresh = newest(() => this.ask());
  }

  async ask() {
    const found = await post('form', { text: this.editor.text });
    if (found.broken) { this.element.replaceChildren(h('p', { class: 'problem' }, `line ${found.line}: ${found.broken}`)); return; }
    this.facts = found;
    const active = document.activeElement && this.element.contains(document.activeElement) ? document.activeElement.id : null;
    this.element.replaceChildren(...groups.map(([title, paths]) => h('fieldset', {}, h('legend', {}, title), paths.map((path) => this.row(path)))));
    if (active) { const again = document.getElementById(active); if (again) again.focus(); }
    this.listReasons();
    this.errors();
    document.documentElement.dataset.form = String(this.element.querySelectorAll('input, select').length);
  }

  /** Errors of `check` stand at their rows, too. */
  errors() {
    const bad = new Map((this.editor.found || []).map((e) => [e.line, e.message]));
    for (const row of this.element.querySelectorAll('[data-line]')) {
      const words = bad.get(Number(row.dataset.line));
      row.classList.toggle('wrong', Boolean(words));
      const place = row.querySelector('.wrong-words');
      if (place) place.textContent = words || '';
    }
  }

  async set(values, why) {
    try {
      const { text } = await post('set', { text: this.editor.text, values });
      this.editor.replace(text, why || values.map(([path, value]) => `${path}: ${value || 'taken out'}`).join(', '));
    } catch (error) { this.editor.studio.tell(error.message); this.refresh(); }
  }

  row(path) {
    if (path === 'objective') return this.objective();
    if (path === 'constraints') return this.constraints();
    const facts = this.facts.rows.find((r) => r.path === path);
    if (!facts) return '';
    const id = `form-${path.replace(/\./g, '-')}`, change = (value) => this.set([[path, value]]);
    const words = facts.words.length > 0 && !facts.is_list;
    let input;
    if (facts.is_flag) input = h('input', { type: 'checkbox', id, checked: (facts.value || facts.default) === 'true', onchange: () => change(String(input.checked)) });
    else if (facts.is_list) input = this.ticks(id, facts, change);
    else {
      input = h('input', { type: 'text', id, value: facts.value, placeholder: facts.default ? `${facts.default} (default)` : '', spellcheck: 'false', autocomplete: 'off', list: words ? `${id}-words` : null,
        'aria-describedby': `${id}-doc`, onchange: () => change(input.value) });
    }
    return h('div', { class: 'row', 'data-line': facts.line || '' }, h('label', { for: facts.is_list ? null : id }, titles[path] || path),
      h('span', { class: 'field' }, input, words && !facts.is_flag ? h('datalist', { id: `${id}-words` }, facts.words.map((w) => h('option', { value: w }))) : '', this.reference(path, facts, id)),
      h('span', { class: 'wrong-words', 'aria-live': 'polite' }));
  }

  ticks(id, facts, change) {
    const has = new Set((facts.value || facts.default || '').replace(/[[\]\s]/g, '').split(',').filter(Boolean));
    return h('span', { class: 'ticks', id, role: 'group', 'aria-label': titles[facts.path] || facts.path }, facts.words.map((word) => {
      const box = h('input', { type: 'checkbox', id: `${id}-${word}`, checked: has.has(word), onchange: () => { if (box.checked) has.add(word); else has.delete(word); change(`[${facts.words.filter((w) => has.has(w)).join(', ')}]`); } });
      return h('label', { class: 'tick' }, box, word);
    }));
  }

  /** What the reference says of a key. */
  reference(path, facts, id) {
    return h('details', { class: 'reference' }, h('summary', { 'aria-label': `Reference of ${path}` }, '?'),
      h('p', { id: `${id}-doc` }, h('code', {}, path), ` ${facts.doc} `, h('span', { class: 'hint' }, [facts.form, facts.limits, facts.default ? `default ${facts.default}` : ''].filter(Boolean).join('; '))),
      facts.comment ? h('p', { class: 'hint' }, `In this case: ${facts.comment}`) : '');
  }

  quantityChoice(id, value, label, changed) {
    const { quantities, types } = this.facts, known = quantities.some((q) => q.name === value);
    const select = h('select', { id, 'aria-label': label, onchange: () => changed(select.value) },
      value && !known ? h('option', { value, selected: true }, value) : '', value ? '' : h('option', { value: '', selected: true }, '…'),
      h('optgroup', { label: 'of this case' }, quantities.map((q) => h('option', { value: q.name, selected: q.name === value, title: q.doc }, q.name))),
      h('optgroup', { label: 'to be declared' }, types.filter((t) => !quantities.some((q) => q.name === t.name || q.name.startsWith(`${t.name}.`))).map((t) => h('option', { value: `+${t.name}`, title: t.doc }, t.name))));
    return select;
  }

  /** Declares a type of quantities first, if need be. @return [values to set, its name] */
  declared(name) {
    if (!name.startsWith('+')) return [[], name];
    const type = name.slice(1);
    return [[[`quantities.${type}`, `{type: ${type}}`]], type];
  }

  objective() {
    const up = this.facts.rows.find((r) => r.path === 'objective.maximize'), down = this.facts.rows.find((r) => r.path === 'objective.minimize');
    const isUp = Boolean(up.value), value = (isUp ? up.value : down.value).replace(/^['"]|['"]$/g, '');
    const set = (way, name) => {
      const [first, known] = this.declared(name), quoted = /^[\w.@-]+$/.test(known) ? known : `'${known.replace(/'/g, "''")}'`;
      return this.set([...first, [`objective.${way === 'maximize' ? 'minimize' : 'maximize'}`, ''], [`objective.${way}`, quoted]].filter(([path, v]) => v || this.facts.rows.some((r) => r.path === path && r.value)), `${way} ${known}`);
    };
    const way = h('select', { id: 'form-objective-way', 'aria-label': 'Minimize or maximize', onchange: () => { if (value) set(way.value, value); } },
      h('option', { value: 'minimize', selected: !isUp }, 'minimize'), h('option', { value: 'maximize', selected: isUp }, 'maximize'));
    return h('div', { class: 'row', 'data-line': up.line || down.line || '' }, h('label', { for: 'form-objective' }, 'objective'),
      h('span', { class: 'field' }, way, this.quantityChoice('form-objective', value, 'Quantity of the objective', (name) => set(way.value, name)),
        this.reference('objective', { doc: 'What the run makes small or large: a quantity of the case, a built-in one, or a formula of them in the text.', form: '', limits: '', default: '', comment: up.comment || down.comment }, 'form-objective')),
      h('span', { class: 'wrong-words', 'aria-live': 'polite' }));
  }

  constraints() {
    const set = (one, changes, why) => {
      const next = { ...one, ...changes }, parts = ['min', 'max', 'equals'].filter((k) => next[k] !== '').map((k) => `${k}: ${next[k]}`);
      if (next.relative) parts.push('relative: true');
      return this.set([[`constraints.${one.name}`, parts.length > 0 ? `{${parts.join(', ')}}` : '']], why || `constraint ${one.name}`);
    };
    const list = this.facts.constraints.map((one, k) => h('div', { class: 'row constraint', 'data-line': one.line }, h('span', { class: 'name' }, one.name),
      h('span', { class: 'field' }, ['min', 'max', 'equals'].map((key) => {
        const input = h('input', { type: 'text', id: `constraint-${k}-${key}`, value: one[key], placeholder: key, size: 6, 'aria-label': `${one.name}, ${key}`, onchange: () => set(one, { [key]: input.value.trim() }) });
        return input;
      }), h('label', { class: 'tick' }, h('input', { type: 'checkbox', id: `constraint-${k}-relative`, checked: one.relative, onchange: (e) => set(one, { relative: e.target.checked }) }), '× start'),
      h('button', { type: 'button', class: 'quiet', 'aria-label': `Take out the constraint on ${one.name}`, onclick: () => this.set([[`constraints.${one.name}`, '']], `no constraint on ${one.name}`) }, '×')),
      h('span', { class: 'wrong-words', 'aria-live': 'polite' })));
    const more = this.quantityChoice('form-constraint', '', 'Add a constraint on', (name) => {
      const [first, known] = this.declared(name);
      this.set([...first, [`constraints.${known}`, '{min: 1, relative: true}']], `constraint ${known}`);
    });
    return [h('div', { class: 'row' }, h('label', { for: 'form-constraint' }, 'add a constraint on'), h('span', { class: 'field' }, more)), ...list];
  }

  /** What the case says about itself, each with a button that takes it out. */
  listReasons() {
    const kept = new Set(['surface', 'surface.file', 'objective', 'optimize', 'case']);
    const { reasons } = this.facts;
    this.reasons.replaceChildren(reasons.length === 0 ? '' : h('details', { open: reasons.length < 30 }, h('summary', {}, `Proposed, and why (${reasons.length})`),
      h('ul', { class: 'why' }, reasons.map((r) => h('li', {}, h('button', { type: 'button', class: 'link', onclick: () => this.editor.goTo(r.line) }, r.path), h('code', {}, r.value.split('\n')[0]), h('span', { class: 'hint' }, ` ${r.why} `),
        kept.has(r.path) ? '' : h('button', { type: 'button', class: 'quiet', 'aria-label': `Take out ${r.path}`, onclick: () => this.set([[r.path, '']], `${r.path} taken out`) }, 'take out'))))));
  }
}
