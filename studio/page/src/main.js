// The page of `strake studio`.

import './studio.css';
import { h, choice } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { get, post, bytes } from './api.js';
import { Body } from './body.js';
import { Scene3D } from './scene.js';
import { lookPanel, viewControls } from './look.js';
import { Choosing } from './choose.js';
import { Editor } from './case_panel.js';
import { Feel } from './feel.js';
import { RunPanel } from './run_panel.js';

const tabs = [['look', 'Surface'], ['choose', 'Choose'], ['case', 'Case'], ['feel', 'Feel'], ['run', 'Run']];

class Studio {
  constructor(place) {
    this.version = -1;
    this.editor = new Editor(this);
    this.feel = new Feel(this);
    this.runs = new RunPanel(this);
    this.message = h('p', { class: 'told', role: 'status', 'aria-live': 'polite' }, '');
    this.folder = h('p', { class: 'kind' });
    this.files = h('div', { class: 'controls' });
    this.canvas = null;
    this.stage = h('div', { class: 'stage' });
    this.view = h('div', { class: 'controls' });
    this.pointer = h('output', { class: 'pointer' }, ' ');
    this.panels = Object.fromEntries(tabs.map(([id, words]) => [id, h('section', { id: `panel-${id}`, role: 'tabpanel', 'aria-label': words, tabindex: -1 })]));
    this.buttons = Object.fromEntries(tabs.map(([id, words]) => [id, h('button', { type: 'button', role: 'tab', id: `tab-${id}`, 'aria-controls': `panel-${id}`, onclick: () => this.open(id) }, words)]));
    this.bar = h('div', { role: 'tablist', 'aria-label': 'Steps', class: 'tabs', onkeydown: (e) => this.keys(e) }, Object.values(this.buttons));
    place.append(h('header', {}, h('h1', {}, 'Strake studio'), this.folder, this.files), this.message,
      h('div', { class: 'columns' }, h('div', { class: 'left' }, this.view, this.stage, this.pointer,
        h('p', { class: 'hint', id: 'view-keys' }, 'Drag to turn, scroll or pinch to zoom, right button to pan. Keyboard: arrow keys turn, + and \u2212 zoom, Home resets, Enter chooses what is in the middle.'),
        h('p', { class: 'hint key' }, h('span', { class: 'swatch chosen' }), 'chosen ', h('span', { class: 'swatch held' }), 'fixed ', h('span', { class: 'swatch region' }), 'other regions shown')),
      h('div', { class: 'right' }, this.bar, Object.values(this.panels))));
    this.panels.case.append(...this.editor.panel());
    this.panels.feel.append(...this.feel.panel());
    this.panels.run.append(...this.runs.panel());
    this.open('look');
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
      this.scene.viewer.controls.enabled = true;
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

  async refresh() {
    let state;
    try { state = await get(`api/state?from=${this.runs.rows.length}`); } catch (error) {
      this.isLost = true;
      this.tell('The studio does not answer. A run that it started goes on; this page finds its way back when the same address answers.');
      return;
    }
    if (this.isLost) { this.isLost = false; this.tell(''); }
    this.folder.textContent = `${state.folder}${state.read_only ? ' (read-only)' : ''}${state.is_second ? ' (another studio is open on this folder)' : ''}${state.surface ? ` · ${state.surface}` : ''}`;
    document.documentElement.dataset.opening = String(state.is_opening);
    if (state.version !== this.version && !state.is_opening) {
      this.version = state.version;
      await this.load(state);
    } else if (state.is_opening && !this.wasOpening) this.tell('Reading the surface, its patches and its defects …');
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
      try { this.build(Body.read(await bytes('api/surface'))); } catch (error) {
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
    this.band = h('div', { class: 'band', hidden: true });
    this.stage.replaceChildren(this.canvas, labels, this.band);
    this.scene = new Scene3D(this.canvas, labels, body);
    if (before && up === [this.scene.viewer.up, this.scene.viewer.isDown].join()) { this.scene.viewer.camera.position.copy(before); this.scene.viewer.controls.update(); this.scene.viewer.fit(); this.scene.viewer.draw(); }
    this.choosing = new Choosing(this.scene, this.editor, (words) => this.tell(words));
    this.panels.look.replaceChildren(...lookPanel(this.scene).flat(4));
    this.view.replaceChildren(...viewControls(this.scene));
    this.panels.choose.replaceChildren(...this.choosing.panel());
    this.listen();
    this.editor.show();
    this.open(this.tab);
    this.runs.best = 0;
  }

  listen() {
    const { canvas, scene } = this, place = (e) => { const b = canvas.getBoundingClientRect(); return [e.clientX - b.left, e.clientY - b.top]; };
    let from = null, waiting = null;
    canvas.addEventListener('pointerdown', (e) => {
      from = place(e);
      const drags = this.tab === 'choose' && this.choosing.tool === 'rectangle' && !e.shiftKey && e.button === 0;
      scene.viewer.controls.enabled = !drags;
      if (drags) { canvas.setPointerCapture(e.pointerId); this.dragging = true; }
    }, { capture: true });
    canvas.addEventListener('pointermove', (e) => {
      const [x, y] = place(e);
      if (this.dragging) return this.stretch(from, [x, y]);
      if (e.buttons || waiting) return undefined;
      waiting = requestAnimationFrame(() => { waiting = null; this.point(scene.at(x, y)); });
      return undefined;
    });
    canvas.addEventListener('pointerup', (e) => {
      const to = place(e);
      if (this.dragging) {
        this.dragging = false;
        this.band.hidden = true;
        scene.viewer.controls.enabled = true;
        this.choosing.rectangle(Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.max(from[0], to[0]), Math.max(from[1], to[1]));
      } else if (from && Math.hypot(to[0] - from[0], to[1] - from[1]) < 4 && e.button === 0) this.pick(to);
      from = null;
    });
    canvas.addEventListener('keydown', (e) => { if (e.key === 'Enter') this.pick([scene.viewer.width / 2, scene.viewer.height / 2]); });
  }

  stretch(from, to) {
    this.band.hidden = false;
    Object.assign(this.band.style, { left: `${Math.min(from[0], to[0])}px`, top: `${Math.min(from[1], to[1])}px`, width: `${Math.abs(to[0] - from[0])}px`, height: `${Math.abs(to[1] - from[1])}px` });
  }

  pick([x, y]) {
    const place = this.scene.at(x, y);
    this.point(place);
    if (place && this.tab === 'choose') this.choosing.pick(place);
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
    if (!document.hidden) await this.refresh();
    const isBusy = this.wasOpening || (this.runs.facts && ['running', 'starting'].includes(this.runs.facts.status));
    setTimeout(() => this.live(), isBusy ? 200 : 500);
  }
}

const studio = new Studio(document.getElementById('studio'));
window.strakeStudio = studio;
window.addEventListener('beforeunload', (event) => { if (studio.editor.isChanged && studio.editor.text.trim()) event.preventDefault(); });
studio.live();
