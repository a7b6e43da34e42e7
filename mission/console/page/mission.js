// @ts-check
/**
 * The mission to upload: chosen from a file or from the shipped ones, and checked at once. The
 * check's proof is shown.
 */

import { el, say } from './dom.js';
import { lasting, length, number } from './format.js';
import { ask } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page */

const MOST = 1 << 20; // characters: a mission is never longer

export class Mission {
  /** @type {{text: string, source: string} | null} passed by the check */
  chosen = null;
  digest = '';
  title = '';
  _wanted = 0; // counts choices: an earlier answer is of another mission

  /** @param {() => Page} page @param {HTMLElement} upload its button */
  constructor(page, upload) {
    this._page = page;
    this._file = el('input', { type: 'file', accept: '.yaml,.yml,.mission', class: 'unseen' });
    this._label = el('span');
    this._shipped = el('select', { class: 'wide' });
    this._says = el('p', { class: 'note', role: 'status' });
    this._name = el('legend');
    this.root = el('fieldset', {}, this._name, el('div', { class: 'grid2' }, this._shipped,
      el('label', { class: 'file' }, this._label, this._file), upload),
      this._says);
    this._file.addEventListener('change', () => this._take());
    this._shipped.addEventListener('change', () => this._choose());
    /** @type {Array<{name: string, text: string}>} */
    this._missions = [];
    void this._load();
  }

  show() {
    say(this._name, word('choose'));
    say(this._label, word('choose_file'));
    this._shipped.setAttribute('aria-label', word('choose'));
    const first = this._shipped.options[0];
    if (first) say(first, word('choose_shipped'));
  }

  async _load() {
    this._missions = await ask('/api/missions', this._page().token).catch(() => []);
    this._shipped.replaceChildren(el('option', { value: '' }),
      ...this._missions.map((m) => el('option', { value: m.name }, m.name)));
  }

  _choose() {
    const found = this._missions.find((m) => m.name === this._shipped.value);
    this._file.value = '';
    void this._check(found ? { text: found.text, source: `${found.name}.yaml` } : null);
  }

  async _take() {
    const file = this._file.files?.[0];
    if (file === undefined) return;
    this._shipped.value = '';
    await this._check(null);
    if (file.size > MOST) return this._refuse(word('too_large', file.name));
    const wanted = this._wanted;
    const text = await file.text();
    if (wanted === this._wanted) await this._check({ text, source: file.name });
  }

  /** @param {{text: string, source: string} | null} mission */
  async _check(mission) {
    this._refuse('');
    const wanted = this._wanted += 1;
    if (mission === null) return;
    const token = this._page().token;
    const said = await ask('/api/check', token, mission).catch((error) => ({ ok: false, refusals: [],
      problem: String(error instanceof Error ? error.message : error) }));
    if (wanted !== this._wanted) return;
    if (said.ok) this._accept(mission, said);
    else this._refuse(said.refusals.map(refusal).join('\n') || said.problem);
    this._page().redraw();
  }

  /** @param {{text: string, source: string}} mission @param {any} said */
  _accept(mission, said) {
    this.chosen = mission;
    this.digest = said.digest;
    this.title = `${said.name} ${said.digest.slice(0, 8)}`;
    say(this._says, proof(said.proved));
  }

  /** @param {string} why */
  _refuse(why) {
    [this.chosen, this.digest, this.title] = [null, '', ''];
    say(this._says, why);
  }
}

/** @param {{line: number | null, message: string, hint: string | null}} found */
function refusal({ line, message, hint }) {
  return `${line ? `${line}: ` : ''}${message}${hint ? ` (${hint})` : ''}`;
}

/** @param {any} proved */
export function proof(proved) {
  if (!proved) return '';
  const { worst_time_s: t, worst_energy_wh: e, max_range_m: r, max_depth_m: d, uncertainty_m: u } = proved;
  const parts = [word('proof_time', lasting(t ?? 0)), `${number(e, 0)} Wh`, word('proof_range', length(r ?? 0)),
    word('proof_depth', length(d ?? 0)), `± ${length(u ?? 0)}`];
  return parts.map((one) => one.replaceAll(' ', '\u00a0')).join(' · '); // keeps units with numbers
}
