// @ts-check
/**
 * The checks of `auvmission doctor` that are possible from here, a row each, and below them doctor's
 * findings in the vehicle's file.
 *
 * What only the vehicle's computer knows (disk, black box, clock, ports) comes as its alarms. No
 * alarm does not mean that all is well: doctor on the vehicle knows more.
 */

import { withoutMission } from './bar.js';
import { ago, lasting } from './format.js';
import { age, freshness, isHung, silence } from './state.js';
import { named, word } from './words.js';

/** @typedef {import('./state.js').Vehicle} Vehicle
 * @typedef {import('./state.js').Stale} Stale
 * @typedef {'good' | 'careful' | 'bad' | 'unknown'} Level
 * @typedef {{name: string, level: Level, says: string}} Finding
 * @typedef {import('./state.js').Doctored} Doctored */

/** @type {Readonly<Record<Doctored['condition'], Level>>} */
const CONDITIONS = { ok: 'good', warning: 'careful', fault: 'bad' };
const READINGS = ['depth', 'altitude', 'heading', 'pitch', 'roll', 'speed', 'battery'];
const LIMITS = ['to_depth', 'to_radius', 'to_voltage', 'to_time'];

/** @param {Vehicle} vehicle @param {Stale} stale @param {number} now ms @returns {Finding[]} */
export function findings(vehicle, stale, now) {
  return [
    contact(vehicle, now),
    aged(vehicle, 'report', stale.report, now),
    aged(vehicle, 'fix', stale.fix, now),
    limits(vehicle),
    alarms(vehicle),
    mission(vehicle),
    sensors(vehicle),
    commands(vehicle),
    ...vehicle.doctor.map(ofDoctor),
  ];
}

/** Reported sensors that are not believed now. @param {Vehicle} vehicle
 * @returns {Finding} */
function sensors(vehicle) {
  const name = word('sensors');
  const told = READINGS.filter((one) => one in vehicle.state);
  const dumb = told.filter((one) => vehicle.state[one] === null);
  const names = (/** @type {string[]} */ of) => of.map((one) => word(one)).join(', ');
  if (!told.length) return { name, level: 'unknown', says: word('unknown') };
  return dumb.length ? { name, level: 'careful', says: word('not_believed', names(dumb)) }
    : { name, level: 'good', says: names(told) };
}

/** @param {Vehicle} vehicle @returns {Finding} */
function commands(vehicle) {
  const name = word('commander');
  const is = vehicle.state['command']?.is ?? 'unknown';
  if (is === 'us' || is === 'nobody') return { name, level: 'good', says: word(is) };
  if (is === 'other') return { name, level: 'careful', says: vehicle.state['commander'] || word('unknown') };
  return { name, level: 'unknown', says: word('unknown') };
}

/** Doctor's finding in the vehicle's file, in its own words. @param {Doctored} one
 * @returns {Finding} */
function ofDoctor({ what, condition, says, todo }) {
  return { name: what, level: CONDITIONS[condition], says: todo ? `${says} — ${todo}` : says };
}

/** @param {Vehicle} vehicle @param {number} now @returns {Finding} */
function contact(vehicle, now) {
  const quiet = silence(vehicle, now);
  const is = quiet === null || isHung(vehicle, now) || quiet > vehicle.setup.silent_s ? 'bad' : 'good';
  return { name: word('link'), level: is, says: vehicle.state['problem'] || `${word('heard')} ${ago(quiet)}` };
}

/** @param {Vehicle} vehicle @param {'report' | 'fix'} name @param {number} most s
 * @param {number} now @returns {Finding} */
function aged(vehicle, name, most, now) {
  const at = `${name}_at`;
  const old = age(vehicle, at, now);
  const is = freshness(vehicle, vehicle.state[at], at, most, now);
  /** @type {Level} */
  const level = is === 'fresh' ? 'good' : 'bad';
  return { name: word(name), level, says: old === null ? word('never') : lasting(old) };
}

/** Limits that are off, or already breached. @param {Vehicle} vehicle @returns {Finding} */
function limits(vehicle) {
  const told = LIMITS.filter((name) => Array.isArray(vehicle.state[name]));
  const off = told.filter((name) => vehicle.state[name][1] === null);
  const broken = told.filter((name) => (vehicle.state[name][0] ?? 1) < 0);
  const names = (/** @type {string[]} */ of) => of.map((name) => word(name)).join(', ');
  const name = word('limits');
  if (broken.length) return { name, level: 'bad', says: word('beyond', names(broken)) };
  // the command port reports no bound
  if (!told.length || off.length === told.length) return { name, level: 'unknown', says: word('unknown') };
  return off.length ? { name, level: 'careful', says: word('limits_off', names(off)) }
    : { name, level: 'good', says: word('limits_on', names(told)) };
}

/** @param {Vehicle} vehicle @returns {Finding} */
function alarms(vehicle) {
  /** @type {import('./state.js').Alarm[] | undefined} */
  const standing = vehicle.state['alarms'];
  const name = word('alarms');
  if (standing === undefined) return { name, level: 'unknown', says: word('unknown') };
  if (!standing.length) return { name, level: 'good', says: word('none_stands') };
  const level = standing.some((one) => one.level === 'danger') ? 'bad' : 'careful';
  return { name, level, says: standing.map((one) => named(one.name)).join(', ') };
}

/** @param {Vehicle} vehicle @returns {Finding} */
function mission(vehicle) {
  const name = word('mission');
  const digest = vehicle.state['mission'];
  if (!digest) {
    return { name, level: digest === undefined ? 'unknown' : 'careful', says: withoutMission(vehicle) };
  }
  const says = `${vehicle.plan?.name ?? ''} ${digest.slice(0, 8)}`.trim();
  return { name, level: vehicle.plan ? 'good' : 'careful', says };
}
