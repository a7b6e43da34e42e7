// @ts-check
/**
 * The vehicle's state and its reason, the leg's timeout, and how near each guard is to its bound.
 */

import { el, mark, say } from './dom.js';
import { clock, number } from './format.js';
import { between, Frame } from './geo.js';
import { routesOf } from './scene.js';
import { age, isOld } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {[string, Record<string, number | null>]} Guard its text, and its present values
 * @typedef {{text: string, share: number | null}} Progress */

const FROM_ZERO = ['elapsed', 'travelled']; // counted from the begin of the leg
const NEXT_M = 5; // a distance that grows by more is to the next corner
const COMPARISON = /([a-z_]+)\s*(>=|<=|>|<)\s*(-?\d+(?:\.\d+)?)/g;

/**
 * The progress of each comparison of a guard since ``began`` (values at the begin of the leg); null
 * if not known.
 * @param {Guard} guard @param {Record<string, number>} began @returns {Progress[]}
 */
export function progress([text, values], began) {
  return [...text.matchAll(COMPARISON)].filter((m) => m[1] !== undefined && m[1] in values)
    .map(([, name = '', way = '', bound]) => {
      const [value, from, to] = [values[name] ?? null, began[name], Number(bound)];
      const holds = value !== null && (way.startsWith('>') ? value >= to : value <= to);
      const open = value === null || from === undefined || from === to;
      const share = holds ? 1 : open ? null : Math.min(1, Math.max(0, (value - from) / (to - from)));
      return { text: `${name} ${number(value, 1)}`, share };
    });
}

/** The distance to the leg's goal when the leg began; undefined: not known.
 * @param {import('./state.js').Vehicle} vehicle */
export function farAtBegin({ plan, state, track }) {
  const [began, leg] = [state['leg_began'], state['leg']];
  const first = track.find(([t]) => t >= began);
  if (!plan?.home || !plan.map || first === undefined) return undefined;
  const frame = new Frame(...plan.home);
  const goal = routesOf(plan.map, frame).find((route) => route.name === leg)?.points.at(-1);
  return goal && between(frame.toLocal(first[1], first[2]), goal).range;
}

/** The guards' values at the begin of the leg: from the strips, else as first seen; of a distance
 * the greatest on the way to a corner. */
export class Begun {
  /** @type {Record<string, number>} */
  _seen = {};
  _last = Infinity; // distance, m
  _leg = '';

  /** @param {import('./state.js').Vehicle} vehicle @returns {Record<string, number>} */
  of(vehicle) {
    const { setup, state, snapshots } = vehicle;
    const leg = `${setup.id} ${snapshots} ${state['leg']} ${state['leg_began']}`;
    if (leg !== this._leg) [this._leg, this._seen, this._last] = [leg, {}, Infinity];
    /** @type {Guard[]} */
    const guards = state['leg_ends'] ?? [];
    for (const [text, values] of guards) {
      for (const [name, value] of Object.entries(values)) {
        if (value !== null) this._take(vehicle, text, name, value);
      }
    }
    return this._seen;
  }

  /** @param {import('./state.js').Vehicle} vehicle @param {string} text
   * @param {string} name @param {number} value */
  _take(vehicle, text, name, value) {
    if (name === 'distance') {
      const far = text.startsWith('distance') ? farAtBegin(vehicle) : undefined;
      const isNext = value > this._last + NEXT_M;
      this._seen[name] = Math.max(far ?? 0, value, isNext ? 0 : this._seen[name] ?? 0);
      this._last = value;
      return;
    }
    const began = vehicle.strips[name]?.find(([t, v]) => t >= vehicle.state['leg_began'] && v !== null);
    this._seen[name] = FROM_ZERO.includes(name) ? 0 : began?.[1] ?? this._seen[name] ?? value;
  }
}

export class States {
  /** @param {HTMLElement} root */
  constructor(root) {
    this._root = root;
    this._rows = el('dl', { class: 'rows' });
    this._guards = el('div');
    root.replaceChildren(this._rows, this._guards);
    this._begun = new Begun();
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    const state = vehicle.state;
    mark(this._root, 'data-old', isOld(vehicle, now) ? '' : null);
    /** @type {Array<[string, string]>} */
    const rows = [];
    for (const name of ['reason', 'setpoint']) if (state[name]) rows.push([word(name), state[name]]);
    if (state['up_by']) rows.push([word('up_by'), new Date(state['up_by'] * 1000).toLocaleTimeString()]);
    if (vehicle.setup.source === 'frames') rows.push([word('link'), word('thin')]);
    showRows(this._rows, rows);
    /** @type {Guard[]} */
    const guards = state['leg_ends'] ?? [];
    const began = this._begun.of(vehicle);
    const bars = [...this._timeout(page, now), ...guards.flatMap((g) => barsOf(g, began))];
    showGuards(this._guards, bars);
  }

  /** @param {Page} page @param {number} now @returns {Bar[]} */
  _timeout(page, now) {
    const { vehicle } = page.chosen;
    const lasts = age(vehicle, 'leg_began', now);
    const most = vehicle.state['leg_timeout'];
    if (!vehicle.state['leg'] || lasts === null) return [];
    const text = typeof most === 'number' ? `${clock(lasts)} / ${clock(most)}` : clock(lasts);
    const share = typeof most === 'number' ? Math.min(1, lasts / most) : null;
    return [{ name: word('timeout'), text, share, level: (share ?? 0) > 0.85 ? 'careful' : 'plain' }];
  }
}

/** @param {Guard} guard @param {Record<string, number>} began @returns {Bar[]} */
function barsOf(guard, began) {
  const parts = progress(guard, began);
  const name = `${word('until')} ${guard[0]}`;
  if (parts.length === 0) return [{ name, text: '', share: null, level: 'good' }];
  return parts.map((p, i) => ({ name: i ? '' : name, text: p.text, share: p.share, level: 'good' }));
}

/** @typedef {{name: string, text: string, share: number | null, level: string}} Bar */

/** @param {Element} root @param {Array<[string, string]>} rows */
export function showRows(root, rows) {
  while (root.childElementCount > rows.length * 2) root.lastElementChild?.remove();
  while (root.childElementCount < rows.length * 2) root.append(el('dt'), el('dd'));
  rows.flat().forEach((text, i) => {
    const at = root.children[i];
    if (at) say(at, text);
  });
}

/** @param {Element} root @param {Bar[]} bars */
function showGuards(root, bars) {
  while (root.childElementCount > bars.length) root.lastElementChild?.remove();
  while (root.childElementCount < bars.length) root.append(guardRow());
  bars.forEach((bar, i) => {
    const [text, meter] = root.children[i]?.children ?? [];
    const [name, now] = text?.children ?? [];
    if (name) say(name, bar.name);
    if (now) say(now, bar.text);
    if (!(meter instanceof HTMLElement)) return;
    meter.hidden = bar.share === null;
    mark(meter, 'data-level', bar.level);
    const fill = meter.firstElementChild;
    if (fill instanceof HTMLElement) fill.style.width = `${((bar.share ?? 0) * 100).toFixed(1)}%`;
  });
}

function guardRow() {
  return el('div', { class: 'guard' }, el('div', { class: 'text' }, el('span'), el('span')),
    el('div', { class: 'meter', 'aria-hidden': 'true' }, el('div')));
}
