// The goal, the result, why the run stopped, what to try next; and the tables.

import { h, section, table } from '../../../viewer/page/src/dom.js';
import { number, change, duration, parameterValue, plural } from '../../../viewer/page/src/format.js';

const marks = { converged: '✔', budget: '■', sampled: '✔', progress: '■', roundoff: '✔', interrupted: '❚❚', waiting: '…', running: '▶', killed: '✖' };
const good = ['converged', 'sampled', 'budget', 'progress', 'roundoff', 'running', 'waiting'];

export function head(run) {
  const { status } = run.end;
  return h('header', {},
    h('p', { class: 'kind' }, `Strake · ${run.is_fit ? 'fit' : run.samples ? 'samples' : 'optimization'} · ${run.folder}`),
    h('h1', {}, run.title),
    h('p', { class: `status ${good.includes(status) ? 'good' : 'bad'}` }, h('span', { 'aria-hidden': 'true' }, `${marks[status] || '✖'} `), status.replace(/_/g, ' ')),
    h('nav', { 'aria-label': 'Sections of this page' },
      [['summary', 'Summary'], ...(run.samples ? [['samples', 'Samples']] : []), ['progress', 'Progress'], ...(run.wings && run.wings.length > 0 ? [['wings', run.wings.length > 1 ? 'Wings' : 'Wing']] : []), ...(run.bodies && run.bodies.length > 0 ? [['bodies', run.bodies.length > 1 ? 'Bodies' : 'Body']] : []), ['shapes', 'Shape'], ['patches', 'Patches'], ['failures', 'Failures'], ['cost', 'Cost'], ['case', 'Case']]
        .map(([id, words]) => h('a', { href: `#${id}` }, words))));
}

function figure(words, value, below) {
  return h('div', { class: 'figure' }, h('span', { class: 'value' }, value), h('span', { class: 'label' }, words), below && h('span', { class: 'below' }, below));
}

function figures(run) {
  const { end } = run, measure = (j) => (run.is_fit && Number.isFinite(j) ? Math.sqrt(j) : j);
  const from = measure(end.objective_start), to = measure(end.objective);
  const moved = run.history.moved[run.history.evaluation.indexOf(end.best_evaluation)];
  return h('div', { class: 'figures' },
    figure(run.is_fit ? 'rms distance' : `objective, ${run.maximize ? 'maximized' : 'minimized'}`, change(from, to), `${number(from)} → ${number(to)}`),
    figure('largest violation', number(end.max_violation, 2), !Number.isFinite(end.max_violation) ? 'no design' : end.max_violation > 0 ? 'scaled by the limit' : 'all constraints met'),
    figure('evaluations', String(end.evaluations), end.max_evaluations ? `of ${end.max_evaluations}` : null),
    figure('largest displacement', run.shapes && Number.isFinite(moved) ? `${number((100 * moved) / run.shapes.surface.diagonal, 3)} %` : number(moved, 3),
      run.shapes ? 'of the diagonal' : run.units),
    figure('time', duration(end.seconds), plural(run.levels.length, 'level')));
}

function valueTable(run) {
  const { values, parameters } = run.quantities;
  const rows = [...values.map((v) => [v.name, number(v.start), number(v.best), change(v.start, v.best), v.limit]),
    ...parameters.map((v) => [v.name, parameterValue(v.start, v.unit), parameterValue(v.best, v.unit), '', 'parameter'])];
  return rows.length > 0 && table('Values at the start and at the best design', [['value', false], ['start', true], ['best', true], ['change', true], ['limit', false]], rows);
}

/** The start and the best design, drawn when the page was made: for browsers without WebGL, and for paper. */
function pictures(run) {
  const { pictures: list = [] } = run.shapes ?? {};
  if (list.length === 0) return null;
  return h('div', { class: 'pictures' }, list.map(({ title, words, most, image }) => {
    const moved = most ? `${words}, at most ${number(100 * most, 2)} % of the diagonal along the normal` : words;
    return h('figure', {}, h('figcaption', {}, title, moved && h('span', { class: 'moved' }, `: ${moved}`)),
      h('img', { src: image, alt: `${title} of ${run.title}, seen obliquely from ahead and above${moved && `; ${moved}`}` }));
  }));
}

export function summary(run) {
  return section('summary', 'Summary', pictures(run), figures(run),
    h('div', { class: 'columns' },
      h('div', {}, h('h3', {}, 'Goal'),
        run.asked.length > 0 ? h('dl', {}, run.asked.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)])) : h('p', {}, 'See the case below.')),
      h('div', {}, h('h3', {}, 'Result'),
        run.end.best_evaluation > 0 ? h('p', {}, `The best design is evaluation ${run.end.best_evaluation}, on level ${run.levels.length ? run.history.level[run.history.evaluation.indexOf(run.end.best_evaluation)] : run.end.level}.`)
          : h('p', {}, 'There is no design: no evaluation returned a value.'),
        h('h3', {}, 'Why it stopped'), h('p', { class: 'reason' }, run.end.reason || '–'),
        h('h3', {}, 'What to try next'),
        run.next.length > 0 ? h('ul', {}, run.next.map((words) => h('li', {}, code(words)))) : h('p', {}, 'Inspect the shape, then the variables at their bounds.'))),
    valueTable(run), run.notes.map((words) => h('p', { class: 'problem' }, words)), levelTable(run));
}

