// Objective, values and variables over the evaluations, with levels marked.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { h, section, choice } from '../../../viewer/page/src/dom.js';
import { number, parameterValue } from '../../../viewer/page/src/format.js';
import { scaleOf, colorAt, gradient } from '../../../viewer/page/src/colors.js';

const colours = { seen: '#7a7a7a', best: '#0072b2', limit: '#d55e00', band: '#f2f4f7', failed: '#a3350c' };

/** [level, first, last] of runs of evaluations on one level. */
export function levelSpans(history) {
  const spans = [];
  history.level.forEach((level, i) => {
    const last = spans[spans.length - 1];
    if (last && last.level === level) last.to = history.evaluation[i];
    else spans.push({ level, from: history.evaluation[i], to: history.evaluation[i] });
  });
  return spans;
}

/** Bands and names of the levels behind the curves, and crosses where an evaluation failed. */
function decoration(run) {
  const spans = levelSpans(run.history);
  const failed = run.history.evaluation.filter((_, i) => run.history.status[i] !== 'ok');
  return {
    hooks: {
      drawAxes: [(u) => {
        const { ctx, bbox } = u;
        ctx.save();
        ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
        ctx.textBaseline = 'top';
        ctx.textAlign = 'left';
        spans.forEach(({ level, from, to }, k) => {
          const left = Math.max(bbox.left, u.valToPos(from - 0.5, 'x', true));
          const right = Math.min(bbox.left + bbox.width, u.valToPos(to + 0.5, 'x', true));
          if (right <= left) return;
          if (k % 2 === 1) { ctx.fillStyle = colours.band; ctx.fillRect(left, bbox.top, right - left, bbox.height); }
          ctx.strokeStyle = '#b9c0c9';
          ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
          if (k > 0) { ctx.beginPath(); ctx.moveTo(left, bbox.top); ctx.lineTo(left, bbox.top + bbox.height); ctx.stroke(); }
          ctx.fillStyle = '#4a525c';
          const words = right - left > 60 * devicePixelRatio ? `level ${level}` : String(level);
          ctx.fillText(words, left + 4 * devicePixelRatio, bbox.top + 3 * devicePixelRatio);
        });
        ctx.restore();
      }],
      draw: [(u) => {
        const { ctx, bbox } = u, r = 4 * devicePixelRatio, y = bbox.top + bbox.height - 2 * r;
        ctx.save();
        ctx.strokeStyle = colours.failed;
        ctx.lineWidth = 1.5 * devicePixelRatio;
        for (const e of failed) {
          const x = u.valToPos(e, 'x', true);
          ctx.beginPath();
          ctx.moveTo(x - r, y - r); ctx.lineTo(x + r, y + r); ctx.moveTo(x - r, y + r); ctx.lineTo(x + r, y - r);
          ctx.stroke();
        }
        ctx.restore();
      }],
    },
  };
}

/** lines: {words, values, kind: seen | best | limit}[] over the evaluations. */
function chart(run, heading, lines, { log = false, words = number, summary } = {}) {
  const holder = h('div', { class: 'chart', role: 'img', 'aria-label': summary || heading });
  const x = run.history.evaluation;
  const style = {
    seen: { stroke: colours.seen, paths: () => null, points: { show: true, size: 5, fill: colours.seen, stroke: colours.seen } },
    best: { stroke: colours.best, width: 2.5, paths: uPlot.paths.stepped({ align: 1 }), points: { show: false } },
    limit: { stroke: colours.limit, width: 1.5, dash: [6, 4], points: { show: false } },
  };
  const shown = (u, v) => (v === null || v === undefined ? '\u2013' : words(v));
  const options = {
    width: 600, height: 240, cursor: { drag: { x: true, y: false } }, legend: { live: true },
    scales: { x: { time: false, range: (u, a, b) => [Math.min(a, b) - 0.5, Math.max(a, b) + 0.5] }, y: { distr: log ? 3 : 1 } },
    axes: [{ label: 'evaluation', labelSize: 18, size: 34, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 5000] },
      { size: 70, values: (u, ticks) => ticks.map((v) => (v === null ? '' : words(v))) }],
    series: [{ label: 'evaluation', value: (u, v) => (v === null || v === undefined ? '\u2013' : String(v)) },
      ...lines.map(({ words: label, kind }) => ({ label, value: shown, spanGaps: true, ...style[kind] }))],
    plugins: [decoration(run)],
  };
  let plot = null;
  const draw = () => {
    const width = Math.max(220, Math.floor(holder.clientWidth));
    options.width = width;
    if (plot) plot.setSize({ width, height: options.height });
    else if (holder.clientWidth > 0) plot = new uPlot(options, [x, ...lines.map((line) => line.values)], holder);
  };
  new ResizeObserver(draw).observe(holder);
  return h('figure', { class: 'plot' }, h('figcaption', {}, heading), holder);
}

const clean = (list) => list.map((v) => (Number.isFinite(v) ? v : null));

function bestUpTo(run, values) {
  let best = null;
  return values.map((v, i) => { if (run.history.accepted[i]) best = v; return best; });
}

function objectiveChart(run) {
  const name = run.is_fit ? 'rms distance, diagonals' : 'objective';
  const values = clean(run.history.objective).map((v) => (run.is_fit && v !== null ? Math.sqrt(v) : v));
  const best = bestUpTo(run, values), known = values.filter((v) => v !== null);
  const log = known.length > 0 && Math.min(...known) > 0 && Math.max(...known) / Math.min(...known) > 50;
  const last = best[best.length - 1];
  return chart(run, `${run.is_fit ? 'Remaining distance' : `Objective (${run.maximize ? 'maximized' : 'minimized'})`}${log ? ', logarithmic' : ''}`,
    [{ words: name, values, kind: 'seen' }, { words: 'best so far', values: best, kind: 'best' }],
    { log, summary: `${name} over evaluations, from ${number(known[0])} to ${number(last)} at best` });
}

