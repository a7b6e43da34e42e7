// @ts-check
/**
 * The events, one line each, the newest at the bottom; it does not scroll while the user reads above.
 */

import { el, say } from './dom.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const ROWS = 400; // on the screen; the search covers all
const NEAR_PX = 40;
const STAMP = /^(\d{4}-\d\d-\d\d)T(?=\d\d:\d\d:\d\d)/;

/** @param {string} line @returns {'danger' | 'warning' | null} */
export function levelOf(line) {
  if (/\b(?:ALARM|fault|now emergency)\b/.test(line)) return 'danger'; // not a planned ascent
  return /\b(warning|refused|NOT SENT)\b/.test(line) ? 'warning' : null;
}

/** Each line, with its day if that differs from the line before. @param {readonly string[]} lines */
export function byDay(lines) {
  let day = '';
  return lines.map((line) => {
    const own = STAMP.exec(line)?.[1] ?? '';
    const told = own && own === day ? line.slice(own.length + 1) : line.replace(STAMP, '$1 ');
    day = own || day;
    return told;
  });
}

export class Journal {
  /** @param {HTMLElement} root @param {() => void} redraw */
  constructor(root, redraw) {
    this._title = el('h2');
    this._search = el('input', { type: 'search', oninput: redraw });
    this._list = el('ol', { tabindex: '0' });
    this._shown = '';
    this._isAtEnd = true; // then it stays at the end, whatever its size becomes
    this._list.addEventListener('scroll', () => this._look());
    this._size = ''; // px, size at the last scroll to the end
    new ResizeObserver(() => this._follow()).observe(this._list);
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
    this._list.replaceChildren(...this._rows(lines, vehicle.gap));
    this._follow();
  }

  /** Ignore the scrolling that a change of size causes. */
  _look() {
    const { scrollHeight, scrollTop, clientHeight } = this._list;
    if (this._size === sizeOf(this._list)) this._isAtEnd = scrollHeight - scrollTop - clientHeight < NEAR_PX;
  }

  _follow() {
    this._size = sizeOf(this._list);
    if (this._isAtEnd) this._list.scrollTop = this._list.scrollHeight;
  }

  /** @param {string[]} lines @param {number} gap */
  _rows(lines, gap) {
    const told = byDay(lines);
    const rows = lines.map((line, i) => {
      const level = levelOf(line);
      return el('li', level ? { 'data-level': level } : {}, told[i] ?? line);
    });
    if (gap) rows.unshift(el('li', { class: 'empty' }, word('missing', gap)));
    return rows.length ? rows : [el('li', { class: 'empty' }, word('nothing'))];
  }
}

/** @param {Element} at */
function sizeOf({ clientWidth, clientHeight }) {
  return `${clientWidth} ${clientHeight}`;
}
