// @ts-check
/**
 * A dive compared with another dive, and with its own smoothed track.
 *
 * Nothing is interpolated between the known points: the position at a time is the last known
 * position.
 */

import { el, mark, say } from './dom.js';
import { clock, length } from './format.js';
import { between } from './geo.js';
import { timeOf } from './state.js';
import { word } from './words.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./geo.js').Frame} Frame
 * @typedef {import('./station.js').Page} Page
 * @typedef {import('./station.js').Station} Station
 * @typedef {[number, number, number]} Past t, latitude, longitude
 * @typedef {{begin: number | null, wall: number, then: Past[], now: Past[],
 *   apart: {mean: number, max: number} | null, problem: string}} Hindsight
 * @typedef {'start' | 'clock'} By
 * @typedef {{smoothed: boolean, other: string, by: By}} Compared other: id; '': none
 * @typedef {{name: string, line: Pair[], at: Pair | null}} Beside */

/** @type {Compared} */
export const ALONE = { smoothed: false, other: '', by: 'start' };

/** The other dive's time at a time of ours. @param {By} by @param {number} t
 * @param {Hindsight} own @param {Hindsight} other */
export function timeThere(by, t, own, other) {
  return by === 'clock' ? t + own.wall - other.wall : t - (own.begin ?? 0) + (other.begin ?? 0);
}

/** The last known position. @param {readonly Past[]} points @param {number} t
 * @returns {Past | null} null: before the first, and after the last */
export function lastAt(points, t) {
  const end = points.at(-1);
  if (end === undefined || t > end[0] + 1) return null;
  let [low, high] = [0, points.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((points[middle]?.[0] ?? 0) <= t) low = middle + 1;
    else high = middle;
  }
  return points[low - 1] ?? null;
}

/** What the chart draws. @param {Page} page @param {Frame | null} frame @param {number} now ms
 * @returns {{now: Beside | null, other: Beside | null}} */
export function besides(page, frame, now) {
  const { chosen, compared } = page;
  const t = timeOf(chosen.vehicle, now);
  const own = chosen.hindsight;
  const other = otherOf(page);
  if (frame === null || own === null) return { now: null, other: null };
  const there = other?.hindsight ? timeThere(compared.by, t, own, other.hindsight) : 0;
  return {
    now: compared.smoothed ? beside(word('known_now'), own.now, t, frame) : null,
    other: other?.hindsight ? beside(other.vehicle.setup.name, other.hindsight.then, there, frame) : null,
  };
}

/** @param {string} name @param {Past[]} points @param {number} t @param {Frame} frame
 * @returns {Beside} */
function beside(name, points, t, frame) {
  const local = (/** @type {Past} */ [, lat, lon]) => frame.toLocal(lat, lon);
  const last = lastAt(points, t);
  return { name, line: points.map(local), at: last ? local(last) : null };
}

/** @param {Page} page */
function otherOf({ stations, chosen, compared }) {
  const found = stations.find((one) => one.vehicle.setup.id === compared.other && one !== chosen);
  return found ?? null;
}

export class Compare {
  /** @param {() => Page} page */
  constructor(page) {
    this._page = page;
    this._smoothed = el('button', { type: 'button', onclick: () => {
      const { compared } = this._page();
      this._set({ smoothed: !compared.smoothed });
    } });
    this._other = el('select', { onchange: () => this._set({ other: this._other.value }) });
    this._by = el('select', { onchange: () => this._set({ by: /** @type {By} */ (this._by.value) }) },
      el('option', { value: 'start' }), el('option', { value: 'clock' }));
    this._says = el('span', { class: 'note' });
    this._offered = '';
    this._title = el('summary');
    this.root = el('details', { class: 'compare' }, this._title,
      el('div', {}, this._smoothed, this._other, this._by), this._says);
  }

  /** @param {Partial<Compared>} change */
  _set(change) {
    const page = this._page();
    Object.assign(page.compared, change);
    page.redraw();
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { compared, chosen, stations } = page;
    const others = stations.filter((s) => s !== chosen && s.vehicle.setup.source === 'recording');
    say(this._title, word('comparing'));
    say(this._smoothed, word('known_now'));
    mark(this._smoothed, 'aria-pressed', String(compared.smoothed));
    this._other.hidden = !others.length;
    this._by.hidden = otherOf(page) === null;
    this._offer(others);
    this._by.setAttribute('aria-label', word('aligned'));
    this._by.value = compared.by;
    [word('by_start'), word('by_clock')].forEach((text, i) => {
      const option = this._by.options[i];
      if (option) say(option, text);
    });
    for (const one of compared.smoothed || otherOf(page) ? [chosen, otherOf(page)] : []) one?.askHindsight();
    say(this._says, this._tell(page, now));
  }

  /** @param {Station[]} others */
  _offer(others) {
    this._other.setAttribute('aria-label', word('compare'));
    const names = others.map((one) => one.vehicle.setup);
    const offered = JSON.stringify([names.map((s) => s.id), word('compare')]);
    if (offered === this._offered) return;
    this._offered = offered;
    this._other.replaceChildren(el('option', { value: '' }, word('compare_none')),
      ...names.map((s) => el('option', { value: s.id }, s.name)));
    this._other.value = this._page().compared.other;
  }

  /** @param {Page} page @param {number} now ms */
  _tell(page, now) {
    const { compared, chosen } = page;
    const other = otherOf(page);
    const asked = [compared.smoothed || other ? chosen : null, other];
    if (asked.some((one) => one && one.hindsight === null)) return word('working_out');
    const [own, its] = [chosen.hindsight, other?.hindsight ?? null];
    return [
      compared.smoothed && own ? smoothedSays(own, page, now) : '',
      its && own ? otherSays(own, its, page, now) : '',
    ].filter(Boolean).join(' · ');
  }
}

/** @param {Hindsight} own @param {Page} page @param {number} now */
function smoothedSays(own, page, now) {
  if (own.problem || own.apart === null) return own.problem;
  const t = timeOf(page.chosen.vehicle, now);
  const [then, later] = [lastAt(own.then, t), lastAt(own.now, t)];
  const off = then && later ? word('was_off', length(apart(then, later))) : '';
  return [off, word('off_in_all', length(own.apart.mean), length(own.apart.max))].filter(Boolean).join(', ');
}

/** @param {Hindsight} own @param {Hindsight} its @param {Page} page @param {number} now */
function otherSays(own, its, page, now) {
  const t = timeOf(page.chosen.vehicle, now);
  const there = timeThere(page.compared.by, t, own, its);
  const [a, b] = [lastAt(own.then, t), lastAt(its.then, there)];
  if (its.problem && !its.then.length) return its.problem;
  const at = there < 0 ? `−${clock(-there)}` : clock(there);
  return a && b ? word('apart_at', length(apart(a, b)), at) : word('apart_none', at);
}

/** Distance in m; accurate for some kilometres. @param {Past} a @param {Past} b */
export function apart([, latA, lonA], [, latB, lonB]) {
  const flat = Math.cos((latA * Math.PI) / 180);
  return between([0, 0], [(lonB - lonA) * 111320 * flat, (latB - latA) * 111320]).range;
}
