// @ts-check
/**
 * One undo history for a text, whatever changes it: continuous typing is one step, and each edit on
 * the chart is one step.
 */

/** @typedef {{text: string, at: number, of?: Origin}} Step
 *   ``at``: position of the caret, UTF-16
 * @typedef {{source: string, notes: string[]}} Origin
 *   of an opened text, and of all its later versions */

const MOST = 500; // steps
const CHARACTERS = 1 << 23; // of all steps together
const PAUSE_MS = 800; // without typing, after which another step begins

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

  /** @param {Step} step @param {number} [typed] ms, when; without it: a step of its own */
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

  /** Drop the oldest steps if there are too many. */
  _forget() {
    let all = this._done.reduce((sum, step) => sum + step.text.length, 0);
    while (this._done.length > 2 && (this._done.length > MOST || all > CHARACTERS)) {
      all -= this._done.shift()?.text.length ?? 0;
    }
  }
}
