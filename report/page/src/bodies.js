// The declared bodies at the start and at the best design: length, and by station, along the length, and their sections.

import { h, section, table } from '../../../viewer/page/src/dom.js';
import { number, change } from '../../../viewer/page/src/format.js';
import { both, chart, fixed, outlines, svg, titled } from './wings.js';

/** As those of wings. */
const columns = (units) => [
  ['width', units, (at) => at.width, (v) => number(v, 5), 0],
  ['height', units, (at) => at.height, (v) => number(v, 5), 0],
  ['camber', '% of the length', (at) => 100 * at.camber, (v) => fixed(v, 3), 0.1],
];

function wholeTable({ start, best }, units) {
  const differs = best && number(best.length, 6) !== number(start.length, 6);
  return table('As a whole', [['', false], ['start', true], ['best', true], ['change', true]],
    [[units ? `length, ${units}` : 'length', number(start.length, 6), best ? number(best.length, 6) : '–', differs ? change(start.length, best.length) : best ? '0' : '']]);
}

function stationTable({ start, best }, units) {
  const all = columns(units);
  return table('By station', [['fraction of the length', false], ...all.map((column) => [titled(column), true])],
    start.stations.map((at, k) => [number(at.station, 4), ...all.map(([, , of, words]) => both(words(of(at)), best ? words(of(best.stations[k])) : null))]));
}

/** Both sections of a station across the length, in the same place and scale. */
function crossSection({ start, best }, k) {
  const before = start.stations[k], after = best ? best.stations[k] : null;
  let low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const station of [before, after])
    for (const points of station ? station.outlines : [])
      for (let i = 0; i < points.length; i += 1) { low[i % 2] = Math.min(low[i % 2], points[i]); high[i % 2] = Math.max(high[i % 2], points[i]); }
  if (!(high[0] > low[0] && high[1] > low[1])) return null;
  const pad = 0.05, width = high[0] - low[0] + 2 * pad, height = high[1] - low[1] + 2 * pad, place = `${number(100 * before.station, 4)} % of the length`;
  const drawing = svg('svg', { class: 'section-plot airfoil', viewBox: `${low[0] - pad} ${-high[1] - pad} ${width} ${height}`, role: 'img', 'aria-label': `Section at ${place}` },
    ...outlines(before, 'start'), ...(after ? outlines(after, 'design') : []));
  drawing.style.aspectRatio = `${width} / ${height}`;
  return h('figure', { class: 'airfoil-figure' }, h('figcaption', {}, place), drawing);
}

function oneBody(body, units) {
  return [
    wholeTable(body, units),
    stationTable(body, units),
    h('h3', {}, 'Along the length'),
    h('div', { class: 'grid thirds' }, columns(units).map((column) => chart(body, column, 'length'))),
    h('h3', {}, 'Sections across the length'),
    h('p', {}, h('span', { class: 'key start' }, 'start (dashed)'), ' ', body.best && h('span', { class: 'key design' }, 'best')),
    h('div', { class: 'grid thirds airfoils' }, body.start.stations.map((_, k) => crossSection(body, k))),
  ];
}

export function bodies(run) {
  const all = run.bodies ?? [];
  if (all.length === 0) return '';
  return section('bodies', all.length > 1 ? 'Bodies' : 'Body',
    all.map((body) => [(all.length > 1 || (run.wings ?? []).length > 0) && h('h3', {}, body.name), ...oneBody(body, run.units)]));
}
