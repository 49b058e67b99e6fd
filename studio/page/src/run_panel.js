// A run: start, stop, resume, and what it does, as it comes.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { h, tick } from '../../../viewer/page/src/dom.js';
import { number, duration } from '../../../viewer/page/src/format.js';
import { post, bytes, newest } from './api.js';
import { Compare } from './compare.js';
import { Convergence } from './convergence.js';

export class RunPanel {
  constructor(studio) {
    this.studio = studio;
    this.rows = [];
    this.folder = '';
    this.best = 0;
    this.follows = true;
    this.fetchBest = newest(() => this.loadBest());
  }

  panel() {
    const button = (label, id, work, main) => h('button', { type: 'button', id, class: main && 'main', onclick: work }, label);
    this.evaluations = h('input', { type: 'number', min: 1, step: 1, value: '', size: 5, 'aria-label': 'Evaluations; empty: as the case says' });
    this.start = button('Start a run', 'start', () => this.begin(), true);
    this.stop = button('Stop', 'stop', () => this.ask('stop'));
    this.resume = button('Resume', 'resume', () => this.ask('resume', this.limit()));
    this.status = h('p', { 'aria-live': 'polite', class: 'status-line' }, 'No run is open.');
    this.reason = h('p', { class: 'hint reason' });
    this.plotPlace = h('div', { class: 'plot', role: 'img', 'aria-label': 'Objective of each evaluation' });
    this.last = h('ol', { class: 'last', reversed: true });
    this.links = h('p', {});
    this.compare = new Compare(this.studio);
    this.convergence = new Convergence();
    new ResizeObserver(() => { const width = this.plotPlace.clientWidth; if (this.plot && width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: 230 }); }).observe(this.plotPlace);
    this.draw();
    return [h('div', { class: 'controls' }, this.start, h('label', { class: 'control' }, h('span', {}, 'evaluations'), this.evaluations), this.stop, this.resume),
      this.status, this.reason, this.links, this.plotPlace, this.convergence.element,
      this.followTick = tick('show the best shape as it comes', this.follows, (v) => { this.follows = v; this.best = 0; if (!v) this.studio.scene.setPositions(this.studio.scene.body.start); else if (this.facts) this.show(this.facts); }),
      this.compare.element, h('h3', {}, 'Latest evaluations'), this.last];
  }

  /** As the tick says. */
  followAgain() { this.follows = this.followTick.querySelector('input').checked; this.best = 0; }

  /** In the colours of another theme. */
  redraw() { this.convergence.redraw(); if (this.plot) { this.plot.destroy(); this.plot = null; } this.draw(); }

  limit() { const n = this.evaluations.valueAsNumber; return Number.isInteger(n) && n > 0 ? { evaluations: n } : {}; }

  async begin() {
    const { editor } = this.studio;
    if (editor.isChanged && !(await editor.save())) return;
    await this.ask('run', this.limit());
  }

  async ask(what, more) {
    try { await post(what, more); this.studio.refresh(); } catch (error) { this.studio.tell(error.message); }
  }

  /** What the server says about the run, each time. */
  show(run) {
    if (run.folder !== this.folder) { this.folder = run.folder; this.rows = []; this.best = 0; }
    if (run.from === this.rows.length) this.rows.push(...run.rows);
    else if (run.evaluations < this.rows.length) this.rows = [];
    this.facts = run;
    const isRunning = run.status === 'running' || run.status === 'starting';
    this.stop.disabled = !isRunning;
    this.resume.disabled = isRunning;
    this.status.textContent = run.evaluations === undefined ? `${run.status}: ${run.reason}`
      : `${run.status}, ${run.evaluations} of ${run.max_evaluations} evaluations, level ${run.level}, ${duration(run.seconds)}${run.best_evaluation > 0 ? `, best ${number(run.objective, 6)} at evaluation ${run.best_evaluation}` : ''}`;
    this.reason.textContent = `${run.folder}${run.reason && run.evaluations !== undefined ? `: ${run.reason}` : ''}`;
    this.links.replaceChildren(run.has_report && !isRunning ? h('a', { href: 'report', target: '_blank', rel: 'noopener', id: 'report-link' }, 'The report of this run') : '');
    document.documentElement.dataset.run = run.status;
    document.documentElement.dataset.rows = String(this.rows.length);
    if (this.rows.length !== this.drawn) this.draw();
    this.convergence.follow(run);
    if (this.follows && run.best_evaluation > 0 && run.best_evaluation !== this.best) { this.best = run.best_evaluation; this.fetchBest(); }
  }

  async loadBest() {
    const { scene } = this.studio;
    try {
      const p = new Float32Array(await bytes('api/best'));
      if (scene && p.length === scene.body.start.length) scene.setPositions(p);
    } catch { /* not written yet, or of other triangles: the start stays */ }
  }

  draw() {
    this.drawn = this.rows.length;
    const x = this.rows.map((r) => r[0]), y = this.rows.map((r) => r[3]), best = this.rows.map((r) => (r[6] ? r[3] : null));
    const ink = getComputedStyle(document.documentElement).getPropertyValue('--ink').trim() || '#1c2229';
    const axis = { stroke: ink, grid: { stroke: '#8884' }, ticks: { stroke: '#8884' } };
    if (!this.plot && this.rows.length > 0) {
      this.plot = new uPlot({ width: Math.max(260, this.plotPlace.clientWidth || 380), height: 230, scales: { x: { time: false } }, legend: { show: false },
        axes: [{ ...axis, label: 'evaluation' }, { ...axis, size: 70, values: (_, ticks) => ticks.map((v) => number(v, 5)) }],
        series: [{}, { stroke: '#0072b2', width: 1, points: { show: x.length < 300 } }, { stroke: '#d55e00', paths: () => null, points: { show: true, size: 8, fill: '#d55e00' } }] }, [x, y, best], this.plotPlace);
    } else if (this.plot) this.plot.setData([x, y, best]);
    if (!this.last) return;
    this.last.replaceChildren(...this.rows.slice(-12).reverse().map(([n, level, status, J, violation, seconds, isBest, why]) => h('li', { value: n },
      status === 'ok' ? `level ${level}: ${number(J, 7)}, violation ${number(violation, 2)}, ${duration(seconds)}${isBest ? ', best so far' : ''}` : `level ${level}: ${status}: ${why}`)));
  }
}
