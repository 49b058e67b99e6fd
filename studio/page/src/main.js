// The page of `strake studio`.

import './studio.css';
import { h, choice } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { get, post, bytes, silence } from './api.js';
import { Body } from './body.js';
import { Scene3D } from './scene.js';
import { lookPanel, viewControls } from './look.js';
import { Choosing } from './choose.js';
import { Editor } from './case_panel.js';
import { Feel } from './feel.js';
import { RunPanel } from './run_panel.js';
import { History } from './history.js';
import { Section } from './section_panel.js';
import { gradient } from '../../../viewer/page/src/colors.js';

const reading = 'Reading the surface, its patches and its defects …';
const tabs = [['look', 'Surface'], ['choose', 'Choose'], ['case', 'Case'], ['feel', 'Feel'], ['run', 'Run']];

class Studio {
  constructor(place) {
    this.version = -1;
    this.history = new History(() => this.showHistory());
    this.editor = new Editor(this);
    this.feel = new Feel(this);
    this.runs = new RunPanel(this);
    this.section = new Section(this);
    this.message = h('p', { class: 'told', role: 'status', 'aria-live': 'polite' }, '');
    this.folder = h('p', { class: 'kind' });
    this.files = h('div', { class: 'controls files' });
    this.canvas = null;
    this.stage = h('div', { class: 'stage' });
    this.view = h('div', { class: 'controls toolbar' });
    this.pointer = h('output', { class: 'pointer' }, ' ');
    this.legend = h('div', { class: 'legend', hidden: true });
    this.marks = Object.fromEntries([['chosen', 'chosen'], ['held', 'fixed'], ['region', 'other regions']].map(([kind, words]) => [kind, h('span', { hidden: true }, h('span', { class: `swatch ${kind}` }), words)]));
    this.key = h('p', { class: 'hint key' }, Object.values(this.marks));
    this.undo = h('button', { type: 'button', id: 'undo', disabled: true, 'aria-label': 'Undo', onclick: () => this.history.undo() }, '↶ Undo');
    this.redo = h('button', { type: 'button', id: 'redo', disabled: true, 'aria-label': 'Redo', onclick: () => this.history.redo() }, '↷');
    this.theme = h('button', { type: 'button', id: 'theme', 'aria-label': 'Light or dark', title: 'Light or dark', onclick: () => this.turnTheme() }, '◐');
    this.panels = Object.fromEntries(tabs.map(([id, words]) => [id, h('section', { id: `panel-${id}`, role: 'tabpanel', 'aria-label': words, tabindex: -1 })]));
    this.buttons = Object.fromEntries(tabs.map(([id, words], k) => [id, h('button', { type: 'button', role: 'tab', id: `tab-${id}`, 'aria-controls': `panel-${id}`, onclick: () => this.open(id) }, h('span', { class: 'step', 'aria-hidden': 'true' }, String(k + 1)), words)]));
    this.bar = h('div', { role: 'tablist', 'aria-label': 'Steps', class: 'tabs', onkeydown: (e) => this.keys(e) }, Object.values(this.buttons));
    place.append(h('header', {}, h('h1', {}, h('span', { class: 'mark', 'aria-hidden': 'true' }), 'Strake studio'), this.folder, this.files, h('span', { class: 'right-end' }, this.undo, this.redo, this.theme)), this.message,
      h('div', { class: 'columns' }, h('div', { class: 'left' }, this.view, h('div', { class: 'frame' }, this.stage, this.legend), this.section.element, this.pointer,
        this.key,
        h('p', { class: 'hint', id: 'view-keys' }, 'Drag to turn, scroll or pinch to zoom, right button to pan. Keyboard: arrow keys turn, + and \u2212 zoom, Home resets, Enter chooses what is in the middle.')),
      h('div', { class: 'right' }, this.bar, Object.values(this.panels))));
    this.panels.case.append(...this.editor.panel());
    this.panels.feel.append(...this.feel.panel());
    this.panels.run.append(...this.runs.panel());
    window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.scene && this.scene.setBackground());
    document.addEventListener('keydown', (e) => {
      if (!(e.ctrlKey || e.metaKey) || e.key.toLowerCase() !== 'z' || /^(INPUT|TEXTAREA)$/.test(e.target.tagName) && e.target.type !== 'range') return;
      e.preventDefault();
      if (e.shiftKey) this.history.redo(); else this.history.undo();
    });
    this.open('look');
  }

  showHistory() {
    const { next, again } = this.history;
    this.undo.disabled = !next;
    this.redo.disabled = !again;
    this.undo.title = next ? `Undo: ${next}` : 'Nothing to undo';
    this.redo.title = again ? `Redo: ${again}` : 'Nothing to redo';
  }

  /** Light, dark, as the system. */
  turnTheme() {
    const { dataset } = document.documentElement, isDark = dataset.theme ? dataset.theme === 'dark' : window.matchMedia('(prefers-color-scheme: dark)').matches;
    dataset.theme = isDark ? 'light' : 'dark';
    if (this.scene) this.scene.setBackground();
    this.runs.redraw();
  }

  /** What can be dragged on the surface now. */
  handles() {
    if (!this.scene) return;
    const list = [];
    if (this.section.isOn) {
      const { normal } = this.section;
      list.push({ at: normal.map((v) => v * this.section.at), along: normal, color: 0xd5005e, words: 'section', moved: (length) => this.section.moveBy(length) });
    }
    if (this.tab === 'choose' && this.choosing) list.push(...this.choosing.handleList());
    this.scene.setHandles(list);
  }

  /** Lengths and angles between points of the surface. */
  measure(point) {
    this.ruler = this.ruler && this.ruler.length < 3 ? [...this.ruler, point] : [point];
    const c = this.scene.body.center, at = this.ruler.map((p) => p.map((v, k) => v - c[k]));
    this.scene.setLines('ruler', at.length > 1 ? [at] : [], 0x7b3fa0);
    this.scene.setKnots(at);
    if (at.length === 1) { this.tell('Ruler: a second point gives the length, a third one the angle.'); return; }
    const d = (a, b) => b.map((v, k) => v - a[k]), size = (v) => Math.hypot(...v), first = d(at[0], at[1]);
    let words = `Ruler: ${number(size(first), 6)} (${first.map((v) => number(v, 5)).join(', ')})`;
    if (at.length === 3) {
      const u = d(at[1], at[0]), w = d(at[1], at[2]), cosine = u.reduce((sum, v, k) => sum + v * w[k], 0) / (size(u) * size(w) || 1);
      words += `, then ${number(size(w), 6)}; angle ${number((Math.acos(Math.min(1, Math.max(-1, cosine))) * 180) / Math.PI, 5)}°`;
    }
    this.tell(words);
    document.documentElement.dataset.ruler = words;
  }

  setTool(tool) {
    this.stageTool = this.stageTool === tool ? null : tool;
    this.toolButtons.measure.setAttribute('aria-pressed', String(this.stageTool === 'measure'));
    this.ruler = null;
    this.scene.setLines('ruler', [], 0);
    this.scene.setKnots([]);
    if (this.stageTool === 'measure') this.tell('Ruler: click two points of the surface for a length, a third for an angle.');
  }

  showLegend(field) {
    this.legend.hidden = !field;
    if (!field) return;
    const bar = h('span', { class: 'bar', role: 'img', 'aria-label': 'Colour scale', style: `background:${gradient(field.scale.map)}` });
    this.legend.replaceChildren(h('span', { class: 'what' }, field.words), h('span', {}, number(field.scale.low, 3)), bar, h('span', {}, number(field.scale.high, 3)));
  }

  tell(words) { this.message.textContent = words; }

  open(id) {
    this.tab = id;
    for (const [name] of tabs) {
      this.panels[name].hidden = name !== id;
      this.buttons[name].setAttribute('aria-selected', String(name === id));
      this.buttons[name].tabIndex = name === id ? 0 : -1;
    }
    if (this.scene) {
      if (id !== 'choose') { this.scene.hint(null, null); this.scene.chosen = null; this.scene.paint(); } else this.choosing.update();
      this.handles();
      this.scene.viewer.controls.enabled = true;
      if (id !== 'run') { this.runs.compare.element.open = false; this.runs.compare.end(); }
      if (id === 'feel') this.feel.show(); else this.feel.hide();
    }
  }

  keys(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const ids = tabs.map(([id]) => id), next = ids[(ids.indexOf(this.tab) + step + ids.length) % ids.length];
    this.open(next);
    this.buttons[next].focus();
  }

  async listFiles() {
    const { cases, surfaces, runs } = await get('api/files');
    const all = [...cases.map((n) => [n, `case ${n}`]), ...surfaces.map((n) => [n, `surface ${n}`]), ...runs.map((n) => [n, `run ${n}`])];
    if (all.length === 0) { this.files.replaceChildren(h('p', {}, 'This folder has no surface and no case.')); return; }
    const select = choice('Files of the folder', all, all[0][0], () => {});
    this.files.replaceChildren(select, h('button', { type: 'button', onclick: () => {
      if (this.editor.isChanged && this.editor.text && !window.confirm('The case in the editor is not saved. Leave it?')) return;
      this.editor.saved = this.editor.text;
      post('open', { name: select.querySelector('select').value }).then(() => this.refresh(), (e) => this.tell(e.message));
    } }, 'Open'));
  }

  lose() {
    this.isLost = true;
    this.tell('The studio does not answer. A run that it started goes on; this page finds its way back when the same address answers.');
  }

  async refresh() {
    let state;
    try { state = await get(`api/state?from=${this.runs.rows.length}`); } catch { this.lose(); return; }
    if (this.isLost) {  // the studio was started again: it opens what this page shows, after what it opens by itself
      if (state.is_opening) { this.tell(reading); this.wasOpening = true; return; }
      this.isLost = false;
      this.version = -1;
      this.tell('');
      if (this.editor.name && state.case !== this.editor.name && !state.is_opening) {
        try { await post('open', { name: this.editor.name }); return; } catch (error) { this.tell(error.message); }
      }
    }
    this.folder.textContent = `${state.folder}${state.read_only ? ' (read-only)' : ''}${state.is_second ? ' (another studio is open on this folder)' : ''}${state.surface ? ` · ${state.surface}` : ''}`;
    document.documentElement.dataset.opening = String(state.is_opening);
    if (state.version !== this.version && !state.is_opening) {
      this.version = state.version;
      try { await this.load(state); } catch (error) {
        if (!error.isAnswer) { this.lose(); return; }
        this.tell(error.message);
      }
    } else if (state.is_opening && !this.wasOpening) this.tell(reading);
    this.wasOpening = state.is_opening;
    this.showTask(state.task);
    if (state.disk_mark && this.editor.mark && state.disk_mark !== this.editor.mark && !state.is_opening) this.tell(`${state.case} has been changed by another program; Save will ask before it overwrites anything.`);
    if (state.run) {
      if (state.run_messages && state.run.status === 'starting') { state.run.status = 'failed'; state.run.reason = state.run_messages; }
      this.runs.show(state.run);
    }
  }

  showTask(task) {
    const key = task && `${task.name} ${task.is_running} ${task.status} ${task.output.length}`;
    if (key === this.taskKey) return;
    this.taskKey = key;
    if (!task || task.is_running) return;
    let words = task.messages.trim();
    if (task.name === 'check') {
      let found = {};
      try { found = JSON.parse(task.output); } catch { /* words of stderr */ }
      if (found.errors) this.editor.errors.replaceChildren(h('ul', {}, found.errors.map((e) => h('li', {}, h('button', { type: 'button', onclick: () => this.editor.goTo(e.line) }, `line ${e.line}`), ` ${e.message}`))));
      words = task.status === 0 ? ['strake check: no errors.', ...(found.warnings || [])].join(' ') : `strake check: ${(found.errors || []).length || ''} errors. ${found.errors ? '' : words}`;
    } else if (task.status === 0) words = 'The proposed case is open, with its reasons in the comments.';
    this.tell(words);
    document.documentElement.dataset.task = `${task.name}: ${task.status}`;
  }

  async load(state) {
    this.tell(state.trouble);
    await this.editor.load();
    this.editor.fresh.hidden = Boolean(state.case) || !state.surface;
    await this.listFiles();
    if (state.has_surface) {
      const surface = await bytes('api/surface', silence);
      try { this.build(Body.read(surface)); } catch (error) {
        this.tell(`The surface cannot be shown: ${error.message}. The view needs WebGL.`);
        console.warn(error);
      }
    }
    if (state.case && this.tab === 'look' && state.trouble) this.open('case');
    document.documentElement.dataset.ready = String(state.version);
  }

  build(body) {
    const was = this.scene && this.scene.viewer, before = was && this.scene.body.count === body.count ? was.camera.position.clone() : null;
    const up = was && [was.up, was.isDown].join();
    if (this.scene) this.scene.dispose();
    this.canvas = h('canvas', { class: 'view', tabindex: 0, role: 'img', 'aria-label': 'The surface in three dimensions', 'aria-describedby': 'view-keys' });
    const labels = h('div', { class: 'labels', 'aria-hidden': 'true' });
    this.band = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    this.band.setAttribute('class', 'band');
    this.band.setAttribute('hidden', '');
    this.band.setAttribute('aria-hidden', 'true');
    this.band.append(document.createElementNS('http://www.w3.org/2000/svg', 'polygon'));
    this.stage.replaceChildren(this.canvas, labels, this.band);
    this.scene = new Scene3D(this.canvas, labels, body);
    this.scene.onfield = (field) => this.showLegend(field);
    this.scene.onmarks = (shown) => { for (const kind in this.marks) this.marks[kind].hidden = !(shown[kind] && shown[kind].includes(1)); };
    this.scene.onshape = () => this.section.update();
    this.showLegend(null);
    this.ruler = this.stageTool = null;
    if (before && up === [this.scene.viewer.up, this.scene.viewer.isDown].join()) { this.scene.viewer.lookAs(was, before); }
    this.choosing = new Choosing(this);
    this.panels.look.replaceChildren(...lookPanel(this.scene, this.editor, this.nextStep()).flat(4));
    this.toolButtons = { cut: h('button', { type: 'button', id: 'cut', 'aria-pressed': String(this.section.isOn), onclick: () => this.section.toggle() }, '✂ Section'),
      measure: h('button', { type: 'button', id: 'measure', 'aria-pressed': 'false', onclick: () => this.setTool('measure') }, '⟷ Ruler') };
    this.view.replaceChildren(...viewControls(this.scene), h('span', { class: 'buttons', role: 'group', 'aria-label': 'Tools' }, Object.values(this.toolButtons)));
    this.section.reset();
    this.panels.choose.replaceChildren(...this.choosing.panel());
    this.listen();
    this.editor.show();
    this.open(this.tab);
    this.runs.best = 0;
  }

  /** The way on from here, one button. */
  nextStep() {
    if (this.editor.text.trim()) return h('p', { class: 'next' }, h('button', { type: 'button', class: 'main', onclick: () => this.open('choose') }, 'Next: choose what does not move'));
    return h('p', { class: 'next' }, h('button', { type: 'button', class: 'main', id: 'propose-first', onclick: () => { this.open('case'); this.editor.propose(); } }, 'Next: let Strake propose a case'),
      h('span', { class: 'hint' }, ' It tries ways to move the body and says why it chose one. All of it can be changed.'));
  }

  listen() {
    const { canvas, scene } = this, place = (e) => { const b = canvas.getBoundingClientRect(); return [e.clientX - b.left, e.clientY - b.top]; };
    let from = null, waiting = null, held = null, line = null;
    canvas.addEventListener('pointerdown', (e) => {
      from = place(e);
      held = e.button === 0 && !e.shiftKey ? scene.handleAt(...from) : null;
      const draws = !held && this.tab === 'choose' && ['rectangle', 'lasso'].includes(this.choosing.tool) && !this.stageTool && !e.shiftKey && e.button === 0;
      scene.viewer.controls.enabled = !draws && !held;
      if (draws || held) canvas.setPointerCapture(e.pointerId);
      line = draws ? [from] : null;
      this.lastPlace = from;
    }, { capture: true });
    canvas.addEventListener('pointermove', (e) => {
      const [x, y] = place(e);
      if (held) {
        const length = scene.lengthAlong(held, x - this.lastPlace[0], y - this.lastPlace[1]);
        this.lastPlace = [x, y];
        if (length !== 0) { const { words } = held; held.moved(length); held = scene.handles.find((one) => one.words === words) || null; }
        return undefined;
      }
      if (line) {
        if (this.choosing.tool === 'lasso') { line.push([x, y]); this.stroke(line); } else { line = [from, [x, from[1]], [x, y], [from[0], y]]; this.stroke(line); }
        return undefined;
      }
      if (e.buttons || waiting) return undefined;
      canvas.classList.toggle('grabs', Boolean(scene.handleAt(x, y)));
      waiting = requestAnimationFrame(() => { waiting = null; this.point(scene.at(x, y)); });
      return undefined;
    });
    canvas.addEventListener('pointerup', (e) => {
      const to = place(e), drawn = line, wasHeld = held;
      line = held = null;
      scene.viewer.controls.enabled = true;
      if (drawn) {
        this.stroke(null);
        if (drawn.length > 2) this.choosing.enclose(drawn);
      } else if (!wasHeld && from && Math.hypot(to[0] - from[0], to[1] - from[1]) < 4 && e.button === 0) this.pick(to);
      from = null;
    });
    canvas.addEventListener('keydown', (e) => { if (e.key === 'Enter') this.pick([scene.viewer.width / 2, scene.viewer.height / 2]); });
  }

  /** The line that is being drawn over the view; null: none. */
  stroke(line) {
    this.band.toggleAttribute('hidden', !line);
    if (line) this.band.firstChild.setAttribute('points', line.map((p) => p.map((v) => v.toFixed(1)).join(',')).join(' '));
  }

  pick([x, y]) {
    const place = this.scene.at(x, y);
    this.point(place);
    if (place && this.stageTool === 'measure') this.measure(place.point);
    else if (place && this.tab === 'choose') this.choosing.pick(place);
  }

  /** What is under the pointer. */
  point(place) {
    if (!place) { this.pointer.textContent = ' '; return; }
    const { body } = this.scene, { facts } = body, t = place.triangle, number_ = body.inFile(t);
    const patches = facts.levels.map((level) => level.patches[body.array(level.array)[t]]);
    const part = facts.parts.length > 0 ? `part ${facts.parts[body.array('part')[t]]}, ` : '';
    const of = this.editor.regions.filter((r) => r.marks && (atob(r.marks).charCodeAt(t >> 3) >> (t & 7)) & 1).map((r) => r.name);
    this.pointer.textContent = `(${place.point.map((v) => number(v, 5)).join(', ')})  ${part}connected part ${body.array('component')[t]}, ${patches.length ? `patch ${patches.join(' / ')}, ` : ''}triangle ${number_ === null ? `${t} (made by repair)` : number_}${of.length ? `, in ${of.join(', ')}` : ''}`;
  }

  /** Asks while the page is visible, more often while something goes on. */
  async live() {
    try {
      if (!document.hidden) await this.refresh();
    } finally {
      const isBusy = this.wasOpening || (this.runs.facts && ['running', 'starting'].includes(this.runs.facts.status));
      setTimeout(() => this.live(), isBusy ? 200 : 500);
    }
  }
}

const studio = new Studio(document.getElementById('studio'));
window.strakeStudio = studio;
window.addEventListener('beforeunload', (event) => { if (studio.editor.isChanged && studio.editor.text.trim()) event.preventDefault(); });
studio.live();
