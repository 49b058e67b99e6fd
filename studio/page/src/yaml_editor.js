// The case file as text: CodeMirror with YAML, errors at their lines, and the keys of the schema as completions and
// explanations. Its styles need a shadow root: the page allows no inline style. Undo is the studio's.

import { EditorState } from '@codemirror/state';
import { EditorView, keymap, lineNumbers, highlightActiveLine, hoverTooltip, drawSelection } from '@codemirror/view';
import { defaultKeymap, indentWithTab } from '@codemirror/commands';
import { syntaxHighlighting, HighlightStyle, bracketMatching, foldGutter, indentUnit } from '@codemirror/language';
import { yaml } from '@codemirror/lang-yaml';
import { autocompletion, completionKeymap, closeBrackets, closeBracketsKeymap } from '@codemirror/autocomplete';
import { setDiagnostics, lintGutter } from '@codemirror/lint';
import { search, searchKeymap } from '@codemirror/search';
import { tags } from '@lezer/highlight';
import { h } from '../../../viewer/page/src/dom.js';

const colors = HighlightStyle.define([
  { tag: [tags.definition(tags.propertyName), tags.propertyName], color: 'var(--good)', fontWeight: '600' },
  { tag: tags.comment, color: 'var(--soft)', fontStyle: 'italic' },
  { tag: [tags.string, tags.special(tags.string)], color: 'var(--bad)' },
  { tag: [tags.punctuation, tags.separator, tags.squareBracket, tags.brace], color: 'var(--soft)' },
]);
const theme = EditorView.theme({
  '&': { color: 'var(--ink)', backgroundColor: 'var(--field)', height: '24rem', fontSize: '.82rem' },
  '.cm-scroller': { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: '1.45' },
  '&.cm-focused': { outline: '2px solid var(--main)', outlineOffset: '-2px' },
  '.cm-content': { caretColor: 'var(--ink)' },
  '.cm-cursor': { borderLeftColor: 'var(--ink)' },
  '.cm-gutters': { backgroundColor: 'var(--quiet)', color: 'var(--soft)', borderRight: '1px solid var(--line)' },
  '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'color-mix(in srgb, var(--main) 9%, transparent)' },
  '&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground': { background: 'color-mix(in srgb, var(--main) 28%, transparent)' },
  '.cm-tooltip, .cm-panels': { color: 'var(--ink)', backgroundColor: 'var(--panel)', border: '1px solid var(--edge)', maxWidth: '28rem' },
  '.cm-tooltip-autocomplete ul li[aria-selected]': { backgroundColor: 'var(--main)', color: 'var(--on-main)' },
  '.cm-completionInfo, .key-doc': { padding: '.3rem .6rem', font: '.85rem/1.4 system-ui, "DejaVu Sans", sans-serif', whiteSpace: 'normal' },
  '.cm-diagnostic': { font: '.85rem/1.4 system-ui, "DejaVu Sans", sans-serif', whiteSpace: 'pre-wrap' },
});

