// Choosing triangles by pointing, planes and boxes; the server computes them and says them as the case would.

import { h, choice, slider, tick, newId } from '../../../viewer/page/src/dom.js';
import { number } from '../../../viewer/page/src/format.js';
import { post, marksOf, newest } from './api.js';

const tools = [['patch', 'patches'], ['component', 'connected parts'], ['part', 'parts of the file'], ['flood', 'up to creases'],
  ['plane', 'a plane'], ['box', 'a box'], ['wing', 'a part of a wing (chord, span)'], ['rectangle', 'a rectangle of the view'], ['lasso', 'a lasso of the view'], ['triangle', 'single triangles']];
const axes = ['x', 'y', 'z'];

const words = (step) => {
  const sign = { '+': 'add', '-': 'subtract', '&': 'intersect with' }[step.op];
  if (step.patch) return `${sign} patch ${step.patch}`;
  if (step.component !== undefined) return `${sign} connected part ${step.component}`;
  if (step.part !== undefined) return `${sign} part ${step.part}`;
  if (step.flood) return `${sign} what is reached without a crease above ${step.flood.angle}°`;
  if (step.plane) return `${sign} ${step.plane.above ? 'above' : 'below'} the plane at ${number(step.plane.at)}`;
  if (step.box) return `${sign} a box`;
  if (step.wing) return `${sign} ${step.wing.of || 'the wing'}: chord ${step.wing.chord.map((v) => number(100 * v, 3)).join('–')} %, span ${step.wing.span.map((v) => number(100 * v, 3)).join('–')} %`;
  if (step.triangles) return `${sign} ${step.triangles.length} triangles of the view`;
  if (step.all) return `${sign} all`;
  if (step.grow !== undefined) return step.grow >= 0 ? `grow by ${number(step.grow)}` : `shrink by ${number(-step.grow)}`;
  if (step.region) return `${sign} region ${step.region}`;
  if (step.mirror) return 'with its mirror image';
  return 'complement';
};

export class Choosing {
  constructor(studio) {
    Object.assign(this, { studio, scene: studio.scene, editor: studio.editor, told: (words) => studio.tell(words) });
    const { scene } = this;
    this.tool = 'patch';
    this.op = '+';
    this.steps = [];
    this.angle = 30;
    this.through = false;
    this.plane = { axis: 0, share: 0.2, above: false };
    this.corners = [scene.body.facts.low.slice(), scene.body.facts.high.slice()];
    this.box = { of: '', chord: [0.15, 0.65], span: [0, 1], side: 'both' };
    this.name = 'held';
    this.fix = true;
    this.update = newest(() => this.ask());
  }

  get level() { const k = this.scene.colour.split(':'); return k[0] === 'level' ? Number(k[1]) : this.scene.body.facts.levels.length - 1; }

  at() { const { low, high } = this.scene.body.facts, a = this.plane.axis; return low[a] + this.plane.share * (high[a] - low[a]); }

  /** The step of a plane or box that is being dragged. */
  dragged() {
    if (this.tool === 'plane') {
      const normal = axes.map((_, k) => (k === this.plane.axis ? 1 : 0));
      return { op: this.op, plane: { normal, at: this.plane.typed ?? Number(this.at().toPrecision(4)), above: this.plane.above } };
    }
    if (this.tool === 'box') return { op: this.op, box: this.corners.map((c) => c.slice()) };
    if (this.tool === 'wing') return { op: this.op, wing: { ...this.box } };
    return null;
  }

  all() { const last = this.dragged(); return last ? [...this.steps, last] : this.steps; }

  /** What was dragged or typed can be undone, one change as long as it goes on. */
  remember() {
    const now = JSON.stringify([this.plane, this.corners, this.box]), before = this.was;
    this.was = now;
    if (!before || before === now) return;
    const set = (words) => { [this.plane, this.corners, this.box] = JSON.parse(words); this.was = words; this.options(); this.update(); };
    this.studio.history.add(`moved the ${this.tool}`, () => set(before), () => set(now), `shape ${this.tool}`);
  }

  async ask() {
    const { scene } = this, steps = this.all(), last = this.dragged();
    this.isAsking = true;
    this.remember();
    this.freshName();
    if (this.studio.tab === 'choose') scene.hint(last && last.plane, last && last.box);
    this.studio.handles();
    try {
      const found = await post('choose', { steps, name: this.name, text: this.editor.text });
      scene.chosen = found.triangles > 0 ? marksOf(found.marks, scene.body.count) : null;
      this.found.replaceChildren(h('p', {}, h('strong', {}, `${found.triangles} triangles`), `, area ${number(found.area)}`),
        found.lines.length > 0 ? h('pre', {}, found.lines.join('\n')) : '', h('p', { class: 'hint' }, found.kind ? `As ${found.kind}.` : ''));
      this.count = found.triangles;
    } catch (error) { this.found.replaceChildren(h('p', { class: 'problem' }, error.message)); }
    scene.paint();
    this.list.replaceChildren(...steps.map((s) => h('li', {}, words(s))));
    document.documentElement.dataset.chosen = String(this.count);
    this.isAsking = false;
  }

