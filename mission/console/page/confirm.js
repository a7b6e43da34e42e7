// @ts-check
/**
 * A button that asks before it acts: the first press shows what will happen, and where. A second
 * press soon after, on the same text, does it.
 */

import { el, say } from './dom.js';
import { word } from './words.js';

const WITHIN_MS = 6000;
const BOUNCE_MS = 300; // a double click counts as one press

export class Confirm {
  /** @param {string} name its label @param {() => string} what will happen; "": nothing can
   * @param {(what: string, moved: number) => void} act ``moved``: ms, time of the second press */
  constructor(name, what, act) {
    this._name = name;
    this._what = what;
    this._act = act;
    this._asked = '';
    this._at = 0;
    this.button = el('button', { type: 'button', onclick: (/** @type {Event} */ e) => this._press(e) });
    this.button.addEventListener('blur', () => this._forget());
  }

  /** @param {Event} event */
  _press(event) {
    const what = this._what();
    const now = performance.now();
    if (this._asked && now - this._at < BOUNCE_MS) return;
    const meant = this._asked === what && what !== '' && now - this._at < WITHIN_MS;
    [this._asked, this._at] = meant ? ['', 0] : [what, now];
    if (meant) this._act(what, event.timeStamp);
    this.show(now);
  }

  _forget() {
    this._asked = '';
    this.show(performance.now());
  }

  /** @param {number} now ms */
  show(now) {
    const what = this._what();
    if (this._asked && (now - this._at > WITHIN_MS || this._asked !== what)) this._asked = '';
    this.button.classList.toggle('asks', this._asked !== '');
    this.button.disabled = what === '';
    say(this.button, this._asked ? word('again', this._asked) : word(this._name));
  }
}
