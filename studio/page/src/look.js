// The panel about the surface: size, wings, defects, what the colours mean.

import { h, choice, table } from '../../../viewer/page/src/dom.js';
import { number, plural } from '../../../viewer/page/src/format.js';

export function colourChoices(facts) {
  const list = [['plain', 'nothing']];
  facts.levels.forEach((level, k) => list.push([`level:${k}`, `patches of level ${k + 1} (${level.patches.length})`]));
  if (facts.parts.length > 0) list.push(['part', `parts of the file (${facts.parts.length})`]);
  list.push(['component', `connected parts (${facts.components})`]);
  return list;
}

const degrees = (value) => `${number(Math.abs(value) < 1e-6 ? 0 : value, 3)}°`;  // no −1e−16°

/** "Is this metres? longest side 28.1 m", corrected by a click; the case keeps it. */
function unitQuestion(facts, editor) {
  const longest = Math.max(...facts.high.map((v, c) => v - facts.low[c]));
  const inMetres = { m: 1, cm: 1e-2, mm: 1e-3, ft: 0.3048, in: 0.0254 };
  const stated = facts.units || '';
  const button = (unit) => h('button', { type: 'button', 'aria-pressed': String(unit === stated), onclick: () => editor.form.set([['surface.units', unit]], `unit ${unit}`), disabled: !editor.text.trim() }, `${unit}: ${number(longest * inMetres[unit], 3)} m`);
  return h('div', { class: 'units' }, h('p', {}, stated ? `Coordinates are in ${stated}, as the case says.` : 'The file does not say its unit. Its longest side would be …'),
    h('span', { class: 'buttons', role: 'group', 'aria-label': 'Unit of the coordinates' }, Object.keys(inMetres).map(button)),
    editor.text.trim() ? '' : h('p', { class: 'hint' }, 'A case keeps the unit: propose one first.'));
}

function wings(facts) {
  if (facts.wings.length === 0) return h('p', {}, 'No wing found along a coordinate; declare one under planform if it lies otherwise.');
  return facts.wings.map((wing) => [
    table(wing.is_half ? 'Wing (values of both sides; the file holds one)' : 'Wing', [['', false], ['value', true]], [
      ['span', number(wing.span)], [wing.has_body ? 'area, exposed' : 'area', number(wing.area)], ['aspect ratio', number(wing.aspect_ratio, 4)],
      ['taper', number(wing.taper, 3)], ['sweep of the quarter chord', degrees(wing.sweep_deg)],
      ['dihedral', degrees(wing.dihedral_deg)], ['mean aerodynamic chord', number(wing.mean_chord)]]),
    table('Stations', [['semispan', true], ['chord', true], ['twist', true], ['t/c', true]], wing.stations.map((s) => [
      number(s.station, 3), number(s.chord, 4), degrees(s.twist_deg), `${number(100 * s.thickness_to_chord, 3)} %`])),
    h('p', { class: 'hint' }, `Found by ${wing.why}.`)]);
}

function defects(facts, scene) {
  if (facts.defects.length === 0) return h('p', {}, 'No defects.');
  return [h('ul', { class: 'defects' }, facts.defects.map((d) => h('li', {}, h('button', { type: 'button', onclick: () => scene.mark(d.places) },
    d.count > 1 ? `${d.count} ${d.what}` : d.what)))),
  h('button', { type: 'button', onclick: () => { scene.mark([]); scene.viewer.look('iso'); } }, 'Hide the marks')];
}

export function lookPanel(scene, editor, next) {
  const { body } = scene, { facts } = body, unit = facts.units ? ` ${facts.units}` : '';
  const size = body.size.map((v) => number(v)).join(' × ');
  return [
    next,
    table('Surface', [['', false], ['value', true]], [
      [`size x × y × z${unit}`, size],
      ['from', facts.low.map((v) => number(v)).join(', ')], ['to', facts.high.map((v) => number(v)).join(', ')],
      ['diagonal', number(facts.diagonal)], ['area', number(facts.area)],
      ['volume', facts.volume === null ? 'none: it is open' : facts.volume < 0 ? `${number(-facts.volume)}, triangles face inward` : number(facts.volume)],
      ['triangles, vertices', `${facts.triangles}, ${facts.vertices}`], ['connected parts', String(facts.components)]]),
    unitQuestion(facts, editor),
    facts.is_prepared ? h('p', {}, 'Shown as the case repairs and remeshes it.') : '',
    [...facts.notes, ...facts.warnings].map((words) => h('p', { class: 'hint' }, words)),
    h('h3', {}, 'Wings'), wings(facts),
    h('h3', {}, `Defects${facts.defects.length ? ` (${plural(facts.defects.length, 'kind')})` : ''}`), defects(facts, scene),
    facts.advice.map((words) => h('p', { class: 'hint' }, words)),
  ];
}

export function viewControls(scene) {
  const views = [['iso', 'Oblique'], ['front', 'Front'], ['side', 'Side'], ['top', 'Top'], ['back', 'Back'], ['below', 'Below']];
  const axes = scene.body.facts.axes;
  const up = String(scene.viewer.up) + (scene.viewer.isDown ? '-' : '');
  const ups = ['x', 'y', 'z'].flatMap((a, k) => [[String(k), `+${a}`], [`${k}-`, `\u2212${a}`]]);
  return [
    choice('Colour', colourChoices(scene.body.facts), scene.colour, (v) => { scene.colour = v; scene.paint(); }),
    choice(axes && axes.is_stated ? 'Up' : 'Up (guess)', ups, up, (v) => scene.viewer.setUp(Number(v[0]), v.length > 1)),
    h('span', { class: 'buttons', role: 'group', 'aria-label': 'View from' },
      views.map(([v, words]) => h('button', { type: 'button', onclick: () => scene.viewer.look(v) }, words))),
  ];
}
