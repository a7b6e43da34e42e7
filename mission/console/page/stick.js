// @ts-check
/**
 * The stick: off until it is switched on by a press; then its axes are sent ten times a second.
 *
 * The page sends axes only while ``Hand`` counts them. It stops the vehicle by silence; the vehicle's
 * own timeout of 2 s (R6) is the last safeguard.
 */

import { commander } from './bar.js';
import { el, isWriting, mark, say } from './dom.js';
import { lasting, number } from './format.js';
import { Hand } from './hand.js';
import { isHung, isLive } from './state.js';
import { Line } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./hand.js').Axes} Axes
 * @typedef {{is: 'off' | 'ready' | 'driving' | 'refused', says: string, sent: string,
 *   age: number | null}} Told */

const EVERY_MS = 100;
const AXES = /** @type {const} */ (['surge', 'turn', 'heave']);

export class Stick {
  /** @param {HTMLElement} root @param {() => Page} page */
  constructor(root, page) {
    this._page = page;
    this._hand = new Hand();
    /** @type {Line | null} */
    this._line = null;
    /** @type {import('./station.js').Station | null} its vehicle */
    this._of = null;
    /** @type {Told | null} */
    this._told = null;
    this._toldAt = 0;
    /** @type {import('./hand.js').Held} */
    this._held = { axes: null, why: '' };
    this._timer = 0;
    this._build(root);
    this._listen();
  }

  /** @param {HTMLElement} root */
  _build(root) {
    this._state = el('div', { class: 'stick-state', role: 'status' });
    this._take = el('button', { type: 'button', class: 'wide', onclick: () => this._switch() });
    this._rows = AXES.map(() => axisRow());
    this._sent = el('p', { class: 'note' });
    this._less = el('button', { type: 'button', onclick: () => this._change(-1) }, '−');
    this._more = el('button', { type: 'button', onclick: () => this._change(1) }, '+');
    this._strength = el('output');
    this._pad = el('p', { class: 'note' });
    this._notes = [el('p', { class: 'note' }), el('p', { class: 'note' })];
    root.replaceChildren(this._state, el('div', { class: 'grid2' }, this._take),
      el('div', { class: 'head' }, this._less, this._strength, this._more),
      el('div', { class: 'axes' }, ...this._rows.flatMap((r) => [r.name, r.bar, r.value])),
      this._sent, this._pad, ...this._notes);
  }

  _listen() {
    document.addEventListener('keydown', (event) => {
      if (!this._line || event.ctrlKey || event.altKey || event.metaKey) return;
      if (isWriting(event.target) || event.target instanceof HTMLInputElement) return; // e.g. a limit
      if (this._hand.press(event.code, event.shiftKey, event.repeat) && event.shiftKey) {
        event.preventDefault();
        event.stopPropagation(); // an arrow key that steers does not scroll
      }
    }, { capture: true });
    document.addEventListener('keyup', (event) => this._hand.release(event.code, event.shiftKey));
    window.addEventListener('blur', () => this._away());
    document.addEventListener('visibilitychange', () => this._away());
    window.addEventListener('gamepaddisconnected', () => this._tick());
  }

  /** Send it at once: the ticks of a hidden page are late. */
  _away() {
    if (!this._line) return;
    this._hand.drop('hidden');
    this._tick();
  }

  /** @param {number} by */
  _change(by) {
    this._hand.change(by);
    this._page().redraw();
  }

  _switch() {
    if (this._line) this._drop();
    else this._begin();
    this._page().redraw();
  }

  _begin() {
    const { chosen, token } = this._page();
    if (!isLive(chosen.vehicle)) return;
    this._of = chosen;
    this._hand = new Hand();
    const heard = (/** @type {Told} */ told) => {
      [this._told, this._toldAt] = [told, performance.now()];
      this._page().redraw();
    };
    this._line = new Line(`/ws/stick?vehicle=${encodeURIComponent(chosen.vehicle.setup.id)}`, token,
      { heard, closed: () => this._cut() });
    this._timer = setInterval(() => this._tick(), EVERY_MS);
  }

