// @ts-check
/**
 * A ghost flight: the server flies the plan in a chosen sea; a slider moves through its time.
 */

import { el, mark, say } from './dom.js';
import { asked } from './flight.js';
import { clock, length } from './format.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const OUTCOMES = { completed: 'good', emergency: 'bad', failed: 'bad' };

export class GhostBox {
  /** @param {() => Page} page @param {() => {text: string, source: string}} plan
   * @param {(ghost: any) => void} flown null: none @param {(t: number) => void} scrubbed */
  constructor(page, plan, flown, scrubbed) {
    this._page = page;
    this._plan = plan;
    this._flown = flown;
    this._scrubbed = scrubbed;
    this._title = el('h2');
    this._sea = el('input', { type: 'text', value: 'current=0.2@45', spellcheck: 'false', class: 'sea' });
    this._seed = el('input', { type: 'number', min: '0', max: '999999', value: '0', class: 'seed' });
    this._seaName = el('span');
    this._seedName = el('span');
    this._fly = el('button', { type: 'button', onclick: () => this._press() });
    this._says = el('p', { class: 'ghost-says', role: 'status' });
    this._time = el('input', { type: 'range', min: '0', max: '1', step: '1', value: '0' });
    this._time.addEventListener('input', () => this._scrub());
    this.root = el('section', { class: 'ghost' }, this._title,
      el('div', { class: 'ghost-asks' }, el('label', {}, this._seaName, this._sea),
        el('label', {}, this._seedName, this._seed), this._fly), this._time, this._says);
    /** @type {import('./wire.js').Line | null} */
    this._line = null;
    /** @type {any} */
    this._done = null;
    this._problem = '';
    this._sea.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') this._press();
    });
  }

  show() {
    say(this._title, word('ghost'));
    say(this._seaName, word('ghost_sea'));
    say(this._seedName, word('ghost_seed'));
    say(this._fly, word(this._line ? 'ghost_cancel' : 'ghost_fly'));
    this._sea.title = word('ghost_sea_says');
    this._time.hidden = this._done === null;
    mark(this._time, 'aria-label', word('ghost_time'));
    say(this._says, this._line ? word('ghost_flies') : this._done ? this._told() : this._problem);
    const level = this._done ? OUTCOMES[/** @type {'failed'} */ (this._done.outcome)] : this._problem ? 'bad' : null;
    mark(this._says, 'data-level', this._line ? null : level);
  }

  /** The text has changed: the flight was of another one. */
  forget() {
    if (!this._done && !this._problem) return;
    [this._done, this._problem] = [null, ''];
    this._flown(null);
  }

  _press() {
    if (this._line) return this._end('');
    const seed = Math.trunc(this._seed.valueAsNumber) || 0;
    const job = { do: 'fly', ...this._plan(), seed, settings: this._sea.value.split(/\s+/).filter(Boolean) };
    this.forget();
    this._line = asked(this._page().token, job,
      { heard: (answer) => this._heard(answer), refused: (why) => this._end(why) });
    this._page().redraw();
  }

  /** @param {any} answer */
  _heard(answer) {
    if (answer.is === 'refused') this._end(answer.says);
    if (answer.is !== 'done') return;
    this._done = answer;
    const end = answer.track.at(-1)?.[0] ?? 0;
    this._time.max = String(Math.ceil(end));
    this._time.value = this._time.max;
    this._end('');
    this._flown(answer);
    this._scrub();
  }

  /** @param {string} why */
  _end(why) {
    this._line?.close();
    this._line = null;
    this._problem = why;
    this._page().redraw();
  }

  _scrub() {
    this._scrubbed(this._time.valueAsNumber);
    this._page().redraw();
  }

  _told() {
    const d = this._done;
    const error = d.error.end === null ? '' : word('ghost_error', length(d.error.end));
    const where = d.track.length ? word('ghost_up', d.up.length) : word('ghost_nowhere');
    const t = clock(this._time.valueAsNumber);
    return [word(`ghost_${d.outcome}`), d.outcome === 'completed' ? '' : d.reason, clock(d.seconds), where, error,
      `${word('ghost_seed')} ${d.seed}`, d.settings.join(' ') || word('ghost_calm'),
      d.track.length ? word('ghost_at', t) : ''].filter(Boolean).join(' · ');
  }
}
