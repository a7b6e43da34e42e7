// @ts-check
/**
 * The vehicle's own list of points that a person looks at before a dive; what is done is kept in
 * the console's log with its time.
 */

import { el, say } from './dom.js';
import { isLive } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

export class Checklist {
  /** @param {HTMLElement} root @param {() => Page} page */
  constructor(root, page) {
    this._page = page;
    this._title = el('h2');
    this._list = el('ul');
    this._shown = '';
    root.replaceChildren(this._title, this._list);
  }

  /** @param {Page} page */
  show(page) {
    const { vehicle } = page.chosen;
    const points = vehicle.setup.checklist;
    const checked = vehicle.state['checked'] ?? {};
    say(this._title, `${word('checklist')} ${points.filter((p) => p in checked).length} / ${points.length}`);
    const shown = JSON.stringify([vehicle.setup.id, checked, word('checklist')]);
    if (shown === this._shown) return;
    this._shown = shown;
    const rows = points.map((point) => this._row(point, checked[point], isLive(vehicle)));
    this._list.replaceChildren(...(rows.length ? rows : [el('li', { class: 'empty' }, word('no_points'))]));
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
