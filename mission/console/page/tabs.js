// @ts-check
/**
 * Tabs for rooms that share a place: two places on a wide screen, one on a narrow one.
 *
 * Each tab names its room; arrow keys move between tabs. A hidden room is ``wide-off`` on a wide
 * screen, ``narrow-off`` on a narrow one. A choice counts for both, because a tablet may be turned.
 */

import { byId, el, mark, say } from './dom.js';
import { word } from './words.js';

/** @typedef {'wide-off' | 'narrow-off'} Off */

export class Tabs {
  /** @param {HTMLElement} root @param {readonly string[]} rooms ids, which are also keys of words
   * @param {Off} off @param {(room: string) => void} picked by the user: every place shows it */
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

  /** Show a room; a place without this room does not change. @param {string} room */
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
