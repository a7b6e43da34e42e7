// @ts-check
/**
 * The operator's hand on pad or keys, and whether it counts. Sans-IO: the room asks.
 *
 * A hand counts only while the page is visible and focused, the dead man's button is held, and the
 * pad sends new values. After the page was hidden, or a pad was lost, it must be let go first.
 */

export const STILL_MS = 10_000; // a pad without new values for so long may be out of reach
const DEAD_ZONE = 0.12; // of a pad's axis
const DEAD_MAN = 4; // left shoulder button, in the standard layout of the Gamepad API
const STRENGTHS = 12; // gears
const FIRST = 3;

/** @typedef {{surge: number, turn: number, heave: number}} Axes ahead, to starboard, up: -1 to 1
 * @typedef {{id: string, timestamp: number, buttons: readonly {pressed: boolean}[],
 *   axes: readonly number[], connected: boolean}} Pad
 * @typedef {{axes: Axes | null, why: '' | 'hidden' | 'away' | 'still' | 'gone' | 'first'}} Held
 *   ``axes``: null while the dead man's button is let go; ``away``: the page was hidden, is in front
 *   again, and the button is still held */

/** @type {Readonly<Record<string, Partial<Axes>>>} */
const KEYS = {
  ArrowUp: { surge: 1 }, ArrowDown: { surge: -1 }, ArrowLeft: { turn: -1 }, ArrowRight: { turn: 1 },
  PageUp: { heave: 1 }, PageDown: { heave: -1 },
};

export class Hand {
  /** @type {Set<string>} */
  _down = new Set();
  _shift = false;
  _stamp = -1;
  _stampAt = 0; // ms
  _hadPad = false;
  _why = /** @type {Held['why']} */ ('');
  _areKeysFree = true; // the dead man's key was let go since the page was hidden
  _isPadFree = false; // the pad's button was let go since the pad appeared
  strength = FIRST;

  /** Take a key; is it one of the stick's? @param {string} code @param {boolean} shift
   * @param {boolean} [isRepeat] */
  press(code, shift, isRepeat = false) {
    this._shift = shift;
    if (!shift || (code.startsWith('Shift') && !isRepeat)) this._areKeysFree = true;
    const digit = /^(?:Digit|Numpad)([1-9])$/.exec(code)?.[1];
    if (digit) this.strength = Number(digit);
    if (code in KEYS) this._down.add(code);
    return digit !== undefined || code in KEYS;
  }

  /** @param {string} code @param {boolean} shift */
  release(code, shift) {
    this._shift = shift;
    if (!shift) this._areKeysFree = true;
    this._down.delete(code);
  }

  /** @param {number} by gears */
  change(by) {
    this.strength = Math.min(STRENGTHS, Math.max(1, this.strength + by));
  }

  /** Forget all keys; what is held must be let go first. @param {Held['why']} why */
  drop(why) {
    this._down.clear();
    this._shift = this._areKeysFree = this._isPadFree = false;
    this._why = why;
  }

  /** @param {Pad | null} pad @param {boolean} isInFront @param {number} now ms @returns {Held} */
  held(pad, isInFront, now) {
    if (!isInFront) this.drop('hidden');
    if (this._hadPad && pad === null) this.drop('gone');
    this._hadPad = pad !== null;
    const onPad = pad?.buttons[DEAD_MAN]?.pressed ?? false;
    const isStill = pad !== null && this._isStill(pad, now);
    if (pad !== null && !onPad && isInFront) this._isPadFree = true;
    if (pad !== null && onPad && this._isPadFree && !isStill) return this._counted(this._ofPad(pad));
    if (this._shift && this._areKeysFree) return this._counted(this._ofKeys());
    const isAway = !isInFront || (pad === null && this._why === 'gone');
    if (!onPad && !this._shift) return { axes: null, why: isAway ? this._why : '' };
    const before = this._why === 'hidden' && isInFront ? 'away' : this._why || 'first';
    return { axes: null, why: onPad && this._isPadFree ? 'still' : before };
  }

  /** @param {Axes} axes @returns {Held} */
  _counted(axes) {
    this._why = '';
    return { axes, why: '' };
  }

  /** @param {Pad} pad @param {number} now */
  _isStill(pad, now) {
    if (pad.timestamp !== this._stamp) [this._stamp, this._stampAt] = [pad.timestamp, now];
    return now - this._stampAt > STILL_MS;
  }

  /** @param {Pad} pad @returns {Axes} */
  _ofPad(pad) {
    const [turn = 0, ahead = 0, , up = 0] = pad.axes;
    return { surge: beyond(-ahead), turn: beyond(turn), heave: beyond(-up) };
  }

  /** @returns {Axes} */
  _ofKeys() {
    const axes = { surge: 0, turn: 0, heave: 0 };
    for (const code of this._down) {
      for (const [name, way] of Object.entries(KEYS[code] ?? {})) {
        axes[/** @type {keyof Axes} */ (name)] += (way * this.strength) / STRENGTHS;
      }
    }
    return axes;
  }
}

/** The value beyond the dead zone. @param {number} value of an axis */
export function beyond(value) {
  const size = Math.min(1, Math.abs(value));
  if (!(size > DEAD_ZONE)) return 0;
  return (Math.sign(value) * (size - DEAD_ZONE)) / (1 - DEAD_ZONE);
}
