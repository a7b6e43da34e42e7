// @ts-check
/**
 * All commands to the vehicle except X and W, and their results.
 */

import { commander, withoutMission } from './bar.js';
import { Confirm } from './confirm.js';
import { el, mark, say } from './dom.js';
import { ago, number } from './format.js';
import { Mission } from './mission.js';
import { isLive } from './state.js';
import { showRows } from './states.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./intents.js').Intent} Intent */

const SHOWN = 5;
/** Fields of ``SP``, with their names here. @type {ReadonlyArray<readonly [string, string, string]>} */
const LIMITS = [['radius_m', 'to_radius', 'm'], ['minutes', 'to_time', 'min'],
  ['depth_m', 'to_depth', 'm'], ['low_voltage_v', 'to_voltage', 'V']];

export class Command {
  /** @param {HTMLElement} root @param {() => Page} page */
  constructor(root, page) {
    this._page = page;
    this._compare = el('dl', { class: 'compare' });
    this._confirms = this._makeConfirms();
    const [start, clear, take, leave, limits, upload = el('button')] = this._confirms.map((c) => c.button);
    this._mission = new Mission(page, upload);
    for (const button of [take, leave, limits, upload]) button?.classList.add('wide');
    this._limits = LIMITS.map(() => limitField());
    this._legend = el('legend');
    this._says = el('h2');
    this._fates = el('ul', { class: 'fates' });
    this._only = el('p', { class: 'empty' });
    this._whole = el('div', {}, this._compare,
      el('div', { class: 'grid2' }, start, clear, take, leave), this._says, this._fates,
      this._mission.root, el('fieldset', {}, this._legend,
        el('div', { class: 'fields' }, ...this._limits.map((f) => f.label), limits)));
    root.replaceChildren(this._only, this._whole);
  }

  /** @returns {Confirm[]} */
  _makeConfirms() {
    const on = () => this._page().chosen.vehicle;
    const board = () => {
      const { plan, state, setup } = on();
      const name = plan?.digest === state['mission'] ? plan?.name ?? '' : '';
      return state['mission'] ? word('will_start', `${name} ${state['mission'].slice(0, 8)}`, setup.name) : '';
    };
    const upload = () => (this._mission?.chosen
      ? word('will_upload', this._mission.title, on().setup.name) : '');
    const limits = () => {
      const text = this._wanted().map(([, name, unit, value]) => `${word(name)} ${value} ${unit}`);
      return text.length ? word('will_limits', text.join(', '), on().setup.name) : '';
    };
    const plain = (/** @type {string} */ key) => () => word(key, '', on().setup.name);
    return [
      this._confirm('start', 'start', board, () => ({ digest: on().state['mission'] })),
      this._confirm('clear', 'clear', plain('will_clear'), () => ({})),
      this._confirm('take', 'take', plain('will_take'), () => ({})),
      this._confirm('release', 'leave', plain('will_release'), () => ({})),
      this._confirm('set_limits', 'say', limits, () => ({ word: 'SP', values: Object.fromEntries(
        this._wanted().map(([field, , , value]) => [field, value])) })),
      this._confirm('upload', 'upload', upload, () => this._mission?.chosen ?? {}),
    ];
  }

  /** @param {string} name @param {string} act @param {() => string} what
   * @param {() => object} values */
  _confirm(name, act, what, values) {
    return new Confirm(name, what, (says, moved) => {
      const { chosen, redraw } = this._page();
      chosen.intents.command(act, says, values(), moved);
      redraw();
    });
  }

  /** The limits that were entered. */
  _wanted() {
    return LIMITS.flatMap(([field, name, unit], i) => {
      const value = this._limits?.[i]?.input.valueAsNumber;
      return value === undefined || Number.isNaN(value) ? []
        : [/** @type {const} */ ([field, name, unit, value])];
    });
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle, intents } = page.chosen;
    const live = isLive(vehicle);
    this._whole.hidden = !live;
    this._only.hidden = live;
    say(this._only, word('read_only'));
    if (!live) return;
    this._mission.show();
    this._showCompare();
    for (const confirm of this._confirms) confirm.show(now);
    const [, , take, leave] = this._confirms;
    const ours = vehicle.state['command']?.is === 'us';
    if (take) take.button.hidden = ours;
    if (leave) leave.button.hidden = !ours;
    say(this._legend, word('limits'));
    this._limits.forEach((field, i) => showLimit(field, LIMITS[i], vehicle.state));
    say(this._says, word('done'));
    this._says.hidden = intents.list.length === 0;
    showFates(this._fates, intents.list, now);
  }

  _showCompare() {
    const { vehicle } = this._page().chosen;
    const board = vehicle.state['mission'] || '';
    const name = vehicle.plan?.digest === board ? vehicle.plan?.name : '';
    /** @type {Array<[string, string]>} */
    const rows = [
      [word('commander'), commander(this._page().chosen)],
      [word('on_board'), board ? `${name} ${board.slice(0, 8)}`.trim() : withoutMission(vehicle)],
    ];
    const planned = this._mission.digest;
    if (planned) {
      const same = planned.slice(0, 16) === board;
      rows.push([word('planned'), `${this._mission.title}: ${word(same ? 'same' : 'different')}`]);
    }
    showRows(this._compare, rows);
  }
}

function limitField() {
  const input = el('input', { type: 'number', min: '0', step: 'any', inputmode: 'decimal' });
  const name = el('span');
  return { input, name, label: el('label', {}, name, input) };
}

/** @param {ReturnType<typeof limitField>} field @param {typeof LIMITS[number] | undefined} spec
 * @param {Record<string, any>} state */
function showLimit(field, spec, state) {
  if (spec === undefined) return;
  const [, name, unit] = spec;
  const limit = state[name]?.[1];
  say(field.name, `${word(name)}, ${unit}`);
  field.input.placeholder = typeof limit === 'number' ? number(limit, 1).replace(/\.0$/, '') : '';
}

/** Newest first. @param {Element} root @param {Intent[]} list @param {number} now ms */
export function showFates(root, list, now) {
  const shown = list.slice(-SHOWN).reverse();
  while (root.childElementCount > shown.length) root.lastElementChild?.remove();
  while (root.childElementCount < shown.length) {
    root.append(el('li', {}, el('span'), el('span', { class: 'fate' }), el('span', { class: 'says' })));
  }
  shown.forEach((intent, i) => {
    const [what, fate, says] = root.children[i]?.children ?? [];
    if (!what || !fate || !says) return;
    say(what, ['stop', 'surface'].includes(intent.what) ? word(intent.what) : intent.what);
    mark(fate, 'data-is', intent.is);
    say(fate, `${fateText(intent)} ${ago((now - intent.since) / 1000)}`);
    say(says, intent.says);
  });
}

/** @param {Intent} intent */
function fateText(intent) {
  return intent.is === 'progress' ? `${intent.have} / ${intent.of}` : word(intent.is);
}

