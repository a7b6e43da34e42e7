// @ts-check
/**
 * Rooms that share a place take turns in it: two places on a wide screen, one on a narrow one.
 *
 * Each tab names its room; arrow keys go from one to the next. A room that is out of sight on the
 * one is ``wide-off``, on the other ``narrow-off``. What is picked on the one stands on the other,
 * too: a tablet is turned.
 */

import { byId, el, mark, say } from './dom.js';
import { word } from './words.js';

/** @typedef {'wide-off' | 'narrow-off'} Off */

export class Tabs {
  /** @param {HTMLElement} root @param {readonly string[]} rooms ids, which are words, too
   * @param {Off} off @param {(room: string) => void} picked by hand: every place takes it */
  constructor(root, rooms, off, picked) {
    this._rooms = rooms;
    this._off = off;
    this._picked = picked;
    this._buttons = rooms.map((room) => el('button', { type: 'button', role: 'tab',
      'aria-controls': room, onclick: () => picked(room) }));
    root.replaceChildren(...this._buttons);
    root.addEventListener('keydown', (event) => this._key(event));
    this.chosen = rooms[0] ?? '';
    this.take(this.chosen);
  }

  /** Nothing changes where another place has it. @param {string} room */
  take(room) {
    if (!this._rooms.includes(room)) return;
    this.chosen = room;
    this._rooms.forEach((one, i) => {
      byId(one).classList.toggle(this._off, one !== room);
      const button = this._buttons[i];
      if (button === undefined) return;
      mark(button, 'aria-selected', String(one === room));
      button.tabIndex = one === room ? 0 : -1;
    });
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (by === undefined) return;
    const i = (this._rooms.indexOf(this.chosen) + by + this._rooms.length) % this._rooms.length;
    this._picked(this._rooms[i] ?? this.chosen);
    this._buttons[i]?.focus();
    event.preventDefault();
  }

  show() {
    this._rooms.forEach((room, i) => {
      const button = this._buttons[i];
      if (button) say(button, word(room));
    });
  }
}
