// @ts-check
/**
 * The chart's scene of a vehicle, in metres from home, from what is known of it.
 */

import { Frame } from './geo.js';
import { freshness } from './state.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./layers.js').Scene} Scene
 * @typedef {import('./layers.js').Route} Route
 * @typedef {import('./state.js').Vehicle} Vehicle */

/** The plane of the chart: at home, or at the vehicle's first position. null: no position is known.
 * @param {Vehicle} vehicle */
export function frameOf(vehicle) {
  const first = vehicle.track[0];
  const { latitude, longitude } = vehicle.state;
  if (vehicle.plan?.home) return new Frame(...vehicle.plan.home);
  if (first !== undefined) return new Frame(first[1], first[2]);
  return typeof latitude === 'number' ? new Frame(latitude, longitude) : null;
}

/** @param {Vehicle} vehicle @param {Frame | null} frame @param {number} stale s, of a report
 * @param {number} now ms @param {readonly Vehicle[]} [others] shown by name
 * @returns {Scene} */
export function sceneOf(vehicle, frame, stale, now, others = []) {
  const { state, plan } = vehicle;
  const routes = frame ? routesOf(plan?.map, frame) : [];
  const leg = state['leg'] ?? '';
  return {
    hasPlace: frame !== null,
    home: frame && plan?.home ? frame.toLocal(...plan.home) : null,
    radius: state['to_radius']?.[1] ?? plan?.radius ?? null,
    routes,
    still: frame ? stillOf(vehicle.still, frame) : null,
    leg,
    target: routes.find((route) => route.name === leg)?.points.at(-1) ?? null,
    track: frame ? vehicle.track.map(([, lat, lon]) => frame.toLocal(lat, lon)) : [],
    here: frame ? here(vehicle, frame, stale, now) : null,
    others: frame ? others.flatMap((one) => other(one, frame, stale, now)) : [],
  };
}

/** The planned track in still water. @param {any} said the server's answer, or null
 * @param {Frame} frame @returns {import('./layers.js').Still | null} */
export function stillOf(said, frame) {
  if (!said) return null;
  if (said.is === 'flown') return { line: [], turns: [], problem: '', isFlown: true };
  const local = (/** @type {any} */ row) => frame.toLocal(row[1], row[2]);
  return { line: (said.track ?? []).map(local), problem: said.says ?? '',
    turns: (said.turns ?? []).map((/** @type {any} */ row) => ({ at: local(row), around: row[3] })) };
}

/** The legs that steer to places. @param {any} map GeoJSON, or null @param {Frame} frame
 * @returns {Route[]} */
export function routesOf(map, frame) {
  const features = /** @type {any[]} */ (map?.features ?? []);
  return features.filter((f) => !['home', 'radius'].includes(f.properties.name)).map((f) => {
    const { type, coordinates } = f.geometry;
    const forms = { Point: [coordinates], Polygon: coordinates[0] }; // an area: its ring
    const places = /** @type {Pair[]} */ (forms[/** @type {'Point'} */ (type)] ?? coordinates);
    return { name: f.properties.name, what: f.properties.what,
      points: places.map(([lon, lat]) => frame.toLocal(lat, lon)) };
  });
}

/** @param {Vehicle} vehicle @param {Frame} frame @param {number} stale @param {number} now
 * @returns {import('./layers.js').Other[]} none if it has no position */
function other(vehicle, frame, stale, now) {
  const found = here(vehicle, frame, stale, now);
  return found ? [{ name: vehicle.setup.name, at: found.at, isOld: found.isOld }] : [];
}

/** @param {Vehicle} vehicle @param {Frame} frame @param {number} stale @param {number} now
 * @returns {import('./layers.js').Here | null} its last known position */
function here(vehicle, frame, stale, now) {
  const { latitude, longitude, heading, ellipse } = vehicle.state;
  const last = vehicle.track.at(-1);
  const isKnown = typeof latitude === 'number';
  if (!isKnown && last === undefined) return null;
  const at = isKnown ? frame.toLocal(latitude, longitude) : frame.toLocal(last?.[1] ?? 0, last?.[2] ?? 0);
  const is = freshness(vehicle, isKnown ? latitude : null, 'report_at', stale, now);
  return { at, heading: heading ?? null, isOld: is !== 'fresh', ellipse: isKnown ? ellipse ?? null : null };
}