const indentOf = (line) => line.match(/^ */)[0].length;
const keyOf = (line) => { const found = line.match(/^ *(?:- +)*(?:"([^"]*)"|'([^']*)'|([^\s#:'"{}[\],][^:#{}[\],]*?)) *:(?= |$)/); return found ? found[1] ?? found[2] ?? found[3] : null; };

/** Steps inside the braces of one line before the cursor: keys of open maps, "[]" of open lists. */
function stepsInside(before) {
  const steps = [];
  let word = '';
  for (const c of before) {
    if (c === '{') { steps.push(word.replace(/.*[,{[]/, '').replace(/:\s*$/, '').replace(/^[\s-]+/, '').trim()); word = ''; } else if (c === '[') { steps.push(`${word.replace(/:\s*$/, '').trim()}[]`); word = ''; } else if (c === '}' || c === ']') { steps.pop(); word = ''; } else if (c === ',') word = ''; else word += c;
  }
  return { steps, rest: word };
}

/** Where the cursor is: {path: ["regions", "tip"], typed: text of the entry so far}. */
export function placeIn(lines, row, column) {
  const before = lines[row].slice(0, column), inside = stepsInside(before), path = [];
  let indent = before.trim() === '' ? before.length : indentOf(before);
  if (/^ *- /.test(before)) { path.unshift('[]'); indent += 0; }
  for (let k = row - 1; k >= 0 && indent > 0; --k) {
    const line = lines[k];
    if (!line.trim() || line.trim().startsWith('#')) continue;
    const i = indentOf(line), isItem = /^ *- /.test(line);
    if (isItem && path[0] !== '[]' && i + 2 === indent) { path.unshift('[]'); indent = i; continue; }
    if (i < indent || (path[0] === '[]' && i <= indent && !isItem)) { const key = keyOf(line); if (key !== null && !isItem) { path.unshift(key); indent = i; } }
  }
  const steps = [];
  for (const one of [...path, ...inside.steps.flatMap((s) => (s.endsWith('[]') ? [s.slice(0, -2), '[]'] : [s])).filter((s) => s !== '')]) {
    if (one === '[]' && steps.length > 0) steps[steps.length - 1] += '[]'; else steps.push(one);
  }
  return { path: steps, typed: inside.steps.length > 0 ? inside.rest : before.replace(/^ *(- +)*/, '') };
}

/** "regions.*.box" means ["regions", "tip", "box"], also of entries of lists. */
function means(pattern, path) {
  return pattern.length === path.length && pattern.every((step, k) => step === path[k] || (step === '*' && !path[k].endsWith('[]')));
}

export class YamlEditor extends EventTarget {
  constructor(label) {
    super();
    this.keys = [];
    this.names = () => ({});
    this.isSet = false;
    this.element = h('div', { id: 'case-text', class: 'editor' });
    const root = this.element.attachShadow({ mode: 'open' });
    this.view = new EditorView({ root, parent: root, state: EditorState.create({ doc: '', extensions: [
      lineNumbers(), foldGutter(), lintGutter(), highlightActiveLine(), drawSelection(), bracketMatching(), closeBrackets(), search({ top: true }), yaml(), indentUnit.of('  '),
      syntaxHighlighting(colors), theme, EditorView.contentAttributes.of({ 'aria-label': label, spellcheck: 'false', autocorrect: 'off', autocapitalize: 'off' }),
      autocompletion({ override: [(context) => this.complete(context)], icons: false }), hoverTooltip((view, at) => this.explain(at)),
      // Tab leaves the editor after Escape, as readers of screens expect.
      keymap.of([...closeBracketsKeymap, ...completionKeymap, ...searchKeymap, ...defaultKeymap, indentWithTab]),
      EditorView.updateListener.of((update) => { if (update.docChanged && !this.isSet) this.dispatchEvent(new Event('input')); }),
    ] }) });
  }

  get value() { return this.view.state.doc.toString(); }
  set value(words) {
    const text = words.replace(/\r\n?/g, '\n');
    const now = this.value;
    if (text === now) return;
    let from = 0, end = 0;
    const shorter = Math.min(text.length, now.length);
    while (from < shorter && text[from] === now[from]) ++from;
    while (end < shorter - from && text[text.length - 1 - end] === now[now.length - 1 - end]) ++end;
    this.isSet = true;
    try { this.view.dispatch({ changes: { from, to: now.length - end, insert: text.slice(from, text.length - end) } }); } finally { this.isSet = false; }
  }

  /** [{line, message}] */
  set errors(list) {
    const { doc } = this.view.state;
    this.view.dispatch(setDiagnostics(this.view.state, list.filter((e) => e.line >= 1 && e.line <= doc.lines).map((e) => {
      const line = doc.line(e.line), from = line.from + indentOf(line.text);
      return { from: Math.min(from, line.to), to: line.to, severity: 'error', message: e.message };
    })));
  }

  goTo(number) {
    const { doc } = this.view.state, line = doc.line(Math.min(Math.max(1, number), doc.lines));
    this.view.dispatch({ selection: { anchor: line.from, head: line.to }, effects: EditorView.scrollIntoView(line.from, { y: 'center' }) });
    this.view.focus();
  }

  placeAt(at) {
    const { doc } = this.view.state, line = doc.lineAt(at);
    const lines = [];
    for (let k = 1; k <= line.number; ++k) lines.push(doc.line(k).text);
    return placeIn(lines, line.number - 1, at - line.from);
  }

  rowsAt(path) { return this.keys.filter((key) => means(key.steps, path)); }

  complete(context) {
    const { path, typed } = this.placeAt(context.pos), colon = typed.match(/^\s*["']?([^:"']+)["']?\s*:\s+(.*)$/);
    if (/#/.test(typed)) return null;
    if (colon) return this.values(context, [...path, colon[1].trim()]);
    if (path.length > 0 && path[path.length - 1].endsWith('[]')) {
      const found = this.values(context, [...path.slice(0, -1), path[path.length - 1].slice(0, -2)]);
      if (found) return found;
    }
    const word = context.matchBefore(/[\w@.-]*/);
    if (!context.explicit && word.from === word.to) return null;
    const below = this.keys.filter((key) => key.steps.length === path.length + 1 && means(key.steps.slice(0, -1), path) && key.steps[path.length] !== '*' && !key.steps[path.length].endsWith('[]'));
    if (below.length === 0) return null;
    const known = new Map();
    for (const key of below) { const name = key.steps[path.length]; known.set(name, [...(known.get(name) || []), key]); }
    return { from: word.from, validFor: /^[\w@.-]*$/, options: [...known].map(([label, keys]) => ({ label, apply: `${label}: `, detail: keys.map((k) => k.form).join('; ').slice(0, 60), info: () => this.words(keys) })) };
  }

  values(context, path) {
    const rows = this.rowsAt(path), word = context.matchBefore(/[\w@.-]*/);
    if (!context.explicit && word.from === word.to && !/[:[,] $|[[]$/.test(context.state.sliceDoc(Math.max(0, context.pos - 2), context.pos))) return null;
    const words = rows.flatMap((key) => [...key.words, ...(key.is_flag ? ['true', 'false'] : [])]), { regions = [], quantities = [] } = this.names();
    const last = path[path.length - 1];
    if (['fixed', 'region', 'movable', 'on'].includes(last)) words.push(...regions);
    if (['minimize', 'maximize'].includes(last)) words.push(...quantities);
    if (words.length === 0) return null;
    return { from: word.from, validFor: /^[\w@.-]*$/, options: [...new Set(words)].map((label) => ({ label, info: rows.length > 0 ? () => this.words(rows) : undefined })) };
  }

  words(keys) {
    return h('div', { class: 'key-doc' }, keys.map((key) => h('p', {}, h('strong', {}, key.path), ` (${key.form}${key.limits ? `, ${key.limits}` : ''}${key.default ? `; default ${key.default}` : ''}): ${key.doc}`)));
  }

  explain(at) {
    const line = this.view.state.doc.lineAt(at), from = at - line.from;
    const left = line.text.slice(0, from).match(/[\w@-]*$/)[0].length, right = line.text.slice(from).match(/^[\w@-]*/)[0].length;
    const word = line.text.slice(from - left, from + right);
    if (!word || !/^\s*["']?\s*:/.test(line.text.slice(from + right))) return null;
    const { path } = this.placeAt(line.from + from - left), rows = this.rowsAt([...path, word]);
    return rows.length === 0 ? null : { pos: at - left, end: at + right, create: () => ({ dom: this.words(rows) }) };
  }
}
