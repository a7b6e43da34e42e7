// @ts-check
/**
 * X and W: one press each, by finger, mouse or key, in every view; the button shows the result.
 *
 * The keys work unless the user is typing text. A repeating key counts as one press.
 */

import { el, isWriting, say } from './dom.js';
import { ago } from './format.js';
import { isLive } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {'stop' | 'surface'} Order */

/** @type {Readonly<Record<string, Order>>} */
const KEYS = { x: 'stop', w: 'surface' };
const SHOWN_S = 600;

/** The letter of a key, also on a keyboard with other than Latin letters. @param {KeyboardEvent} event */
export function letter(event) {
  if (/^[a-z]$/i.test(event.key)) return event.key.toLowerCase();
  const isOther = event.key.length > 1 ? event.key === 'Process' : event.key > '\u024f';
  return isOther && event.code.startsWith('Key') ? event.code.slice(3).toLowerCase() : '';
}

export class Urgent {
  /** @param {(id: string) => HTMLElement} at @param {() => Page} page */
  constructor(at, page) {
    this._page = page;
    this._shown = { stop: face(at('stop')), surface: face(at('surface')) };
    for (const order of /** @type {Order[]} */ (['stop', 'surface'])) this._listen(at(order), order);
    document.addEventListener('keydown', (event) => this._key(event), { capture: true });
  }

  /** @param {HTMLElement} button @param {Order} order */
  _listen(button, order) {
    button.addEventListener('pointerdown', (event) => {
      if (event.button === 0) this._order(order, event);
    });
    button.addEventListener('click', (event) => {
      if (event.detail === 0) this._order(order, event); // by key: a pointer has sent it already
    });
  }

  /** @param {KeyboardEvent} event */
  _key(event) {
    const order = KEYS[letter(event)];
    if (order === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    if (isWriting(event.target)) return;
    event.preventDefault();
    if (!event.repeat) this._order(order, event);
  }

  /** @param {Order} order @param {Event} event */
  _order(order, event) {
    const { chosen, redraw } = this._page();
    if (!isLive(chosen.vehicle)) return;
    chosen.intents.order(order, event.timeStamp);
    redraw();
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    for (const order of /** @type {Order[]} */ (['stop', 'surface'])) {
      const { button, what, whom, became } = this._shown[order];
      button.toggleAttribute('disabled', !isLive(vehicle));
      say(what, word(order));
      say(whom, isLive(vehicle) ? vehicle.setup.name : word('review'));
      say(became, this._became(page, order, now));
    }
  }

  /** The result of the newest such order, of this page or another. @param {Page} page
   * @param {Order} order @param {number} now */
  _became(page, order, now) {
    const { vehicle, intents } = page.chosen;
    const own = intents.last(order);
    const told = /** @type {any[]} */ (vehicle.state['orders'] ?? []).findLast((o) => o.order === order);
    const since = own ? (now - own.since) / 1000 : Infinity;
    const their = told ? told.age + (now - (vehicle.heardAt ?? now)) / 1000 : Infinity;
    const newest = own && since <= their ? { is: own.is, says: own.says, age: since }
      : told ? { is: told.is, says: told.says, age: their } : null;
    if (newest === null || newest.age > SHOWN_S) return word(`${order}_says`);
    return `${word(newest.is)} ${ago(newest.age)}`;
  }
}

/** @param {HTMLElement} button */
function face(button) {
  const parts = {
    what: el('span', { class: 'what' }),
    whom: el('span', { class: 'whom' }),
    became: el('span', { class: 'became', role: 'status' }),
  };
  const key = button.id === 'stop' ? 'X' : 'W';
  button.replaceChildren(parts.what, el('kbd', {}, key), parts.whom, parts.became);
  button.setAttribute('aria-keyshortcuts', key);
  return { button, ...parts };
}
