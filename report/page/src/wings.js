// The declared wings at the start and at the best design: as a whole, by station, along the span, and their airfoils.

import uPlot from 'uplot';
import { h, section, table } from '../../../viewer/page/src/dom.js';
import { number, change } from '../../../viewer/page/src/format.js';

const colours = { start: '#6b6b6b', best: '#0072b2' };
const degrees = (angle) => (angle * 180) / Math.PI;
/** Without the sign of a zero. */
export const fixed = (value, digits) => {
  const shown = Number.isFinite(value) ? value.toFixed(digits) : '–';
  return Number(shown) === 0 ? shown.replace('-', '') : shown.replace('-', '\u2212');
};
const signed = (angle) => `${angle > 0 ? '+' : ''}${fixed(angle, 3)}°`;
const inDegrees = (angle) => fixed(degrees(angle), 3);

/** What a station is described by: words for headings, what is drawn, how it is written, and the least extent of a chart: rounding is no shape. */
const columns = (units) => [
  ['chord', units, (at) => at.chord, (v) => number(v, 5), 0],
  ['twist', 'deg', (at) => degrees(at.twist), (v) => fixed(v, 3), 0.1],
  ['t/c', '%', (at) => 100 * at.thickness_to_chord, (v) => fixed(v, 2), 0.1],
  ['camber', '%', (at) => 100 * at.camber, (v) => fixed(v, 2), 0.1],
  ['leading-edge radius', '% of the chord', (at) => (at.leading_edge_radius === null ? NaN : 100 * at.leading_edge_radius), (v) => fixed(v, 3), 0.05],
];
export const titled = ([name, unit]) => (unit ? `${name}, ${unit}` : name);

/** Start and best, or one word where they are alike. */
export function both(a, b) {
  if (b === null || a === b) return a;
  return h('span', { class: 'both' }, h('span', { class: 'was' }, a), ' → ', h('b', {}, b));
}

function wholeTable(wing, units) {
  const { start, best } = wing, square = units ? `${units}²` : '';
  const rows = [['span', units, (w) => number(w.span, 6)], ['area', square, (w) => number(w.area, 6)], ['aspect ratio', '', (w) => number(w.aspect_ratio, 5)],
    ['taper', '', (w) => number(w.taper, 5)], ['mean aerodynamic chord', units, (w) => number(w.mean_chord, 6)],
    ['sweep', 'deg', (w) => inDegrees(w.sweep)], ['dihedral', 'deg', (w) => inDegrees(w.dihedral)]];
  const share = { span: 'span', area: 'area', 'aspect ratio': 'aspect_ratio', taper: 'taper', 'mean aerodynamic chord': 'mean_chord' };
  const differs = (name) => (!best ? '' : share[name] ? change(start[share[name]], best[share[name]]) : signed(degrees(best[name] - start[name])));
  return table(`As a whole; angles at ${number(100 * wing.axis, 3)} % of the chord`, [['', false], ['start', true], ['best', true], ['change', true]],
    rows.map(([name, unit, of]) => [unit ? `${name}, ${unit}` : name, of(start), best ? of(best) : '–', best && of(best) === of(start) ? '0' : differs(name)]));
}

function stationTable(wing, units) {
  const { start, best } = wing, all = columns(units);
  return table('By station', [['fraction of the semispan', false], ...all.map((column) => [titled(column), true])],
    start.stations.map((at, k) => [number(at.station, 4), ...all.map(([, , of, words]) => both(words(of(at)), best ? words(of(best.stations[k])) : null))]));
}

function panelTable(wing) {
  const { start, best } = wing;
  if (start.panels.length < 2) return null;
  const value = (k, name) => both(inDegrees(start.panels[k][name]), best ? inDegrees(best.panels[k][name]) : null);
  return table('By panel', [['from – to', false], ['sweep, deg', true], ['dihedral, deg', true]],
    start.panels.map(({ from, to }, k) => [`${number(from, 4)} – ${number(to, 4)}`, value(k, 'sweep'), value(k, 'dihedral')]));
}

