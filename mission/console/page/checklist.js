// @ts-check
/**
 * Before a dive: what can be checked from here, and the vehicle's own list of points that a person
 * checks. The console's log records each point that is done, with its time.
 */

import { el, mark, say } from './dom.js';
import { findings } from './seen.js';
import { isLive } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const SIGNS = { good: '✓', careful: '!', bad: '✗', unknown: '?' }; // never colour alone

export class Checklist {
  /** @param {HTMLElement} root @param {() => Page} page */
  constructor(root, page) {
    this._page = page;
    this._title = el('h2');
    this._list = el('ul');
    this._shown = '';
    this._seenTitle = el('h2');
    this._seen = el('dl', { class: 'seen' });
    /** @type {Map<number, [HTMLElement, HTMLElement, HTMLElement]>} */
    this._rows = new Map();
    root.replaceChildren(this._seenTitle, this._seen, this._title, this._list);
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    say(this._seenTitle, word('seen_here'));
    const found = findings(vehicle, page.stale, now);
    found.forEach((one, i) => this._find(one, i));
    for (const [i, [row]] of this._rows) row.hidden = i >= found.length;
    const points = vehicle.setup.checklist;
    const checked = vehicle.state['checked'] ?? {};
    say(this._title, `${word('checklist')} ${points.filter((p) => p in checked).length} / ${points.length}`);
    const shown = JSON.stringify([vehicle.setup.id, checked, word('checklist')]);
    if (shown === this._shown) return;
    this._shown = shown;
    const rows = points.map((point) => this._row(point, checked[point], isLive(vehicle)));
    this._list.replaceChildren(...(rows.length ? rows : [el('li', { class: 'empty' }, word('no_points'))]));
  }

  /** @param {import('./seen.js').Finding} finding @param {number} i */
  _find({ name, level, says }, i) {
    const [row, dt, dd] = this._rows.get(i) ?? [el('div'), el('dt'), el('dd')];
    if (!this._rows.has(i)) {
      row.append(dt, dd);
      this._seen.append(row);
      this._rows.set(i, [row, dt, dd]);
    }
    mark(row, 'data-level', level);
    say(dt, name);
    say(dd, `${SIGNS[level]} ${says}`);
  }

  /** @param {string} point @param {number | undefined} at s since 1970 UTC
   * @param {boolean} live */
  _row(point, at, live) {
    const box = el('input', { type: 'checkbox', checked: at !== undefined, disabled: !live });
    box.addEventListener('change', (event) => {
      const { intents } = this._page().chosen;
      intents.command('check', point, { point, done: box.checked }, event.timeStamp);
    });
    const when = at === undefined ? '' : new Date(at * 1000).toISOString().slice(11, 19);
    return el('li', {}, el('label', { class: 'point' }, box, el('span', {}, point),
      el('span', { class: 'note' }, when && `${when} UTC`)));
  }
}