  push(step) { return this.setSteps([...this.steps, step], words(step)); }

  /** Can be undone. */
  setSteps(steps, why) {
    const before = this.steps, set = (list) => { this.steps = list; this.update(); };
    this.studio.history.add(why, () => set(before), () => set(steps));
    this.steps = steps;
    return this.update();
  }

  /** What can be dragged of the plane or box. */
  handleList() {
    const { center, low, high } = this.scene.body.facts, c = center;
    const knob = (at, along, moved, text) => ({ at: at.map((v, k) => v - c[k]), along, words: text, moved });
    if (this.tool === 'plane') {
      const { normal, at } = this.dragged().plane, middle = low.map((v, k) => (v + high[k]) / 2), a = this.plane.axis;
      middle[a] = at;
      return [knob(middle, normal, (length) => { this.plane.typed = Number((this.dragged().plane.at + length).toPrecision(5)); this.syncPlane(); this.update(); }, 'plane')];
    }
    if (this.tool === 'box') {
      const middle = axes.map((_, k) => (this.corners[0][k] + this.corners[1][k]) / 2);
      return axes.flatMap((_, a) => [0, 1].map((end) => {
        const at = middle.slice(), along = axes.map((_, k) => (k === a ? 1 : 0));
        at[a] = this.corners[end][a];
        return knob(at, along, (length) => {
          const to = this.corners[end][a] + length, other = this.corners[1 - end][a];
          this.corners[end][a] = Number((end === 0 ? Math.min(to, other) : Math.max(to, other)).toPrecision(6));
          this.options(); this.update();
        }, `${axes[a]} ${end ? 'to' : 'from'}`);
      }));
    }
    return [];
  }

  syncPlane() {
    const input = this.place.querySelector('input[type=number]'), ranged = this.place.querySelector('#plane-at'), { low, high } = this.scene.body.facts, a = this.plane.axis;
    if (input) input.value = String(this.dragged().plane.at);
    if (ranged) ranged.value = String(1000 * (this.dragged().plane.at - low[a]) / (high[a] - low[a] || 1));
  }

  /** A name that no region of the case has, unless the user has typed one: that replaces the region of that name. */
  freshName() {
    if (this.isTyped) return;
    const taken = new Set(this.editor.regions.map((r) => r.name));
    this.name = 'held';
    for (let k = 2; taken.has(this.name); ++k) this.name = `held${k}`;
    if (this.nameInput) this.nameInput.value = this.name;
  }

  /** A point of the surface was clicked. */
  pick(place) {
    const { body } = this.scene, { triangle, point } = place, { op } = this;
    if (this.tool === 'patch') {
      const level = body.facts.levels[this.level];
      if (!level) return this.told('This surface has no patches; choose otherwise.');
      return this.push({ op, patch: level.patches[body.array(level.array)[triangle]] });
    }
    if (this.tool === 'component') return this.push({ op, component: body.array('component')[triangle] });
    if (this.tool === 'part') {
      const part = body.array('part');
      return part ? this.push({ op, part: part[triangle] }) : this.told('The file names no parts; choose connected parts instead.');
    }
    if (this.tool === 'flood') return this.push({ op, flood: { point: body.middle(triangle), angle: this.angle } });
    if (this.tool === 'triangle') return this.push({ op, triangles: [triangle] });
    if (this.tool === 'plane') { this.plane.typed = Number(point[this.plane.axis].toPrecision(4)); this.options(); return this.update(); }
    return undefined;
  }

  /** A closed line of the view: lasso or rectangle. */
  enclose(line) {
    const triangles = this.scene.inLasso(line, this.through);
    if (triangles.length > 0) this.push({ op: this.op, triangles });
    else this.told(this.through ? 'Nothing lies in it.' : 'Nothing that is seen lies in it; through the body takes what is hidden, too.');
  }

  setTool(tool) { this.tool = tool; this.options(); this.update(); }

  numberBox(label, value, changed) {
    const input = h('input', { type: 'number', step: 'any', value: String(value), 'aria-label': label, onchange: () => { if (Number.isFinite(input.valueAsNumber)) changed(input.valueAsNumber); } });
    return input;
  }