/** `words` between backquotes as code. */
function code(words) {
  return words.split('`').map((part, k) => (k % 2 === 1 ? h('code', {}, part) : part));
}

function levelTable(run) {
  if (run.levels.length === 0) return null;
  const first = run.levels.find((l) => Number.isFinite(l.objective_start));
  const last = [...run.levels].reverse().find((l) => Number.isFinite(l.objective_end));
  const whole = last?.objective_end - first?.objective_start;
  // From end to end: a level may start where an earlier one was, and the shares add up to the whole.
  let before = first?.objective_start;
  const gained = (level) => {
    if (!Number.isFinite(level.objective_end)) return 0;
    const gain = level.objective_end - before;
    before = level.objective_end;
    return gain;
  };
  return table('Levels and their gains', [['level', false], ['patches', true], ['variables', true], ['evaluations', true], ['objective from', true], ['to', true], ['share of the gain', true], ['why it ended', false]],
    run.levels.map((l) => [String(l.level), l.patches === undefined ? '–' : String(l.patches), l.variables === undefined ? String(l.shape_variables.names.length || '–') : String(l.variables),
      String(l.evaluations), number(l.objective_start), number(l.objective_end),
      whole ? `${number((100 * gained(l)) / whole, 3)} %` : '–', l.stop || '–']));
}

export function failures(run) {
  const { count, kinds, rows, left_out: left } = run.failures;
  if (count === 0) return section('failures', 'Failures', h('p', {}, 'Every evaluation returned a value.'));
  const of = run.history.evaluation.length;
  return section('failures', 'Failures',
    h('p', {}, `${count} of ${plural(of, 'evaluation')} returned no value: ${Object.entries(kinds).map(([k, n]) => `${n} × ${k.replace(/_/g, ' ')}`).join(', ')}.`
      + (left ? ` Only the last ${rows.length} are listed.` : '')),
    rows.map((row, k) => h('details', { class: 'failure', open: row.ends_run || (k === rows.length - 1 && rows.length <= 3) },
      h('summary', {}, `Evaluation ${row.evaluation}, level ${row.level}: `, h('strong', {}, row.status.replace(/_/g, ' ')),
        row.ends_run ? ', which ended the run' : '', ' ', h('span', { class: 'first-line' }, row.reason.split('\n')[0].slice(0, 160))),
      h('pre', {}, row.reason),
      row.logs.map((log) => [h('h4', {}, `End of ${log.name}`), h('pre', { tabindex: 0 }, log.tail)]))));
}

export function cost(run) {
  const { cost: c } = run;
  const parts = [];
  if (c.levels.length > 0)
    parts.push(table('Evaluations and their time, by level', [['level', false], ['evaluations', true], ['failed', true], ['inherited', true], ['time', true], ['each', true]],
      [...c.levels.map((l) => [String(l.level), String(l.evaluations), String(l.failed), String(l.taken_over), duration(l.seconds), duration(l.seconds / l.evaluations)]),
        ['all', String(run.history.evaluation.length), String(run.failures.count), '', duration(c.in_evaluations), duration(c.in_evaluations / run.history.evaluation.length)]]));
  if (c.programs.length > 0)
    parts.push(table('Program calls', [['value', false], ['calls', true], ['failed', true], ['from the cache', true], ['time', true], ['each', true]],
      c.programs.map((p) => [p.name, String(p.calls), String(p.failed), String(p.cached), duration(p.seconds), duration(p.seconds / p.calls)])));
  parts.push(h('p', {}, `The run took ${duration(c.elapsed)} over all its starts, ${duration(c.in_evaluations)} of it in evaluations (shape and values); the rest is the search itself, levels and files.`));
  return section('cost', 'Cost', parts);
}

export function theCase(run) {
  return section('case', 'Case', h('p', {}, 'The case as used, with defaults filled in.'), h('pre', { tabindex: 0, class: 'yaml' }, run.yaml));
}

/** Every evaluation as a table: the data of the charts. */
export function evaluations(run) {
  const { history } = run, most = 500, n = history.evaluation.length;
  const list = history.evaluation.map((_, i) => i).filter((i) => n <= most || history.accepted[i] || i >= n - 50);
  return section('evaluations', 'Evaluations', h('details', {}, h('summary', {}, `Show as a table (${list.length === n ? n : `${list.length} of ${n}: accepted and last ones`})`),
    table('Evaluations', [['number', false], ['level', true], ['status', false], ['objective', true], ['violation', true], ['time', true], ['accepted', false]],
      list.map((i) => [String(history.evaluation[i]), String(history.level[i]), history.status[i], number(history.objective[i], 7), number(history.violation[i], 2),
        duration(history.seconds[i]), history.accepted[i] ? 'best so far' : '']))));
}
