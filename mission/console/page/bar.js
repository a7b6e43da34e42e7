// @ts-check
/**
 * The top bar: the vehicle, its source, state and mission, who commands, and the time since it was heard.
 */

import { el, mark, say } from './dom.js';
import { ago, clock } from './format.js';
import { LATE_S, age, isLive, isOld, sinceWord } from './state.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./station.js').Station} Station */

export class Bar {
  /** @param {(id: string) => HTMLElement} at @param {(station: Station) => void} choose */
  constructor(at, choose) {
    this._choose = choose;
    this._vehicles = at('vehicles');
    this._source = at('source');
    this._state = at('state');
    this._mission = at('mission');
    this._commander = at('commander');
    this._heard = at('heard');
  }

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const { vehicle } = page.chosen;
    this._showVehicles(page);
    const quiet = sinceWord(vehicle, now);
    const old = isOld(vehicle, now) ? '' : null;
    const state = vehicle.state['state'];
    say(this._state, state || word('unknown'));
    mark(this._state, 'data-level', /^emergency/.test(state ?? '') ? 'bad' : null);
    mark(this._state, 'data-old', old);
    const kind = kindOf(page.chosen);
    say(this._source, word(kind));
    mark(this._source, 'data-kind', kind);
    mark(this._source, 'data-old', old);
    say(this._mission, missionText(page.chosen, now));
    say(this._commander, commander(page.chosen));
    say(this._heard, ago(quiet));
    const isLate = isLive(vehicle) && !vehicle.setup.under_water && (quiet ?? 0) > LATE_S;
    mark(this._heard, 'data-level', isLate ? 'careful' : null);
  }

  /** @param {Page} page */
  _showVehicles(page) {
    if (this._vehicles.childElementCount !== page.stations.length) {
      this._vehicles.replaceChildren(...page.stations.map((station) => this._name(page, station)));
    }
    page.stations.forEach((station, i) => {
      const shown = this._vehicles.children[i];
      if (shown instanceof HTMLButtonElement) {
        mark(shown, 'aria-pressed', String(station === page.chosen));
      }
    });
  }

  /** @param {Page} page @param {Station} station */
  _name(page, station) {
    const { name, to } = station.vehicle.setup;
    const has = { class: 'vehicle-name', title: to ? `${name} ${to}` : name };
    if (page.stations.length === 1) return el('span', has, name);
    return el('button', { ...has, type: 'button', onclick: () => this._choose(station) }, name);
  }
}

/** @param {Station} station */
export function kindOf(station) {
  const { source, under_water: wet, simulated } = station.vehicle.setup;
  if (source === 'recording') return 'review';
  if (wet) return 'modem';
  return simulated ? 'simulation' : 'live';
}

/** @param {Station} station @param {number} now ms */
function missionText(station, now) {
  const { vehicle } = station;
  const digest = vehicle.state['mission'];
  if (!digest) return withoutMission(vehicle);
  const begun = age(vehicle, 'mission_began', now);
  const name = vehicle.plan?.digest === digest ? vehicle.plan?.name ?? '' : '';
  const parts = [name, digest.slice(0, 8), begun === null ? resting(vehicle) : clock(begun)];
  return parts.filter(Boolean).join(' · ');
}

/** For a state of unknown begin; the vehicle's frames never report one.
 * @param {import('./state.js').Vehicle} vehicle */
export function resting(vehicle) {
  const isIdle = String(vehicle.state['state'] ?? '').startsWith('idle');
  return isIdle || vehicle.setup.source !== 'frames' ? word('not_started') : '';
}

/** For a vehicle without a known mission. @param {import('./state.js').Vehicle} vehicle */
export function withoutMission(vehicle) {
  return word(vehicle.state['mission'] === undefined ? 'unknown' : 'no_mission');
}

/** @param {Station} station */
export function commander(station) {
  const { command, commander: told } = station.vehicle.state;
  if (command?.is === 'us') return word('us');
  if (command?.is === 'nobody') return word('nobody');
  return told || word(command?.is === 'other' || !command ? 'unknown' : 'nobody');
}
