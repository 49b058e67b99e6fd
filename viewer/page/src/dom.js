// Elements from data. Strings become text, never markup.

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'class') element.className = value;
    else if (name === 'style') element.style.cssText = value;  // the attribute is refused without 'unsafe-inline'
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(3).filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

let count = 0;
export const newId = (word) => `${word}-${++count}`;

export function section(id, heading, ...children) {
  return h('section', { id, 'aria-labelledby': `${id}-heading` }, h('h2', { id: `${id}-heading` }, heading), ...children);
}

/** A labelled drop-down. choices: [value, words][]; `changed` receives the value. */
export function choice(words, choices, value, changed) {
  const select = h('select', { onchange: () => changed(select.value) },
    choices.map(([v, w]) => h('option', { value: v, selected: v === value }, w)));
  return h('label', { class: 'control' }, h('span', {}, words), select);
}

export function slider(words, { min, max, step, value, id }, changed) {
  const input = h('input', { type: 'range', min, max, step, value, id, oninput: () => changed(Number(input.value)) });
  return { label: h('label', { class: 'control wide' }, h('span', {}, words), input), input };
}

export function tick(words, value, changed) {
  const box = h('input', { type: 'checkbox', checked: value, onchange: () => changed(box.checked) });
  return h('label', { class: 'control tick' }, box, h('span', {}, words));
}

/** headings: [words, isNumber][]; rows of strings or elements. In a narrow window each row becomes a list (page.css), of
 * which the roles keep telling that it is a row of a table. */
export function table(caption, headings, rows) {
  const cell = (value, k) => h(k === 0 ? 'th' : 'td', { scope: k === 0 && 'row', role: k === 0 ? 'rowheader' : 'cell',
    class: headings[k][1] && 'number', 'data-heading': headings[k][0] }, h('span', {}, value));
  return h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption },
    h('table', { role: 'table', class: headings.length > 3 && 'stacks' }, h('caption', {}, caption),
      h('thead', { role: 'rowgroup' }, h('tr', { role: 'row' }, headings.map(([words, isNumber]) =>
        h('th', { scope: 'col', role: 'columnheader', class: isNumber && 'number' }, words)))),
      h('tbody', { role: 'rowgroup' }, rows.map((row) => h('tr', { role: 'row' }, row.map(cell))))));
}
