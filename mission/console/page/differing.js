// @ts-check
/**
 * The mission on the vehicle compared with the text here: their digests, and what would change.
 */

import { el, mark, say } from './dom.js';
import { want } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const PLAIN = new Set(['leg', 'heading', 'speed', 'vertical', 'attitude', 'does', 'place']);
const AROUND = 2; // equal lines shown around different ones

export class Differing {
  /** @param {() => Page} page @param {() => {text: string, source: string}} plan */
  constructor(page, plan) {
    this._page = page;
    this._plan = plan;
    this._title = el('h2');
    this._digests = el('p', { class: 'digests' });
    this._ask = el('button', { type: 'button', onclick: () => void this._compare() });
    this._changes = el('ul', { class: 'changes' });
    this._rows = el('pre', { class: 'rows-changed', tabindex: '0' });
    this.root = el('section', { class: 'differing' }, this._title, this._digests, this._ask,
      this._changes, this._rows);
    this._wanted = 0;
    this._rows.hidden = true;
  }

  /** @param {any} said the check's answer; null: none for this text so far */
  show(said) {
    const { state, setup, plan } = this._page().chosen.vehicle;
    const board = state['mission'] || '';
    const here = said?.digest?.slice(0, 16) ?? '';
    say(this._title, word('on_board'));
    const name = plan?.digest === board ? plan?.name ?? '' : '';
    const one = board ? `${setup.name}: ${name} ${board.slice(0, 8)}` : word('no_mission');
    const verdict = board && here ? word(board === here ? 'same' : 'different') : '';
    say(this._digests, [one, here ? `${word('plan_here')} ${here.slice(0, 8)}` : '', verdict].filter(Boolean).join(' · '));
    mark(this._digests, 'data-level', !board || !here ? null : board === here ? 'good' : 'careful');
    say(this._ask, word('plan_compare'));
    this._ask.disabled = !board || !here;
  }

  /** The text has changed. */
  forget() {
    this._wanted += 1;
    this._changes.replaceChildren();
    this._rows.hidden = true;
  }

  async _compare() {
    this.forget();
    const wanted = this._wanted;
    const { chosen, token } = this._page();
    const id = encodeURIComponent(chosen.vehicle.setup.id);
    try {
      const found = await want(`/api/vehicles/${id}/diff`, token, this._plan());
      if (wanted === this._wanted) this._tell(found);
    } catch (error) {
      if (wanted === this._wanted) this._say([error instanceof Error ? error.message : String(error)]);
    }
  }

  /** @param {any} found */
  _tell(found) {
    if (found.same) return this._say([word('plan_same')]);
    this._say(found.changes.map(change));
    this._rows.replaceChildren(...near(found.rows).map(([sign, line]) =>
      el('span', { 'data-sign': sign }, `${sign} ${line}\n`)));
    this._rows.hidden = false;
  }

  /** @param {string[]} lines */
  _say(lines) {
    this._changes.replaceChildren(...lines.map((line) => el('li', {}, line)));
  }
}

/** @param {any} one */
function change(one) {
  const [before, after] = [one.before, one.after];
  const what = PLAIN.has(one.what) ? '' : `${one.what} `; // the other names say it themselves
  return `${one.places.join(', ')}: ${what}${before && after ? `${before} → ${after}` : before || after}`;
}

/** The lines that differ, and some around them. @param {Array<[string, string]>} rows
 * @returns {Array<[string, string]>} */
export function near(rows) {
  const marked = rows.map(([sign]) => sign !== ' ');
  return rows.filter((_, i) => marked.slice(Math.max(0, i - AROUND), i + AROUND + 1).some(Boolean));
}
