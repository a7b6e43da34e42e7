// @ts-check
/**
 * The check's findings on a plan: what is proved, what is wrong and where, what is assumed.
 */

import { el, mark, say } from './dom.js';
import { lasting } from './format.js';
import { proof } from './mission.js';
import { word } from './words.js';

/** @typedef {import('./editor.js').Fault} Fault */

const SHOWN = 30;
const SOON_S = 0.5; // grey at once; a text if it takes longer

export class Findings {
  /** @param {(fault: Fault) => void} reveal */
  constructor(reveal) {
    this._reveal = reveal;
    this._verdict = el('p', { class: 'verdict', role: 'status' });
    this._list = el('ul', { class: 'found' });
    this._more = el('details', {}, el('summary'), el('ul', { class: 'path' }));
    this._title = el('h2');
    this.root = el('section', { class: 'findings' }, this._title, this._verdict, this._list, this._more);
    /** @type {any} */
    this._said = null;
    this._shown = '';
    this._verdictSays = '';
    this._oldSince = 0; // ms; 0: the findings are of the present text
  }

  /** @param {any} said the check's answer; null: none for this text */
  take(said) {
    this._said = said;
    this._shown = '';
    if (said === null) for (const one of [this._list, this._more.children[1]]) one?.replaceChildren();
  }

  /** @param {boolean} isNewest the findings are of the present text
   * @param {number} now ms */
  show(isNewest, now) {
    this._take();
    this._oldSince = isNewest ? 0 : this._oldSince || now;
    const isOld = !isNewest && this._said !== null;
    const age = isOld ? (now - this._oldSince) / 1000 : 0;
    mark(this.root, 'data-old', isOld ? '' : null);
    mark(this._verdict, 'aria-busy', isNewest ? null : 'true');
    mark(this._verdict, 'data-level', isOld || !this._said ? null : this._said.ok ? 'good' : 'bad');
    say(this._verdict, age > SOON_S ? word('plan_old', lasting(age), this._verdictSays) : this._verdictSays);
  }

  /** Write the findings again, in the present language. */
  _take() {
    const said = this._said;
    say(this._title, word('plan_proof'));
    if (said === null) {
      this._verdictSays = '';
      this._more.hidden = true;
    }
    const key = `${word('plan_proof')}${said?.digest}${said?.ok}${JSON.stringify(said?.refusals ?? '')}`;
    if (said === null || key === this._shown) return;
    this._shown = key;
    const count = said.refusals.length;
    this._verdictSays = said.ok ? proof(said.proved)
      : said.problem && !count ? said.problem : word('plan_refused', count);
    this._list.replaceChildren(...said.refusals.slice(0, SHOWN).map((/** @type {Fault} */ one) => this._row(one)));
    const [summary, rows] = this._more.children;
    const path = [...(said.proved?.worst_path ?? []), ...said.expected.map(expected), ...said.assumed];
    this._more.hidden = path.length === 0;
    if (summary) say(summary, word('plan_path'));
    rows?.replaceChildren(...path.map((line) => el('li', {}, line)));
  }

  /** @param {Fault} fault */
  _row(fault) {
    const says = fault.hint ? `${fault.message} — ${fault.hint}` : fault.message;
    if (!fault.line) return el('li', {}, says);
    return el('li', {}, el('button', { type: 'button', onclick: () => this._reveal(fault) },
      el('b', {}, `${fault.line}:${fault.column}`), ` ${says}`));
  }
}

/** @param {any} one */
function expected(one) {
  const share = one.coverage === null ? '' : `${Math.round(one.coverage * 100)} % · `;
  return `${one.leg}: ${share}${one.error_m.map((/** @type {number} */ m) => `± ${m} m`).join(', ')}`;
}
