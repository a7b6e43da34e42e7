// @ts-check
/**
 * A file that is opened or dropped: a mission is taken as it is. A plan of another program is
 * converted by the server, which asks for missing data and reports what was left out.
 */

import { el, mark, say } from './dom.js';
import { lasting } from './format.js';
import { want } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {(text: string, source: string, notes: string[]) => void} Opened */

const MISSION = /\.(ya?ml|mission)$/i;
const MOST = 4 << 20; // bytes of a plan
const MOST_TEXT = 1 << 20;

export class Importing {
  /** @param {() => Page} page @param {Opened} opened */
  constructor(page, opened) {
    this._page = page;
    this._opened = opened;
    const field = (/** @type {string} */ name, /** @type {string} */ value, /** @type {string} */ type = 'text') => {
      const input = el('input', { type, value, name });
      return { input, name: el('span') };
    };
    this._fields = { home: field('home', 'first'), depth: field('depth', '3'), gear: field('gear', '6'),
      pick: field('pick', ''), swap: field('swap', '', 'checkbox') };
    this._why = el('pre', { class: 'why', role: 'alert' });
    this._take = el('button', { type: 'button', onclick: () => void this._again() });
    this._drop = el('button', { type: 'button', onclick: () => this._drops() });
    this.root = el('section', { class: 'importing', hidden: true }, this._why,
      el('div', { class: 'import-asks' }, ...Object.values(this._fields).map((f) => el('label', {}, f.name, f.input)),
        this._take, this._drop));
    /** @type {{name: string, data: string} | null} */
    this._file = null;
    this._wanted = 0;
    this._since = 0; // ms, start of the import; 0: none
  }

  /** @param {number} now ms */
  show(now) {
    if (this._since && this._file) {
      say(this._why, word('import_busy', this._file.name, lasting((now - this._since) / 1000)));
    }
    mark(this.root, 'aria-busy', this._since ? 'true' : null);
    this._take.disabled = this._since > 0;
    for (const [key, f] of Object.entries(this._fields)) say(f.name, word(`import_${key}`));
    say(this._take, word('import_again'));
    say(this._drop, word('import_drop'));
  }

  /** @param {File} file */
  async open(file) {
    const wanted = this._wanted += 1;
    this._close();
    this._file = null;
    const isMission = MISSION.test(file.name);
    if (file.size > (isMission ? MOST_TEXT : MOST)) return this._refuse(word('too_large', file.name));
    if (isMission) {
      const text = await file.text();
      if (wanted === this._wanted) this._opened(text, file.name, []);
      return;
    }
    const data = base64(new Uint8Array(await file.arrayBuffer()));
    if (wanted !== this._wanted) return;
    this._file = { name: file.name, data };
    await this._send({});
  }

  async _again() {
    const { home, depth, gear, pick, swap } = this._fields;
    const place = home.input.value.trim();
    const numbers = place.split(/[\s,]+/).map(Number);
    const given = { home: place === 'first' ? 'first' : numbers.length === 2 && numbers.every(Number.isFinite)
      ? numbers : null, depth: number(depth.input.value), gear: number(gear.input.value),
    pick: pick.input.value.trim() || null, swap: swap.input.checked };
    await this._send(given);
  }

  /** @param {object} answers */
  async _send(answers) {
    const wanted = this._wanted;
    this._since = performance.now();
    this.root.hidden = false; // a survey of 100,000 points takes seconds
    this._page().redraw();
    try {
      const found = await want('/api/import', this._page().token, { ...this._file, ...answers });
      if (wanted !== this._wanted) return;
      this._close();
      this._opened(found.text, found.source, found.left_out);
    } catch (error) {
      if (wanted === this._wanted) this._refuse(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {string} why */
  _refuse(why) {
    this._since = 0;
    say(this._why, inFields(why));
    this.root.hidden = false;
    this._take.hidden = this._file === null;
    this._page().redraw();
  }

  /** Ignore the answer of the import under way. */
  _drops() {
    this._wanted += 1;
    this._close();
  }

  _close() {
    this._since = 0;
    this.root.hidden = true;
    this._page().redraw();
  }
}

/** A message for the command line, reworded for the fields here. @param {string} why */
export function inFields(why) {
  return why.replace(/--(home|depth|gear|pick|swap)\b/g, (_, name) =>
    `“${word(`import_${name}`).split(/[:,：，]/)[0]}”`);
}

/** @param {Uint8Array} bytes */
export function base64(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return btoa(text);
}

/** @param {string} text @returns {number | null} */
function number(text) {
  const found = Number(text.replace(/\s*m$/, ''));
  return text.trim() === '' || !Number.isFinite(found) ? null : found;
}
