// Samples: main effects, and values over the variables that matter most.

import { h, section, table } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';

const maxVariables = 6, maxValues = 6, cell = 130, gap = 14, left = 92, below = 30;

const percentOf = (share) => (Number.isFinite(share) ? `${number(100 * share, 3)} %` : '–');

function effectTable(samples, names, value) {
  const { main_effects: effects, predicted_share: share, deviation } = samples.values[value];
  const order = names.map((name) => name).sort((a, b) => effects[b].share - effects[a].share);
  return h('details', { open: names.length <= 12 }, h('summary', {}, `${value}: deviation ${number(deviation, 4)}; models of all other designs predict ${percentOf(Math.max(0, share))} of its variance`),
    table(`Effects on ${value}`, [['variable', false], ['main effect', true], ['standard error', true], ['with interactions', true]],
      order.map((name) => [name, percentOf(effects[name].share), percentOf(effects[name].error), percentOf(effects[name].total)])));
}

function svg(tag, attributes, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** Variables, most important first, by the sum of their effects on all values. */
function important(samples) {
  const sum = (name) => Object.values(samples.values).reduce((all, v) => all + v.main_effects[name].share, 0);
  const names = [...samples.variables];
  if (Object.keys(samples.values).length > 0) names.sort((a, b) => sum(b) - sum(a));
  return names.slice(0, maxVariables);
}

/** The designs' physical values: shape variables by their units, then parameters. */
function columns(run) {
  const { history, levels, quantities } = run;
  const shape = levels.length > 0 ? levels[0].shape_variables : { names: [], unit: [] };
  const parameterNames = quantities.parameters.map((p) => p.name);
  const out = {};
  shape.names.forEach((name, j) => { out[name] = history.x.map((x) => (x ? x[j] * (shape.unit[j] ?? 1) : null)); });
  parameterNames.forEach((name, j) => { out[name] = history.parameters.map((p) => p[j]); });
  return out;
}

function scatter(run) {
  const names = important(run.samples), at = columns(run);
  const values = run.quantities.values.slice(0, maxValues);
  const shown = names.filter((name) => at[name]);
  if (shown.length === 0 || values.length === 0) return null;
  const width = left + shown.length * (cell + gap), height = values.length * (cell + gap) + below;
  const plot = svg('svg', { class: 'scatter', width, viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'Values of all designs over the variables that matter most' });
  const range = (list) => { const known = list.filter(Number.isFinite); return [Math.min(...known), Math.max(...known)]; };
  values.forEach((value, row) => {
    const y = run.history.values.map((v) => v[row] ?? null), [yLow, yHigh] = range(y);
    const top = row * (cell + gap);
    plot.append(svg('text', { x: left - 8, y: top + cell / 2, 'text-anchor': 'end' }, value.name),
      svg('text', { x: left - 8, y: top + 10, 'text-anchor': 'end' }, number(yHigh, 4)), svg('text', { x: left - 8, y: top + cell, 'text-anchor': 'end' }, number(yLow, 4)));
    shown.forEach((name, column) => {
      const x = at[name], [xLow, xHigh] = range(x), begin = left + column * (cell + gap);
      plot.append(svg('rect', { x: begin, y: top, width: cell, height: cell }));
      if (row === values.length - 1)
        plot.append(svg('text', { x: begin + cell / 2, y: height - 4, 'text-anchor': 'middle' }, name),
          svg('text', { x: begin, y: height - 17 }, number(xLow, 3)), svg('text', { x: begin + cell, y: height - 17, 'text-anchor': 'end' }, number(xHigh, 3)));
      x.forEach((px, i) => {
        if (!Number.isFinite(px) || !Number.isFinite(y[i])) return;
        const best = run.history.evaluation[i] === run.end.best_evaluation;
        plot.append(svg('circle', { cx: begin + cell * (0.04 + 0.92 * (xHigh > xLow ? (px - xLow) / (xHigh - xLow) : 0.5)),
          cy: top + cell * (0.96 - 0.92 * (yHigh > yLow ? (y[i] - yLow) / (yHigh - yLow) : 0.5)), r: best ? 4 : 2.5, class: best ? 'best' : 'design' },
        svg('title', {}, `evaluation ${run.history.evaluation[i]}: ${name} = ${number(px)}, ${value.name} = ${number(y[i])}`)));
      });
    });
  });
  return h('figure', {}, h('figcaption', {}, 'All designs; the best one in orange'), plot);
}

export function samples(run) {
  if (!run.samples) return '';
  const { values, variables, without_effects: without, remarks = [] } = run.samples;
  return section('samples', 'Samples',
    h('p', {}, 'The main effect of a variable is the share of the variance of a value that this variable alone explains, by a Gaussian process of all designs. With interactions: the share that is lost where the variable is fixed. Shape variables count as independent, each over the range of the designs.'),
    remarks.length > 0 ? h('ul', {}, remarks.map((remark) => h('li', {}, `${remark}.`))) : '',
    without ? h('p', {}, `${without}.`) : Object.keys(values).map((value) => effectTable(run.samples, variables, value)),
    scatter(run));
}
