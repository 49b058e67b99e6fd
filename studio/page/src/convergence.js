// How the solver of an evaluation converges, from the file that the case names.

import uPlot from 'uplot';
import { h } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { get, newest } from './api.js';

const hues = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9'], most = hues.length;

/** What is drawn of a column: the logarithm of what is positive and falls or rises by more than a factor of ten. */
function drawn(name, values) {
  const known = values.filter((v) => v !== null), least = Math.min(...known), greatest = Math.max(...known);
  if (known.length > 0 && least > 0 && greatest > 10 * least) return { words: `log₁₀ ${name}`, values: values.map((v) => (v === null ? null : Math.log10(v))) };
  return { words: name, values };
}

const isResidual = (name) => /res|rms|initial|^U[xyz]?$|^p(_rgh)?$|^(k|omega|epsilon|nuTilda|rho|e|h)$/i.test(name);

export class Convergence {
  constructor() {
    this.name = '';  // empty: the newest
    this.hidden = null;
    this.of = h('select', { 'aria-label': 'Evaluation whose convergence is shown', onchange: (e) => { this.name = e.target.value; this.update(); } });
    this.toggles = h('span', { class: 'buttons', role: 'group', 'aria-label': 'Columns shown' });
    this.place = h('div', { class: 'plot', role: 'img', 'aria-label': 'Convergence of the solver' });
    this.words = h('p', { class: 'hint', id: 'convergence-words' });
    this.element = h('details', { id: 'convergence', open: true, hidden: true }, h('summary', {}, 'Convergence of the solver'), h('div', { class: 'controls' }, this.of), this.words, this.place, this.toggles);
    this.update = newest(() => this.load());
    this.time = 0;
  }

  /** Called whenever the state of the run is known; asks at most once a second. */
  follow(run) {
    this.element.hidden = !run.has_convergence;
    if (this.element.hidden || !this.element.open || performance.now() - this.time < 1000) return;
    const isOver = !['running', 'starting'].includes(run.status), key = `${run.folder} ${run.status} ${run.evaluations}`;
    if (isOver && key === this.key) return;
    this.key = key;
    this.time = performance.now();
    this.update();
  }

  async load() {
    let found;
    try { found = await get(`api/convergence?name=${encodeURIComponent(this.name)}`); } catch (error) { this.words.textContent = error.message; return; }
    const several = new Set(found.files.map((f) => f.program)).size > 1;
    const key = found.files.map((f) => f.name).join('\n');
    if (key !== this.listed) {
      this.listed = key;
      this.of.replaceChildren(h('option', { value: '' }, 'the newest evaluation'), ...found.files.map((f) => h('option', { value: f.name }, `evaluation ${f.evaluation}${several ? `, ${f.program}` : ''}`)));
      this.of.value = this.name;
    }
    const rows = found.columns.length > 0 ? found.columns[0].length : 0;
    document.documentElement.dataset.convergence = `${found.shown} ${rows}`;
    this.words.textContent = found.files.length === 0 ? 'No evaluation has written its file yet.' : rows === 0 ? `${found.shown}: no numbers yet` : `${found.shown}, ${rows} rows shown`;
    if (rows > 0) this.draw(found);
  }

  draw({ names, columns }) {
    const first = columns[0], rises = first.every((v, k) => v !== null && (k === 0 || v > first[k - 1]));
    const isCount = (column) => column.every((v, k) => v !== null && (k === 0 || v >= column[k - 1]) && Number.isInteger(v));
    const step = rises ? -1 : columns.findIndex((column, k) => k > 0 && isCount(column) && column[column.length - 1] > column[0]);
    const x = rises ? first : step > 0 ? columns[step] : first.map((_, k) => k + 1);
    const shown = names.map((name, k) => ({ name, ...drawn(name, columns[k]) })).filter((c, k) => k > 0 && k !== step && new Set(columns[k]).size > 1);
    const key = shown.map((c) => c.name).join('\n');
    if (key !== this.columns) {
      this.columns = key;
      const wished = shown.filter((c) => isResidual(c.name)), first6 = (wished.length > 0 ? wished : shown).slice(0, most);
      this.hidden = new Set(shown.filter((c) => !first6.includes(c)).map((c) => c.name));
      if (this.plot) { this.plot.destroy(); this.plot = null; }
    }
    const words = shown.map((c) => c.words).join('\n');
    if (this.plot && words !== this.drawnWords) { this.plot.destroy(); this.plot = null; }
    this.drawnWords = words;
    const data = [x, ...shown.map((c) => c.values)];
    if (this.plot) { this.plot.setData(data); return; }
    const ink = getComputedStyle(document.documentElement).getPropertyValue('--ink').trim() || '#1c2229';
    const axis = { stroke: ink, grid: { stroke: '#8884' }, ticks: { stroke: '#8884' } };
    const hue = (k) => hues[k % most], dash = (k) => (k < most ? [] : [6, 3]);
    this.plot = new uPlot({ width: Math.max(260, this.place.clientWidth || 380), height: 200, scales: { x: { time: false } }, legend: { show: false },
      axes: [{ ...axis, label: rises ? names[0] : step > 0 ? names[step] : 'row' }, { ...axis, size: 60, values: (_, ticks) => ticks.map((v) => number(v, 4)) }],
      series: [{}, ...shown.map((c, k) => ({ stroke: hue(k), dash: dash(k), width: 1.5, spanGaps: true, show: !this.hidden.has(c.name), points: { show: x.length < 3 } }))] }, data, this.place);
    this.toggles.replaceChildren(...shown.map((c, k) => h('button', { type: 'button', 'aria-pressed': String(!this.hidden.has(c.name)), onclick: (e) => {
      const isOn = this.hidden.delete(c.name);
      if (!isOn) this.hidden.add(c.name);
      e.currentTarget.setAttribute('aria-pressed', String(isOn));
      this.plot.setSeries(k + 1, { show: isOn });
    } }, h('i', { class: 'trace', 'aria-hidden': 'true', style: `border-top-color:${hue(k)};border-top-style:${k < most ? 'solid' : 'dashed'}` }), c.words)));
  }

  redraw() { if (this.plot) { this.plot.destroy(); this.plot = null; } this.columns = ''; this.key = ''; }
}
