// @ts-check
/**
 * The margin to each limit: the remaining part as a bar, the limit, its trend, its age.
 */

import { el, mark, say } from './dom.js';
import { lasting, number } from './format.js';
import { freshness, runsOut } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

/** Name, unit, digits, and the share of the limit that fills the bar.
 * @type {ReadonlyArray<readonly [string, string, number, number]>} */
const ROWS = [['to_depth', 'm', 1, 1], ['to_radius', 'm', 0, 1], ['to_time', 'min', 1, 1],
  ['to_voltage', 'V', 1, 0.2]];
const LOW = 0.25;
const LOWER = 0.1;
const SOON_S = 3600; // beyond that a trend means nothing

/** @param {number | null} left @param {number | null} limit @param {number} whole */
export function level(left, limit, whole) {
  if (left === null) return { share: 0, level: 'unknown' };
  if (limit === null || limit === 0) return { share: left > 0 ? 1 : 0, level: left > 0 ? 'good' : 'bad' };
  const share = Math.min(1, Math.max(0, left / (limit * whole)));
  return { share, level: share <= LOWER ? 'bad' : share <= LOW ? 'careful' : 'good' };
}

/** Why a margin is not known. @param {string} name @param {Record<string, any>} state */
export function unknown(name, state) {
  const isIdle = state['state'] !== undefined && !state['mission_began'];
  return word(name === 'to_time' && isIdle ? 'not_started' : 'unknown');
}

export class Margins {
  /** @param {HTMLElement} root */
  constructor(root) {
    this._title = el('h2');
    this._rows = ROWS.map(() => row());
    root.replaceChildren(this._title, ...this._rows.map((r) => r.root));
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    say(this._title, word('margins'));
    ROWS.forEach((spec, i) => this._show(page, now, spec, i));
  }

  /** @param {Page} page @param {number} now @param {typeof ROWS[number]} spec
   * @param {number} i */
  _show(page, now, [name, unit, digits, whole], i) {
    const shown = this._rows[i];
    if (shown === undefined) return;
    const { vehicle } = page.chosen;
    const [left, limit] = vehicle.state[name] ?? [null, null];
    const { share, level: is } = level(left, limit, whole);
    mark(shown.root, 'data-level', is);
    mark(shown.root, 'data-is', freshness(vehicle, left, 'report_at', page.stale.report, now));
    mark(shown.meter, 'data-level', is);
    shown.fill.style.width = `${(share * 100).toFixed(1)}%`;
    say(shown.name, word(name));
    const far = left === null ? '' : `${number(Math.abs(left), digits)} ${unit}`;
    say(shown.left, left === null ? unknown(name, vehicle.state) : left < 0 ? word('beyond', far) : far);
    const seconds = name === 'to_time' ? null : runsOut(vehicle.strips[name] ?? []);
    const isFloor = name === 'to_voltage'; // the limit is below the value
    const soon = seconds !== null && seconds < SOON_S;
    say(shown.note, soon ? word('reaches', lasting(seconds))
      : limit === null || (left ?? 0) < 0 ? ''
        : word(isFloor ? 'above' : 'of', `${number(limit, digits).replace(/\.0$/, '')} ${unit}`));
  }
}

function row() {
  const parts = {
    name: el('span', { class: 'name' }),
    left: el('span', { class: 'left' }),
    note: el('span', { class: 'note' }),
    fill: el('div'),
  };
  const meter = el('div', { class: 'meter', 'aria-hidden': 'true' }, parts.fill);
  return { root: el('div', { class: 'margin' }, parts.name, meter, parts.left, parts.note), meter, ...parts };
}
