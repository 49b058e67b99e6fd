// The patch tree with the contribution of each patch.

import { h, section } from '../../../viewer/page/src/dom.js';
import { number, percent } from '../../../viewer/page/src/format.js';

const byName = ([a], [b]) => a.name.localeCompare(b.name, 'en', { numeric: true });
const deepest = 400;  // rows created at once

/** Share of the whole change; positive: the patch helped. */
function helped(run, contribution) {
  const { change } = run.shapes;
  if (!Number.isFinite(contribution) || !Number.isFinite(change) || change === 0) return null;
  return contribution / change;
}

function bar(share) {
  if (share === null) return h('span', { class: 'share' }, '–');
  const width = Math.min(100, Math.abs(100 * share));
  return h('span', { class: 'share' }, h('span', { class: 'track' },
    h('span', { class: share < 0 ? 'fill against' : 'fill', style: `width: ${width.toFixed(1)}%` })), ` ${percent(share)}`);
}

export function tree(run, panel) {
  if (!run.shapes || run.shapes.tree.length < 2)
    return section('patches', 'Patches', h('p', {}, 'The patch tree is unknown: the folder has no design yet.'));
  const levels = run.shapes.tree, { diagonal } = run.shapes.surface;
  const body = h('tbody', {});
  const told = h('p', { class: 'told', 'aria-live': 'polite' });
  let selected = null;
  const children = (k, id) => (k + 1 < levels.length ? levels[k + 1].patches.map((p, i) => [p, i]).filter(([p]) => p.parent === id).sort(byName) : []);
  /** A patch that is not split has a single child of the same name: it is shown once. */
  const ends = (k, id) => {
    const below = children(k, id);
    return below.length === 1 ? ends(k + 1, below[0][1]) : { level: k, id, below };
  };

  function row(k, id, depth) {
    const end = ends(k, id), patch = levels[k].patches[id];
    const used = levels.slice(k, end.level + 1).some((_, j) => j === 0 ? patch.in_use : false) || levels[end.level].patches[end.id].in_use;
    const name = h('button', { type: 'button', class: 'patch', 'aria-pressed': 'false', onclick: () => select(k, id, name) }, patch.name);
    const rowElement = h('tr', { 'data-level': k, 'data-id': id });
    const opener = end.below.length > 0
      ? h('button', { type: 'button', class: 'opener', 'aria-expanded': 'false', 'aria-label': `Parts of ${patch.name}`, onclick: () => toggle() }, '▸')
      : h('span', { class: 'opener' });
    let open = [];
    function toggle() {
      if (open.length > 0) {
        const all = [...open];
        while (all.length > 0) { const one = all.pop(); if (one.close) one.close(); one.remove(); }
        open = [];
      } else {
        open = end.below.map(([, i]) => row(end.level + 1, i, depth + 1));
        rowElement.after(...open);
      }
      opener.setAttribute('aria-expanded', String(open.length > 0));
      opener.textContent = open.length > 0 ? '▾' : '▸';
    }
    rowElement.close = () => { if (open.length > 0) toggle(); };
    rowElement.toggle = toggle;
    rowElement.append(
      h('th', { scope: 'row', style: `padding-left: ${0.3 + 0.9 * depth}rem` }, opener, name, used ? h('span', { class: 'used', title: 'has variables in the best design' }, ' ●') : ''),
      h('td', { class: 'number' }, percent(patch.area).replace('+', '')), h('td', { class: 'number' }, String(patch.triangles)),
      h('td', { class: 'number' }, percent(patch.mean / diagonal)), h('td', { class: 'number' }, percent(patch.most / diagonal).replace('+', '')),
      h('td', { class: 'number' }, number(patch.contribution, 3)), h('td', {}, bar(helped(run, patch.contribution))));
    return rowElement;
  }

  function select(level, id, button) {
    const again = selected && selected.button === button;
    if (selected) { selected.button.setAttribute('aria-pressed', 'false'); }
    selected = again ? null : { button };
    if (!again) button.setAttribute('aria-pressed', 'true');
    const patch = levels[level].patches[id];
    told.textContent = again ? 'No patch is highlighted.' : `${patch.name} is highlighted in the view above.`;
    if (panel) panel.select(again ? 0 : level, id);
  }

  const roots = levels[1].patches.map((p, id) => [p, id]).sort(byName).map(([, id]) => row(1, id, 0));
  body.append(...roots);
  if (levels[1].patches.length <= 12 && levels.length > 2 && levels[2].patches.length < 30) roots.forEach((r) => r.toggle());
  const count = levels.reduce((sum, level) => sum + level.patches.length, 0);
  const all = h('button', { type: 'button', onclick: () => {
    let rows = [...body.children];
    while (rows.length > 0 && body.children.length < deepest) {
      const r = rows.shift();
      const opener = r.querySelector('button.opener');
      if (opener && opener.getAttribute('aria-expanded') === 'false') { r.toggle(); rows = [...body.children]; }
    }
  } }, count > deepest ? `Open (at most ${deepest} rows)` : 'Open all');
  // Up and down arrows go from patch to patch, right and left open and close.
  body.addEventListener('keydown', (e) => {
    const at = e.target.closest('tr');
    if (!at) return;
    const opener = at.querySelector('button.opener'), isOpen = opener && opener.getAttribute('aria-expanded') === 'true';
    const next = { ArrowDown: at.nextElementSibling, ArrowUp: at.previousElementSibling }[e.key];
    if (next) next.querySelector('button.patch').focus();
    if ((e.key === 'ArrowRight' && opener && !isOpen) || (e.key === 'ArrowLeft' && isOpen)) at.toggle();
    if (/^Arrow/.test(e.key)) e.preventDefault();
  });
  const { explained, change } = run.shapes;
  const known = Number.isFinite(explained) && Number.isFinite(change);
  return section('patches', 'Patches',
    h('p', {}, 'The contribution of each patch: the sensitivity of the objective times its motion, summed along the accepted designs. ',
      known ? `The contributions add up to ${number(explained, 4)} of the total change of ${number(change, 4)}; the rest is the error of this sum and the effect of variables other than shape.`
        : 'It is unknown here: too few designs have sensitivities.'),
    h('p', { class: 'hint' }, 'Click a name to highlight the patch in the view; ● marks patches with variables in the best design. Arrow keys navigate the tree.'),
    h('div', { class: 'controls' }, all),
    h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Patch tree' },
      h('table', { class: 'tree' }, h('caption', {}, 'Patch tree'),
        h('thead', {}, h('tr', {}, [['patch'], ['area', 1], ['triangles', 1], ['mean outward displacement', 1], ['largest displacement', 1], ['contribution', 1], ['share of the change']]
          .map(([words, isNumber]) => h('th', { scope: 'col', class: isNumber && 'number' }, words)))), body)), told);
}