  options() {
    const { body } = this.scene, parts = [];
    if (this.tool === 'patch') parts.push(h('p', { class: 'hint' }, `Click patches of level ${this.level + 1}; Colour changes the level.`));
    if (this.tool === 'flood') parts.push(slider('Angle of a crease', { min: 1, max: 90, step: 1, value: this.angle, id: 'flood-angle' }, (v) => { this.angle = v; this.angleWords.textContent = `${v}°`; }).label,
      this.angleWords = h('output', {}, `${this.angle}°`), h('p', { class: 'hint' }, 'Click: all is chosen that is reached without crossing a sharper edge.'));
    if (this.tool === 'plane') {
      const typed = this.numberBox('Position of the plane', this.plane.typed ?? Number(this.at().toPrecision(4)), (v) => { this.plane.typed = v; this.update(); });
      parts.push(choice('Normal to', axes.map((a, k) => [String(k), a]), String(this.plane.axis), (v) => { this.plane.axis = Number(v); this.plane.typed = undefined; this.options(); this.update(); }),
        choice('Side', [['below', 'below'], ['above', 'above']], this.plane.above ? 'above' : 'below', (v) => { this.plane.above = v === 'above'; this.update(); }),
        slider('at', { min: 0, max: 1000, step: 1, value: 1000 * this.plane.share, id: 'plane-at' }, (v) => { this.plane.share = v / 1000; this.plane.typed = undefined; typed.value = Number(this.at().toPrecision(4)); this.update(); }).label, typed,
        h('p', { class: 'hint' }, 'Drag the slider, type, or click the surface where the plane is to be.'));
    }
    if (this.tool === 'box') parts.push(...this.boxOptions());
    if (['rectangle', 'lasso'].includes(this.tool)) parts.push(tick('through the body', this.through, (v) => { this.through = v; }), h('p', { class: 'hint' }, `Drag a ${this.tool} over the surface; with Shift the view turns instead.`));
    if (this.tool === 'wing') parts.push(...this.wingOptions());
    if (['plane', 'box'].includes(this.tool)) parts.push(h('p', { class: 'hint' }, 'The dots on the surface can be dragged.'));
    if (['plane', 'box', 'wing'].includes(this.tool)) parts.push(h('button', { type: 'button', onclick: () => { const step = this.dragged(); this.tool = 'patch'; this.toolChoice.querySelector('select').value = 'patch'; this.options(); this.push(step); } }, 'Keep it, and go on with patches'));
    this.place.replaceChildren(...parts);
  }

  /** A row for each end of the box along each axis: slider and number, which follow each other. */
  boxOptions() {
    const { body } = this.scene, rows = [];
    const show = () => rows.forEach(({ a, k, typed, drawn }) => {
      typed.value = String(Number(this.corners[k][a].toPrecision(6)));
      drawn.input.value = String(1000 * (this.corners[k][a] - body.facts.low[a]) / (body.size[a] || 1));
    });
    const set = (a, k, value) => {
      this.corners[k][a] = value;
      if (this.corners[0][a] > this.corners[1][a]) this.corners[1 - k][a] = value;
      show();
      this.update();
    };
    for (let a = 0; a < 3; ++a)
      for (let k = 0; k < 2; ++k) {
        const label = `${axes[a]} ${k ? 'to' : 'from'}`;
        const drawn = slider(label, { min: 0, max: 1000, step: 1, id: `box-${axes[a]}-${k}`, value: 0 }, (v) => set(a, k, Number((body.facts.low[a] + (v / 1000) * body.size[a]).toPrecision(5))));
        rows.push({ a, k, drawn, typed: this.numberBox(label, 0, (v) => set(a, k, v)) });
      }
    show();
    return rows.map(({ drawn, typed }) => h('div', { class: 'end' }, drawn.label, typed));
  }