function valueChart(run, k) {
  const value = run.quantities.values[k];
  const values = clean(run.history.values.map((row) => row[k]));
  const lines = [{ words: value.name, values, kind: 'seen' }, { words: 'best design', values: bestUpTo(run, values), kind: 'best' }];
  for (const side of ['min', 'max'])
    if (Number.isFinite(value[side])) lines.push({ words: side === 'min' ? 'lower limit' : 'upper limit', kind: 'limit', values: values.map(() => value[side]) });
  return chart(run, `${value.name}${value.limit ? ` (${value.limit})` : ''}`, lines);
}

function parameterChart(run, k) {
  const parameter = run.quantities.parameters[k];
  const values = clean(run.history.parameters.map((row) => row[k]));
  return chart(run, parameter.unit === 'rad' ? `${parameter.name}, degrees` : parameter.name,
    [{ words: parameter.name, values, kind: 'seen' }, { words: 'best design', values: bestUpTo(run, values), kind: 'best' }],
    { words: (v) => parameterValue(v, parameter.unit) });
}

/** Scaled variables of one level, a row each, an evaluation a column. */
function heat(run, level) {
  const { names, lower, upper } = level.shape_variables;
  const columns = run.history.evaluation.map((_, i) => i).filter((i) => run.history.level[i] === level.level && run.history.x[i]);
  if (names.length === 0 || columns.length === 0) return null;
  const rows = names.length, tall = Math.max(2, Math.min(16, Math.floor(640 / rows)));
  const canvas = h('canvas', { class: 'heat', width: columns.length, height: rows, style: `height: ${tall * rows}px`,
    role: 'img', 'aria-label': `${rows} variables over ${columns.length} evaluations of level ${level.level}` });
  const image = new ImageData(columns.length, rows), scale = { low: -1, high: 1, map: 'diverging' };
  columns.forEach((i, c) => {
    for (let r = 0; r < rows; ++r) {
      const at = 4 * (r * columns.length + c), most = Math.max(Math.abs(lower[r]), Math.abs(upper[r])) || 1;
      colorAt(scale, (run.history.x[i][r] ?? 0) / most, image.data, at);
      image.data[at + 3] = 255;
    }
  });
  canvas.getContext('2d').putImageData(image, 0, 0);
  const told = h('p', { class: 'told', 'aria-live': 'polite' }, 'Point at a cell to see its value.');
  canvas.addEventListener('pointermove', (e) => {
    const box = canvas.getBoundingClientRect();
    const c = Math.min(columns.length - 1, Math.max(0, Math.floor(((e.clientX - box.left) / box.width) * columns.length)));
    const r = Math.min(rows - 1, Math.max(0, Math.floor(((e.clientY - box.top) / box.height) * rows)));
    told.textContent = `${names[r]}, evaluation ${run.history.evaluation[columns[c]]}: ${number(run.history.x[columns[c]][r], 3)}`
      + ` in [${number(lower[r], 3)}, ${number(upper[r], 3)}]`;
  });
  const labels = tall >= 12 ? h('ol', { class: 'heat-names', style: `line-height: ${tall}px` }, names.map((n) => h('li', {}, n))) : null;
  return h('figure', { class: 'plot' }, h('figcaption', {}, `Level ${level.level}: ${rows} variables over ${columns.length} evaluations`),
    h('div', { class: 'heat-frame' }, labels, canvas),
    h('div', { class: 'legend' }, h('span', {}, 'lower bound'), h('span', { class: 'bar', style: `background: ${gradient('diverging')}` }), h('span', {}, 'upper bound')), told);
}

export function progress(run) {
  if (run.history.evaluation.length === 0) return section('progress', 'Progress', h('p', {}, 'No evaluation yet.'));
  const { values, parameters } = run.quantities;
  const limited = values.map((_, k) => k).filter((k) => values[k].limit).slice(0, 8);
  const others = values.map((_, k) => k).filter((k) => !limited.includes(k));
  const shown = [objectiveChart(run), ...limited.map((k) => valueChart(run, k)), ...parameters.slice(0, 6).map((_, k) => parameterChart(run, k))];
  if (run.history.violation.some((v) => v > 0)) {
    const violation = clean(run.history.violation);
    shown.push(chart(run, 'Largest violation of a constraint, scaled',
      [{ words: 'violation', values: violation, kind: 'seen' }, { words: 'best design', values: bestUpTo(run, violation), kind: 'best' }]));
  }
  const grid = h('div', { class: 'grid' }, shown);
  const parts = [h('p', { class: 'hint' }, 'Bands mark levels; a cross at the bottom marks a failed evaluation. Drag across a chart to zoom in, double-click to zoom out.'), grid];
  if (others.length > 0) {
    const place = h('div', {}, valueChart(run, others[0]));
    parts.push(h('div', { class: 'controls' }, choice('Other values', others.map((k) => [String(k), values[k].name]), String(others[0]),
      (k) => place.replaceChildren(valueChart(run, Number(k))))), place);
  }
  const maps = run.levels.map((level) => heat(run, level)).filter(Boolean);
  if (maps.length > 0) parts.push(h('h3', {}, 'Design variables'), ...maps);
  return section('progress', 'Progress', parts);
}

export { scaleOf };
