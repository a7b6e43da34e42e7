// @ts-check
/**
 * One undo for a text, whoever changes it: what is typed in one go is one step, each edit of the
 * chart one of its own.
 */

/** @typedef {{text: string, at: number, of?: Origin}} Step
 *   ``at``: where the caret stood, UTF-16
 * @typedef {{source: string, notes: string[]}} Origin
 *   of a text that was opened, and of all that is made of it */

const MOST = 500; // steps
const CHARACTERS = 1 << 23; // of all of them
const PAUSE_MS = 800; // of typing, after which another step begins

export class History {
  /** @param {Step} first */
  constructor(first) {
    /** @type {Step[]} */
    this._done = [first];
    /** @type {Step[]} */
    this._undone = [];
    this._typed = -Infinity;
  }

  get now() {
    return /** @type {Step} */ (this._done.at(-1));
  }

  get canUndo() {
    return this._done.length > 1;
  }

  get canRedo() {
    return this._undone.length > 0;
  }

  /** @param {Step} step @param {number} [typed] ms, when; left out: a step of its own */
  add(step, typed) {
    const made = { ...step, of: step.of ?? this.now.of };
    if (step.text === this.now.text) {
      Object.assign(this.now, made);
      return;
    }
    const goesOn = typed !== undefined && typed - this._typed < PAUSE_MS && this.canUndo;
    if (goesOn) this._done.pop();
    this._done.push(made);
    this._undone = [];
    this._typed = typed ?? -Infinity;
    this._forget();
  }

  undo() {
    const last = this.canUndo ? this._done.pop() : undefined;
    if (last) this._undone.push(last);
    this._typed = -Infinity;
    return this.now;
  }

  redo() {
    const next = this._undone.pop();
    if (next) this._done.push(next);
    this._typed = -Infinity;
    return this.now;
  }

  /** The oldest, where they are too many. */
  _forget() {
    let all = this._done.reduce((sum, step) => sum + step.text.length, 0);
    while (this._done.length > 2 && (this._done.length > MOST || all > CHARACTERS)) {
      all -= this._done.shift()?.text.length ?? 0;
    }
  }
}