  _drop() {
    this._say(null);
    clearInterval(this._timer);
    this._line?.close();
    [this._line, this._of, this._told] = [null, null, null];
    this._held = { axes: null, why: '' };
  }

  _cut() {
    this._told = null;
    this._hand.drop('gone');
  }

  _tick() {
    if (!this._line) return;
    if (this._page().chosen !== this._of) return this._drop(); // another vehicle was chosen
    const before = this._held.axes;
    const isInFront = document.visibilityState === 'visible' && document.hasFocus();
    this._held = this._hand.held(pad(), isInFront, performance.now());
    if (this._held.axes || before) this._say(this._held.axes);
    this._page().redraw();
  }

  /** @param {Axes | null} axes null: let go */
  _say(axes) {
    const at = Date.now() / 1000;
    this._line?.send(axes ? { at, ...axes } : { at, held: false });
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    if (this._take) {
      say(this._take, word(this._line ? 'stick_drop' : 'stick_take'));
      this._take.disabled = !isLive(vehicle) || vehicle.setup.under_water;
      mark(this._take, 'aria-pressed', String(this._line !== null));
    }
    const is = this._is(page, now);
    if (this._state) {
      say(this._state, is.text);
      mark(this._state, 'data-is', is.is);
    }
    AXES.forEach((name, i) => showAxis(this._rows?.[i], name, this._held.axes?.[name] ?? 0));
    this._showWords(now);
  }

  /** @param {Page} page @param {number} now @returns {{is: string, text: string}} */
  _is(page, now) {
    const { vehicle } = page.chosen;
    if (!isLive(vehicle)) return { is: 'off', text: word('stick_live_only') };
    if (vehicle.setup.under_water) return { is: 'off', text: word('stick_not_modem') };
    if (!this._line) return { is: 'off', text: word('stick_off') };
    if (!this._line.isOpen || isHung(vehicle, now)) return { is: 'refused', text: word('stick_cut') };
    if (this._told?.is === 'refused') return { is: 'refused', text: this._told.says };
    if (vehicle.state['command']?.is === 'other') {
      return { is: 'refused', text: word('stick_not_ours', commander(page.chosen)) };
    }
    if (this._held.why) return { is: 'refused', text: word(`stick_${this._held.why}`) };
    const driving = this._told?.is === 'driving' && this._held.axes !== null;
    return driving ? { is: 'driving', text: word('stick_driving') }
      : { is: 'ready', text: word('stick_ready') };
  }

  /** @param {number} now */
  _showWords(now) {
    const told = this._told;
    const age = told?.age === null || !told ? '' : lasting(told.age + (now - this._toldAt) / 1000);
    const put = (/** @type {Element | undefined} */ at, /** @type {string} */ text) => at && say(at, text);
    put(this._sent, told ? `${word('told')} ${told.sent || '—'} · ${word('answer')} ${age}` : '');
    put(this._strength, `${word('strength')} ${this._hand.strength} / 12`);
    this._less?.setAttribute('aria-label', word('weaker'));
    this._more?.setAttribute('aria-label', word('stronger'));
    put(this._pad, pad()?.id ?? word('no_pad'));
    put(this._notes?.[0], word('stick_keys'));
    put(this._notes?.[1], word('stick_pad_says'));
  }
}

/** The first gamepad. @returns {Gamepad | null} */
function pad() {
  return navigator.getGamepads().find((one) => one?.connected) ?? null;
}

function axisRow() {
  const fill = el('div');
  return { name: el('span'), fill, bar: el('div', { class: 'axis', 'aria-hidden': 'true' }, fill),
    value: el('output') };
}

/** @param {ReturnType<typeof axisRow> | undefined} row @param {string} name @param {number} value */
function showAxis(row, name, value) {
  if (!row) return;
  say(row.name, word(name));
  say(row.value, `${number(value * 100, 0)} %`);
  row.fill.style.left = `${50 + Math.min(0, value) * 50}%`;
  row.fill.style.width = `${Math.abs(value) * 50}%`;
}
