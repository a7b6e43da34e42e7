// @ts-check
/**
 * All that the page knows of a vehicle. Only ``update`` changes it, from a frame.
 *
 * Times from the vehicle are its own, s; ``now`` is the page's, ms of ``performance.now()``. The
 * protocol is in docs/design/console.md.
 */

/**
 * @typedef {{id: string, name: string, to: string, source: 'monitor' | 'frames' | 'recording',
 *   under_water: boolean, simulated: boolean, speed: number, silent_s: number,
 *   checklist: string[]}} Setup
 * @typedef {{intent: number, report: number, fix: number}} Stale s
 * @typedef {[number, number, number, number | null]} Point t, latitude, longitude, depth
 * @typedef {{n: number, t: number, state?: Record<string, any>, events?: string[],
 *   track?: Point[], gap?: number, past?: Row[]}} Frame
 * @typedef {Array<number | null>} Row vehicle's time of a report, then the values of ``PAST``
 * @typedef {{digest: string, name: string, vehicle: string, text: string, lines: number,
 *   svg: string, map: any, home: [number, number] | null, radius: number | null,
 *   problem: string}} Plan
 * @typedef {[number, number | null]} Sample vehicle's time, value
 * @typedef {{name: string, level: 'danger' | 'warning', words: string, do: string}} Alarm
 * @typedef {{what: string, condition: 'ok' | 'warning' | 'fault', says: string, todo: string}} Doctored
 * @typedef {'fresh' | 'old' | 'unknown'} Freshness
 */

export const EVENTS = 1000; // kept
export const TRACK = 10_000;
export const ROWS = 4096; // of the past: beyond that, every other one is dropped
export const HUNG_MS = 2000; // a frame comes each second: else the server hangs, or has ended
const CUT_MS = 3000; // a lost connection is opened again within a second

/** Values in a report of the vehicle's board, with unit and digits after the point.
 * @type {Readonly<Record<string, readonly [string, number]>>} */
export const MEASURED = {
  depth: ['m', 1],
  altitude: ['m', 1],
  heading: ['°', 0],
  speed: ['m/s', 2],
  battery: ['V', 1],
  pitch: ['°', 0],
  roll: ['°', 0],
};

export const LATE_S = 2; // without any answer of a vehicle that is asked each second: it may hang
/** The values of a row of the past, after its time. */
export const PAST = ['depth', 'altitude', 'heading', 'pitch', 'roll', 'battery', 'uncertainty',
  'to_depth', 'to_radius', 'to_time', 'to_voltage'];

export class Vehicle {
  /** @type {Record<string, any>} */
  state = {};
  /** @type {string[]} */
  events = [];
  /** @type {Point[]} */
  track = [];
  /** @type {Row[]} by time */
  past = [];
  /** @type {Record<string, Sample[]>} the same, by name */
  strips = {};
  /** @type {Record<string, Sample>} the last known sample of each value */
  known = {};
  t = 0;
  snapshots = 0;
  told = 0; // events, including dropped ones
  gap = 0; // events that are missing
  /** @type {Plan | null} what is on board */
  plan = null;
  /** @type {any} its track in still water, from the server */
  still = null;
  /** @type {Doctored[]} doctor's findings in its file */
  doctor = [];
  /** @type {number | null} ms */
  heardAt = null;
  /** @type {number | null} ms, since when X and W have no connection */
  cutAt = null;

  /** @param {Setup} setup */
  constructor(setup) {
    this.setup = setup;
  }

  forget() {
    const { setup, plan, still, heardAt, cutAt, snapshots } = this;
    Object.assign(this, new Vehicle(setup), { plan, still, heardAt, cutAt, snapshots: snapshots + 1 });
  }
}

/** @param {Vehicle} vehicle @param {Frame} frame @param {number} now ms */
export function update(vehicle, frame, now) {
  if (frame.n === 1) vehicle.forget();
  const before = vehicle.state['report_at'];
  Object.assign(vehicle.state, frame.state ?? {});
  vehicle.t = frame.t;
  vehicle.heardAt = now;
  vehicle.cutAt = vehicle.state['lines']?.orders === null ? vehicle.cutAt ?? now : null;
  vehicle.events = [...vehicle.events, ...(frame.events ?? [])].slice(-EVENTS);
  vehicle.told += frame.events?.length ?? 0;
  vehicle.gap += frame.gap ?? 0;
  vehicle.track = [...vehicle.track, ...frame.track ?? []].slice(-TRACK);
  if (frame.past?.length) learn(vehicle, frame.past);
  const reported = vehicle.state['report_at'];
  if (typeof reported === 'number' && reported !== before) remember(vehicle, reported);
}

/** @param {Vehicle} vehicle @param {number} t of the report */
function remember(vehicle, t) {
  for (const name of Object.keys(MEASURED)) {
    const value = vehicle.state[name];
    if (typeof value === 'number') vehicle.known[name] = [t, value];
  }
}

/** Rows of the past come in any order: older ones may come last, and twice.
 * @param {Vehicle} vehicle @param {Row[]} rows */
function learn(vehicle, rows) {
  const last = timeOfRow(vehicle.past.at(-1));
  const areNewer = rows.every((row, i) => timeOfRow(row) > (i ? timeOfRow(rows[i - 1]) : last));
  if (areNewer && vehicle.past.length + rows.length <= ROWS) {
    vehicle.past.push(...rows);
    add(vehicle.strips, rows);
    return;
  }
  vehicle.past = inOrder([...vehicle.past, ...rows]);
  while (vehicle.past.length > ROWS) vehicle.past = vehicle.past.filter((_, i) => i % 2 === 0);
  vehicle.strips = {};
  add(vehicle.strips, vehicle.past);
}