/** One value over the fraction of the semispan, or of a body's length. */
export function chart(sheets, column, along = 'semispan') {
  const [name, , of, words, least] = column, lines = sheets.best ? [sheets.start, sheets.best] : [sheets.start];
  const places = [...new Set(lines.flatMap((line) => line.curve.map((at) => at.station)))].sort((a, b) => a - b);
  const values = lines.map((line) => places.map((s) => { const at = line.curve.find((one) => one.station === s), v = at ? of(at) : NaN; return Number.isFinite(v) ? v : null; }));
  const known = values.flat().filter((v) => v !== null);
  if (known.length === 0) return null;
  const holder = h('div', { class: 'chart small', role: 'img', 'aria-label': `${titled(column)} along the ${along}, from ${words(Math.min(...known))} to ${words(Math.max(...known))}` });
  const shown = (u, v) => (v === null || v === undefined ? '–' : words(v));
  const options = {
    width: 400, height: 190, cursor: { drag: { x: false, y: false } }, legend: { live: true },
    scales: { x: { time: false, range: [0, 1] },
      y: { range: (u, low, high) => { const room = Math.max(0.08 * (high - low), 0.01 * Math.max(Math.abs(low), Math.abs(high)), (least - high + low) / 2, 1e-6); return [low - room, high + room]; } } },
    axes: [{ size: 34, values: (u, ticks) => ticks.map((v) => number(v, 3)) }, { size: 62, values: (u, ticks) => ticks.map((v) => number(v, 4)) }],
    series: [{ label: along, value: (u, v) => (v === null || v === undefined ? '–' : number(v, 3)) },
      { label: 'start', value: shown, stroke: colours.start, width: 1.5, dash: [6, 4], points: { show: false } },
      ...(sheets.best ? [{ label: 'best', value: shown, stroke: colours.best, width: 2.5, points: { show: false } }] : [])],
  };
  let plot = null;
  new ResizeObserver(() => {
    const width = Math.max(220, Math.floor(holder.clientWidth));
    if (plot) plot.setSize({ width, height: options.height });
    else if (holder.clientWidth > 0) plot = new uPlot({ ...options, width }, [places, ...values], holder);
  }).observe(holder);
  return h('figure', { class: 'plot', 'data-value': name }, h('figcaption', {}, titled(column)), holder);
}

export function svg(tag, attributes, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function outlines(station, name) {
  return station.outlines.map((points) => {
    let d = '';
    for (let k = 0; k < points.length; k += 2) d += `${k === 0 ? 'M' : 'L'}${points[k]} ${-points[k + 1]}`;
    return svg('path', { d, class: name });
  });
}

/** Both airfoils of a station, each in fractions of its own chord, chord lines on top of each other. */
function airfoil(wing, k, units) {
  const before = wing.start.stations[k], after = wing.best ? wing.best.stations[k] : null;
  let low = Infinity, high = -Infinity, fore = 0, aft = 1;
  for (const station of [before, after])
    for (const points of station ? station.outlines : [])
      for (let i = 0; i < points.length; i += 2) {
        low = Math.min(low, points[i + 1]); high = Math.max(high, points[i + 1]);
        fore = Math.min(fore, points[i]); aft = Math.max(aft, points[i]);
      }
  if (!(high > low)) return null;
  const pad = 0.02, width = aft - fore + 2 * pad, height = high - low + 2 * pad;
  const all = columns(units), said = (station) => all.slice(0, 4).map(([name, unit, of, words]) => `${name} ${words(of(station))}${unit === 'deg' ? '°' : unit === '%' ? ' %' : ` ${unit}`}`.trim()).join(', ');
  const drawing = svg('svg', { class: 'section-plot airfoil', viewBox: `${fore - pad} ${-high - pad} ${width} ${height}`, role: 'img',
    'aria-label': `Airfoil at ${number(100 * before.station, 4)} % of the semispan: start ${said(before)}${after ? `; best ${said(after)}` : ''}` },
  svg('line', { x1: fore, y1: 0, x2: aft, y2: 0, class: 'chord-line' }), ...outlines(before, 'start'), ...(after ? outlines(after, 'design') : []));
  drawing.style.aspectRatio = `${width} / ${height}`;
  return h('figure', { class: 'airfoil-figure' }, h('figcaption', {}, `${number(100 * before.station, 4)} % of the semispan`), drawing,
    h('p', { class: 'hint' }, after ? `start: ${said(before)}; best: ${said(after)}` : said(before)));
}

function oneWing(wing, units) {
  return [
    h('div', { class: 'columns' }, h('div', {}, wholeTable(wing, units)), h('div', {}, panelTable(wing))),
    stationTable(wing, units),
    h('h3', {}, 'Along the span'),
    h('div', { class: 'grid thirds' }, columns(units).map((column) => chart(wing, column))),
    h('h3', {}, 'Airfoils, in fractions of their chords'),
    h('p', {}, h('span', { class: 'key start' }, 'start (dashed)'), ' ', wing.best && h('span', { class: 'key design' }, 'best')),
    h('div', { class: 'grid thirds airfoils' }, wing.start.stations.map((_, k) => airfoil(wing, k, units))),
  ];
}

export function wings(run) {
  const all = run.wings ?? [];
  if (all.length === 0) return '';
  return section('wings', all.length > 1 ? 'Wings' : 'Wing',
    all.map((wing) => [all.length > 1 && h('h3', {}, wing.name), ...oneWing(wing, run.units)]));
}
