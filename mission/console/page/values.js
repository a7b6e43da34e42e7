// @ts-check
/**
 * The most important values, large, each with its age beside it.
 *
 * An old value is grey, slanted and marked OLD. An unknown one is struck through, with its last known
 * value.
 */

import { el, mark, say } from './dom.js';
import { bearing, lasting, number } from './format.js';
import { MEASURED, freshness, timeOf } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const SHOWN = ['depth', 'altitude', 'heading', 'speed', 'battery'];

export class Values {
  /** @param {HTMLElement} root */
  constructor(root) {
    this._cells = new Map([...SHOWN, 'fix', 'uncertainty'].map((name) => [name, cell(name)]));
    root.replaceChildren(...[...this._cells.values()].map((c) => c.root));
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    for (const name of SHOWN) {
      const [unit, digits] = MEASURED[name] ?? ['', 0];
      const value = vehicle.state[name];
      const is = freshness(vehicle, value, 'report_at', page.stale.report, now);
      const [t, was] = vehicle.known[name] ?? [null, null];
      const text = name === 'heading' ? bearing : (/** @type {any} */ v) => number(v, digits);
      const at = is === 'unknown' ? t : vehicle.state['report_at'];
      const age = at === null || at === undefined ? null : timeOf(vehicle, now) - at;
      this._put(name, is, text(is === 'unknown' ? was : value), name === 'heading' ? '' : unit, age);
    }
    this._fix(page, now);
  }

  /** @param {Page} page @param {number} now */
  _fix(page, now) {
    const { vehicle } = page.chosen;
    const at = vehicle.state['fix_at'];
    const is = freshness(vehicle, at, 'fix_at', page.stale.fix, now);
    const age = typeof at === 'number' ? timeOf(vehicle, now) - at : null;
    this._put('fix', is, age === null ? '—' : lasting(age), '', null);
    const around = vehicle.state['ellipse']?.[0] ?? null;
    const known = freshness(vehicle, around, 'report_at', page.stale.report, now);
    const since = typeof vehicle.state['report_at'] === 'number'
      ? timeOf(vehicle, now) - vehicle.state['report_at'] : null;
    this._put('uncertainty', known, number(around, 0), 'm', around === null ? null : since);
  }

  /** @param {string} name @param {import('./state.js').Freshness} is @param {string} text
   * @param {string} unit @param {number | null} age s */
  _put(name, is, text, unit, age) {
    const shown = this._cells.get(name);
    if (shown === undefined) return;
    mark(shown.root, 'data-is', is);
    shown.number.classList.toggle('was', is === 'unknown' && text !== '—');
    say(shown.name, word(name));
    say(shown.number, text);
    say(shown.unit, text === '—' ? '' : unit);
    const old = age === null ? '' : lasting(age);
    const says = { fresh: old, old: `${word('old')} ${old}`, unknown: `${word('unknown')} ${old}` };
    say(shown.age, says[is]);
  }
}

/** @param {string} name */
function cell(name) {
  const parts = {
    name: el('span', { class: 'name' }),
    age: el('span', { class: 'age' }),
    number: el('span', { class: 'number' }),
    unit: el('span', { class: 'unit' }),
  };
  const root = el('div', { class: 'value', 'data-name': name },
    el('div', { class: 'top' }, parts.name, parts.age), parts.number, parts.unit);
  return { root, ...parts };
}