/** @param {Record<string, Sample[]>} strips @param {readonly Row[]} rows */
function add(strips, rows) {
  for (const row of rows) {
    PAST.forEach((name, i) => (strips[name] ??= []).push([timeOfRow(row), row[i + 1] ?? null]));
    const [depth, altitude] = [row[PAST.indexOf('depth') + 1], row[PAST.indexOf('altitude') + 1]];
    (strips['floor'] ??= []).push([timeOfRow(row), sum(depth, altitude)]);
  }
}

/** @param {Row | undefined} row */
function timeOfRow(row) {
  return row?.[0] ?? -Infinity;
}

/** @param {Row[]} rows @returns {Row[]} by time, each once */
function inOrder(rows) {
  return [...new Map(rows.map((row) => [timeOfRow(row), row])).values()]
    .sort((a, b) => timeOfRow(a) - timeOfRow(b));
}

/** @param {number | null | undefined} a @param {number | null | undefined} b */
function sum(a, b) {
  return typeof a === 'number' && typeof b === 'number' ? a + b : null;
}

// --- derived values ---

/** Seconds of the vehicle that pass in one of the page. @param {Vehicle} vehicle */
export function pace(vehicle) {
  const review = vehicle.state['review'];
  if (vehicle.setup.source !== 'recording') return vehicle.setup.speed || 1;
  return review?.playing ? review.speed : 0;
}

/** The vehicle's time. @param {Vehicle} vehicle @param {number} now ms */
export function timeOf(vehicle, now) {
  if (vehicle.heardAt === null) return 0;
  return vehicle.t + (Math.max(0, now - vehicle.heardAt) / 1000) * pace(vehicle);
}

/** Seconds since ``name`` (report_at, fix_at, leg_began, ...); null: not known.
 * @param {Vehicle} vehicle @param {string} name @param {number} now ms */
export function age(vehicle, name, now) {
  const at = vehicle.state[name];
  if (typeof at !== 'number' || vehicle.heardAt === null) return null;
  return Math.max(0, timeOf(vehicle, now) - at);
}

/** Does the console itself answer? @param {Vehicle} vehicle @param {number} now ms */
export function isHung(vehicle, now) {
  return vehicle.heardAt === null || now - vehicle.heardAt > HUNG_MS;
}

/** Seconds since any news of the vehicle; null: none so far, or not known.
 * @param {Vehicle} vehicle @param {number} now ms */
export function silence(vehicle, now) {
  const told = vehicle.state['silence'];
  if (typeof told !== 'number' || vehicle.heardAt === null) return null;
  return told + Math.max(0, now - vehicle.heardAt) / 1000;
}

/** Seconds since the vehicle's program has sent anything, a frame or an answer, of which one comes
 * each second; null: not known. @param {Vehicle} vehicle @param {number} now ms */
export function sinceWord(vehicle, now) {
  const lines = Object.values(vehicle.state['lines'] ?? {}).filter((one) => typeof one === 'number');
  const quiet = silence(vehicle, now);
  const since = Math.max(0, now - (vehicle.heardAt ?? now)) / 1000;
  return quiet === null ? null : Math.min(quiet, ...lines.map((one) => one + since));
}

/** Has the vehicle had no connection for X and W, longer than reopening it takes?
 * @param {Vehicle} vehicle @param {number} now ms */
export function isCut(vehicle, now) {
  return isLive(vehicle) && !vehicle.setup.under_water && vehicle.cutAt !== null && now - vehicle.cutAt > CUT_MS;
}

/** The freshness of a value that is measured with ``at``. @param {Vehicle} vehicle @param {any} value
 * @param {string} at @param {number} stale s @param {number} now ms @returns {Freshness} */
export function freshness(vehicle, value, at, stale, now) {
  const old = age(vehicle, at, now);
  if (value === null || value === undefined || old === null) return 'unknown';
  const late = stale + Math.max(0, pace(vehicle) - 1); // s: one more second of the page
  return old > late || isHung(vehicle, now) ? 'old' : 'fresh';
}

/** Is the shown state out of date? @param {Vehicle} vehicle @param {number} now ms */
export function isOld(vehicle, now) {
  const quiet = silence(vehicle, now);
  return isHung(vehicle, now) || (isLive(vehicle) && (quiet === null || quiet > vehicle.setup.silent_s));
}

/** Can it be commanded? @param {Vehicle} vehicle */
export function isLive(vehicle) {
  return vehicle.setup.to !== '' && vehicle.setup.source !== 'recording';
}

/** Seconds until a margin is used up, at the rate of the last minute, or of its last quarter if that
 * is less, because a descent may have ended. null: it is not falling.
 * @param {Sample[]} samples of what is left */
export function runsOut(samples, over = 60) {
  const last = samples.at(-1);
  if (last === undefined || last[1] === null || last[1] <= 0) return null;
  const rates = [over, over / 4].map((within) => falls(samples, last, within, over / 4));
  const rate = Math.min(...rates);
  return rate > 1e-6 ? last[1] / rate : null;
}

/** Fall per second; 0: not known. @param {Sample[]} samples @param {Sample} last
 * @param {number} within @param {number} least s that are needed */
function falls(samples, last, within, least) {
  const first = samples.findLast(([t, v]) => v !== null && t <= last[0] - within)
    ?? samples.find(([, v]) => v !== null);
  if (first === undefined || last[0] - first[0] < least) return 0;
  return (Number(first[1]) - Number(last[1])) / (last[0] - first[0]);
}
