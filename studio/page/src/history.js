// Every change of the page can be undone and done again.

export class History {
  constructor(changed) {
    this.done = [];
    this.undone = [];
    this.changed = changed;
  }

  /** words: "3 evaluations"; back and again restore what was before and after. A change with the same key right after
   * another (a slider that is still dragged) becomes one with it. */
  add(words, back, again, key = null) {
    const last = this.done[this.done.length - 1];
    if (key && last && last.key === key && performance.now() - last.at < 1500) Object.assign(last, { again, words, at: performance.now() });
    else this.done.push({ words, back, again, key, at: performance.now() });
    if (this.done.length > 300) this.done.shift();
    this.undone = [];
    this.changed();
  }

  undo() {
    const one = this.done.pop();
    if (!one) return;
    this.undone.push(one);
    one.back();
    this.changed();
  }

  redo() {
    const one = this.undone.pop();
    if (!one) return;
    this.done.push({ ...one, key: null });
    one.again();
    this.changed();
  }

  get next() { return this.done.length > 0 ? this.done[this.done.length - 1].words : null; }
  get again() { return this.undone.length > 0 ? this.undone[this.undone.length - 1].words : null; }
}