  /** Of a wing that the case declares, or of the one that was found. */
  wingOptions() {
    const declared = [...this.editor.text.matchAll(/^planform:[^\n]*\n((?:[ #][^\n]*\n?|\n)*)/gm)].flatMap((m) => [...m[1].matchAll(/^ {2}([\w-]+):/gm)].map((n) => n[1]));
    if (declared.length > 0 && !declared.includes(this.box.of)) [this.box.of] = declared;
    if (declared.length === 0) this.box.of = '';
    if (declared.length === 0 && this.scene.body.facts.wings.length === 0) return [h('p', { class: 'hint' }, 'No wing is found on this surface. Declare one under planform in the case.')];
    const range = (key, label) => [0, 1].map((k) => slider(`${label} ${k ? 'to' : 'from'}`, { min: 0, max: 100, step: 1, id: `wing-${key}-${k}`, value: 100 * this.box[key][k] }, (v) => {
      this.box[key][k] = v / 100;
      if (this.box[key][1] - this.box[key][0] < 0.01) this.box[key][k] = k ? this.box[key][0] + 0.01 : this.box[key][1] - 0.01;
      out.textContent = sizes();
      this.update();
    }).label);
    const sizes = () => `chord ${number(100 * this.box.chord[0], 3)}–${number(100 * this.box.chord[1], 3)} %, semispan ${number(100 * this.box.span[0], 3)}–${number(100 * this.box.span[1], 3)} %`;
    const out = h('output', {}, sizes());
    return [declared.length > 0 ? choice('Wing', declared.map((n) => [n, n]), this.box.of, (v) => { this.box.of = v; this.update(); }) : h('p', { class: 'hint' }, 'The wing that was found; the case will declare it.'),
      ...range('chord', 'chord'), ...range('span', 'span'), out,
      choice('Side', [['both', 'both'], ['upper', 'upper'], ['lower', 'lower']], this.box.side, (v) => { this.box.side = v; this.update(); })];
  }

  /** Adds the mirror image of what is chosen, where the whole body has one. */
  mirrorButton() {
    const { symmetry } = this.scene.body.facts, has = Boolean(symmetry) && !symmetry.is_half;
    return h('button', { type: 'button', id: 'mirror', disabled: !has, title: has ? 'Adds the mirror image of what is chosen' : 'No plane of symmetry of a whole body is found',
      onclick: () => this.push({ op: '+', mirror: { normal: symmetry.normal, offset: symmetry.offset } }) }, 'Mirror');
  }

  panel() {
    this.place = h('div', { class: 'controls options' });
    this.found = h('div', { 'aria-live': 'polite', class: 'found' });
    this.list = h('ol', { class: 'steps' });
    this.toolChoice = choice('Choose by', tools, this.tool, (v) => this.setTool(v));
    const by = h('input', { type: 'number', step: 'any', value: String(Number((0.01 * this.scene.body.diagonal).toPrecision(2))), 'aria-label': 'Length to grow by' });
    const name = h('input', { type: 'text', id: newId('name'), value: this.name, size: 14, maxlength: 60, oninput: () => { this.name = name.value || 'chosen'; this.isTyped = true; } });
    this.nameInput = name;
    const button = (label, work) => h('button', { type: 'button', onclick: work }, label);
    this.options();
    this.update();
    return [
      h('div', { class: 'controls' }, this.toolChoice, choice('and', [['+', 'add'], ['-', 'subtract'], ['&', 'intersect']], this.op, (v) => { this.op = v; this.update(); })),
      this.place,
      h('div', { class: 'controls' }, button('Undo', () => { if (this.steps.length > 0) this.setSteps(this.steps.slice(0, -1), 'a step less'); }), button('Clear', () => { this.setSteps([], 'clear'); this.setTool('patch'); this.toolChoice.querySelector('select').value = 'patch'; }),
        button('All', () => this.push({ op: this.op, all: true })), button('Complement', () => this.push({ op: '+', invert: true })), this.mirrorButton(),
        h('span', { class: 'control' }, button('Grow', () => this.push({ op: '+', grow: by.valueAsNumber || 0 })), button('Shrink', () => this.push({ op: '+', grow: -(by.valueAsNumber || 0) })), h('span', {}, 'by'), by)),
      this.list, this.found,
      h('div', { class: 'controls' }, h('label', { class: 'control' }, h('span', {}, 'Name'), name), tick('it does not move (fixed)', this.fix, (v) => { this.fix = v; }),
        h('button', { type: 'button', id: 'put-region', class: 'main', onclick: () => this.put() }, 'Put it into the case')),
    ];
  }

  async put() {
    try {
      const made = await post('region', { steps: this.all(), name: this.name, text: this.editor.text, fix: this.fix });
      this.editor.replace(made.text, `region ${this.name}, as ${made.kind}`);
      const replaced = this.editor.regions.some((r) => r.name === this.name) ? ', in place of the one of that name' : '';
      const put = this.name;
      await this.editor.ask();
      this.isTyped = false;
      this.steps = [];
      this.tool = 'patch';
      this.setTool('patch');
      this.toolChoice.querySelector('select').value = 'patch';
      this.told(`The case has the region ${put} now, as ${made.kind}${replaced}.${made.taken_out ? ` \`${made.taken_out}\` is taken out: what is fixed holds the body now.` : ''} Save it under Case.`);
    } catch (error) { this.told(error.message); }
  }
}
