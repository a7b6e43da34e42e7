// @ts-check
/**
 * Alarms, worst first, with a sound until it is silenced; an alarm that comes back sounds again.
 * With several live vehicles, the alarms of all are shown, whichever vehicle is chosen.
 *
 * The browser allows no sound before the first press on the page; until then the button says so.
 */

import { el, mark, say } from './dom.js';
import { lasting } from './format.js';
import { isCut, isHung, isLive, silence } from './state.js';
import { named, word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./station.js').Station} Station
 * @typedef {import('./state.js').Alarm} Alarm
 * @typedef {Alarm & {of: string, whose: string}} Owned ``of``: the vehicle's id; ``whose``: its name,
 *   "" if there is only one */

const NO_CONTACT = 'no contact'; // the name of the boat's own alarm
const EVERY_MS = { danger: 1500, warning: 10_000 };
const TONES = { danger: [880, 660, 880], warning: [520] }; // Hz
const TONE_S = 0.16;

/** The active alarms, worst first. @param {Station} station
 * @param {number} now ms @returns {Alarm[]} */
export function standing(station, now) {
  const { vehicle } = station;
  /** @type {Alarm[]} */
  const alarms = [];
  const tell = (/** @type {string} */ name, /** @type {Alarm['level']} */ level, words = '') =>
    alarms.push({ name, level, words, do: '' });
  const quiet = silence(vehicle, now);
  const isSilent = isLive(vehicle) && !isHung(vehicle, now) && quiet !== null
    && quiet > vehicle.setup.silent_s;
  if (vehicle.heardAt === null) tell(word('opening'), 'warning', station.problem);
  else if (isHung(vehicle, now)) {
    tell(word('lost', lasting((now - vehicle.heardAt) / 1000)), 'danger', station.problem);
  } else if (isLive(vehicle) && quiet === null) {
    tell(word('unheard'), 'warning', vehicle.state['problem'] ?? '');
  } else if (isSilent) {
    tell(word('silent', lasting(quiet)), 'danger', vehicle.state['problem'] ?? '');
  }
  if (isCut(vehicle, now) && !isHung(vehicle, now) && !isSilent && quiet !== null) tell(word('cut'), 'danger');
  if (vehicle.setup.source === 'recording' && vehicle.state['problem']) {
    tell(word('review'), 'danger', vehicle.state['problem']);
  }
  const told = /** @type {Alarm[]} */ (vehicle.state['alarms'] ?? []);
  for (const one of told) {
    if (one.name === NO_CONTACT && isSilent && alarms[0]) alarms[0].do = one.do; // shown only once
    else alarms.push({ ...one, name: named(one.name) });
  }
  return alarms.sort((a, b) => rank(a) - rank(b));
}

/** Alarms of the chosen vehicle, and of all live ones. @param {Page} page
 * @param {number} now ms @returns {Owned[]} */
export function standingOfAll({ stations, chosen }, now) {
  const watched = stations.filter((one) => one === chosen || isLive(one.vehicle));
  return watched.flatMap((station) => {
    const { id: of, name } = station.vehicle.setup;
    const whose = stations.length > 1 ? name : '';
    return standing(station, now).map((alarm) => ({ ...alarm, of, whose }));
  }).sort((a, b) => rank(a) - rank(b));
}

/** @param {Alarm} alarm */
function rank(alarm) {
  return alarm.level === 'danger' ? 0 : 1;
}

export class Alarms {
  /** @param {HTMLElement} root @param {HTMLElement} button switches the sound */
  constructor(root, button) {
    this._root = root;
    this._button = button;
    this._voice = new Voice();
    /** @type {Set<string>} */
    this._silenced = new Set();
    this._shown = '';
    button.addEventListener('click', () => this._switch());
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const alarms = standingOfAll(page, now);
    const keys = alarms.map(keyOf);
    this._silenced = new Set([...this._silenced].filter((key) => keys.includes(key)));
    const shown = keys.map((key) => key + this._silenced.has(key)).join();
    if (shown !== this._shown) {
      this._root.replaceChildren(...alarms.map((alarm) => this._row(alarm)));
      this._shown = shown;
    }
    alarms.forEach((alarm, i) => tellRow(this._root.children[i], alarm));
    const loud = alarms.filter((alarm) => !this._silenced.has(keyOf(alarm)));
    if (loud[0]) this._voice.sound(loud[0].level, now);
    this._showButton();
  }

  /** @param {Owned} alarm */
  _row(alarm) {
    const key = keyOf(alarm);
    const hushed = this._silenced.has(key);
    const hush = el('button', { type: 'button', disabled: hushed, onclick: () => {
      this._silenced.add(key);
    } }, word(hushed ? 'silenced' : 'silence'));
    return el('div', { class: 'alarm', role: 'alert', 'data-level': alarm.level },
      el('strong'), el('span'), hush);
  }

  _switch() {
    this._voice.isOn = !(this._voice.isOn && this._voice.isAllowed);
    this._voice.allow();
    this._showButton();
  }

  _showButton() {
    const works = this._voice.isOn && this._voice.isAllowed;
    say(this._button, `${word('sound')} ${word(works ? 'on' : 'off')}`);
    mark(this._button, 'aria-pressed', String(works));
    mark(this._button, 'data-blocked', this._voice.isOn && !works ? '' : null);
  }

  /** Any press allows the sound. */
  allow() {
    this._voice.allow();
  }
}

/** The alarm's key, without its numbers, which change. @param {Owned} alarm */
function keyOf(alarm) {
  return alarm.of + alarm.level + alarm.name.replace(/[\d.]+/g, '');
}

/** What to do, with the names of this page's buttons. @param {string} todo */
export function here(todo) {
  return todo.replace(/`auvmission (clear|stop)`/g, (_, name) => `“${word(name)}”`);
}

/** @param {Element | undefined} row @param {Owned} alarm */
function tellRow(row, alarm) {
  const [name, words] = row?.children ?? [];
  if (name) say(name, [alarm.whose, alarm.name].filter(Boolean).join(': '));
  const more = [alarm.words, here(alarm.do)].filter(Boolean).join(' — ');
  if (words) say(words, more);
}

class Voice {
  isOn = true;
  _last = -Infinity; // ms
  /** @type {AudioContext | null} */
  _context = null;

  get isAllowed() {
    return this._context?.state === 'running';
  }

  /** Call it within a press. */
  allow() {
    this._context ??= new AudioContext();
    void this._context.resume();
  }

  /** @param {Alarm['level']} level @param {number} now ms */
  sound(level, now) {
    if (!this.isOn || !this.isAllowed || now - this._last < EVERY_MS[level]) return;
    this._last = now;
    TONES[level].forEach((hertz, i) => this._tone(hertz, i * TONE_S));
  }

  /** @param {number} hertz @param {number} after s */
  _tone(hertz, after) {
    const context = this._context;
    if (context === null) return;
    const [tone, gain] = [context.createOscillator(), context.createGain()];
    const begin = context.currentTime + after;
    tone.frequency.value = hertz;
    gain.gain.setValueAtTime(0.25, begin);
    gain.gain.exponentialRampToValueAtTime(0.001, begin + TONE_S);
    tone.connect(gain).connect(context.destination);
    tone.start(begin);
    tone.stop(begin + TONE_S);
  }
}
