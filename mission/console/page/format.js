// @ts-check
/**
 * Numbers, ages and places for people; null is not known.
 */

import { word } from './words.js';

const NARROW = '\u202f'; // between degrees and minutes: no line break there

/** @param {number} seconds age; for some hours, to one tenth at most */
export function lasting(seconds) {
  const s = Math.max(0, seconds);
  if (s < 9.95) return word('seconds', s.toFixed(1));
  if (s < 119.5) return word('seconds', s.toFixed(0));
  if (s < 7170) return word('minutes', (s / 60).toFixed(0));
  return word('hours', (s / 3600).toFixed(1));
}

/** @param {number | null} seconds */
export function ago(seconds) {
  return seconds === null ? word('never') : word('ago', lasting(seconds));
}

/** m:ss or h:mm:ss. @param {number} seconds */
export function clock(seconds) {
  const s = Math.max(0, Math.floor(seconds));
  const two = (/** @type {number} */ n) => String(n).padStart(2, '0');
  const hours = Math.floor(s / 3600);
  const rest = `${hours ? two(Math.floor(s / 60) % 60) : Math.floor(s / 60)}:${two(s % 60)}`;
  return hours ? `${hours}:${rest}` : rest;
}

/** @param {number | null | undefined} value @param {number} [digits] after the point */
export function number(value, digits = 1) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '—';
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '−');
}

/** Three digits, as on a compass. @param {number | null | undefined} deg */
export function bearing(deg) {
  if (deg === null || deg === undefined || !Number.isFinite(deg)) return '—';
  return String((Math.round(deg) % 360 + 360) % 360).padStart(3, '0') + '°';
}

/** @param {number} m */
export function length(m) {
  if (m < 10) return `${number(m, 1)} m`;
  if (m < 2000) return `${number(m, 0)} m`;
  return `${number(m / 1000, m < 10_000 ? 2 : m < 100_000 ? 1 : 0)} km`;
}

/** Degrees and minutes to 2 m, as on a chart. @param {number} lat @param {number} lon deg */
export function place(lat, lon) {
  return `${minutes(lat, 'N', 'S', 2)} ${minutes(lon, 'E', 'W', 3)}`;
}

/** @param {number} deg @param {string} more @param {string} less @param {number} places */
function minutes(deg, more, less, places) {
  const all = Math.round(Math.abs(deg) * 60000) / 1000;
  const whole = Math.floor(all / 60);
  const rest = (all - whole * 60).toFixed(3).padStart(6, '0');
  return `${String(whole).padStart(places, '0')}°${NARROW}${rest}′${deg < 0 ? less : more}`;
}
