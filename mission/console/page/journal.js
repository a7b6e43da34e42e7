// @ts-check
/**
 * What happened, a line each, the newest below; whoever reads further up is not pulled down.
 */

import { el, say } from './dom.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const ROWS = 400; // on the screen; search looks through all
const NEAR_PX = 40;

/** @param {string} line @returns {'danger' | 'warning' | null} */
export function levelOf(line) {
  if (/\b(ALARM|fault|emergency)\b/.test(line)) return 'danger';
  return /\b(warning|refused|NOT SENT)\b/.test(line) ? 'warning' : null;
}

export class Journal {
  /** @param {HTMLElement} root @param {() => void} redraw */
  constructor(root, redraw) {
    this._title = el('h2');
    this._search = el('input', { type: 'search', oninput: redraw });
    this._list = el('ol', { tabindex: '0' });
    this._shown = '';
    root.replaceChildren(el('div', { class: 'head' }, this._title, this._search), this._list);
  }

  /** @param {Page} page */
  show(page) {
    const { vehicle } = page.chosen;
    say(this._title, word('journal'));
    this._search.placeholder = word('search');
    this._search.setAttribute('aria-label', word('search'));
    this._list.setAttribute('aria-label', word('journal'));
    const wanted = this._search.value.toLowerCase();
    const last = vehicle.events.at(-1);
    const shown = [vehicle.setup.id, vehicle.told, vehicle.gap, last, wanted, word('search')].join('\n');
    if (shown === this._shown) return;
    this._shown = shown;
    const lines = vehicle.events.filter((line) => line.toLowerCase().includes(wanted)).slice(-ROWS);
    const atEnd = this._list.scrollHeight - this._list.scrollTop - this._list.clientHeight < NEAR_PX;
    this._list.replaceChildren(...this._rows(lines, vehicle.gap));
    if (atEnd) this._list.scrollTop = this._list.scrollHeight;
  }

  /** @param {string[]} lines @param {number} gap */
  _rows(lines, gap) {
    const rows = lines.map((line) => {
      const level = levelOf(line);
      return el('li', level ? { 'data-level': level } : {}, line);
    });
    if (gap) rows.unshift(el('li', { class: 'empty' }, word('missing', gap)));
    return rows.length ? rows : [el('li', { class: 'empty' }, word('nothing'))];
  }
}
