// @ts-check
/**
 * What a plan's chart adds to a vehicle's: places that can be dragged, and a ghost's track.
 */

import { ellipse } from './geo.js';
import { font } from './layers.js';
import { isFree } from './view.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./geo.js').Frame} Frame
 * @typedef {import('./layers.js').Pen} Pen
 * @typedef {import('./layers.js').Inks} Inks
 * @typedef {import('./view.js').View} View
 * @typedef {{path: string, kind: 'home' | 'place' | 'corner', word: string, at: Pair | null,
 *   row: Pair, spans: Array<[number, number, number]>, fixed: string}} Place as the server sends it
 * @typedef {[number, number, number, Pair3]} Believed t, latitude, longitude, ellipse
 * @typedef {[number, number, number]} Pair3
 * @typedef {{track: Array<[number, number, number, number]>, believed: Believed[],
 *   up: Pair3[], seconds: number}} Ghost */

const RINGS = 16; // ellipses along a ghost's track
const NEAR_PX = 14;
const CELL_PX = 5; // places closer than that are drawn as one
const TOUCH_PX = 26;
const TURN = 2 * Math.PI;

/** The nearest place under the finger. @param {readonly Place[]} places @param {Frame} frame
 * @param {View} view @param {Pair} at px @param {boolean} isTouch @returns {number} -1: none */
export function placeNear(places, frame, view, at, isTouch) {
  let [found, best] = [-1, isTouch ? TOUCH_PX : NEAR_PX];
  places.forEach((place, i) => {
    if (place.at === null) return;
    const [x, y] = view.toScreen(frame.toLocal(...place.at));
    const under = place.kind === 'home' ? 3 : 0; // px: it is below the first places of many missions
    const far = Math.hypot(x - at[0], y - at[1]) + under;
    if (far < best) [found, best] = [i, far];
  });
  return found;
}

/** @param {Pen} pen @param {View} view @param {Frame} frame @param {Inks} inks
 * @param {readonly Place[]} places @param {number} chosen @param {Pair | null} carried m: where the
 *   chosen one is being moved */
export function drawPlaces(pen, view, frame, inks, places, chosen, carried) {
  /** @type {Set<string>} */
  const taken = new Set();
  places.forEach((place, i) => {
    if (place.at === null) return;
    const at = frame.toLocal(...place.at);
    if (i !== chosen && !isFree(view, view.toScreen(at), taken, CELL_PX)) return;
    if (i === chosen && carried) tether(pen, view, at, carried, inks);
    knob(pen, view.toScreen(i === chosen && carried ? carried : at), place, i === chosen, inks);
  });
}

/** @param {Pen} pen @param {Pair} at px @param {Place} place @param {boolean} isChosen
 * @param {Inks} inks */
function knob(pen, [x, y], place, isChosen, inks) {
  const size = isChosen ? 9 : 7;
  pen.beginPath();
  if (place.kind === 'corner') pen.rect(x - size + 1, y - size + 1, 2 * size - 2, 2 * size - 2);
  else pen.arc(x, y, size, 0, TURN);
  pen.fillStyle = isChosen ? inks.target : inks.paper;
  pen.fill();
  pen.setLineDash(place.fixed ? [3, 3] : []);
  pen.lineWidth = isChosen ? 3 : 2.5;
  pen.strokeStyle = isChosen ? inks.ink : inks.target;
  pen.stroke();
  pen.setLineDash([]);
}

/** A line from its old to its present position. @param {Pen} pen @param {View} view @param {Pair} from
 * @param {Pair} to m @param {Inks} inks */
function tether(pen, view, from, to, inks) {
  pen.strokeStyle = inks.target;
  pen.lineWidth = 1.5;
  pen.setLineDash([4, 4]);
  pen.beginPath();
  pen.moveTo(...view.toScreen(from));
  pen.lineTo(...view.toScreen(to));
  pen.stroke();
  pen.setLineDash([]);
}

/** The estimated track with its ellipses, the true one, where it surfaced, and where it was at a
 * time. @param {Pen} pen @param {View} view @param {Frame} frame @param {Inks} inks
 * @param {Ghost} ghost @param {number} t s */
export function drawGhost(pen, view, frame, inks, ghost, t) {
  const local = (/** @type {readonly any[]} */ row) => frame.toLocal(row[1], row[2]);
  const line = (/** @type {readonly any[][]} */ rows) => {
    pen.beginPath();
    for (const row of rows) pen.lineTo(...view.toScreen(local(row)));
    pen.stroke();
  };
  pen.lineWidth = 1.5;
  pen.strokeStyle = inks.vehicle;
  const step = Math.max(1, Math.floor(ghost.believed.length / RINGS));
  pen.globalAlpha = 0.5;
  ghost.believed.filter((_, i) => i % step === 0).forEach((row) => ring(pen, view, local(row), row[3]));
  pen.globalAlpha = 1;
  pen.setLineDash([3, 4]);
  line(ghost.believed);
  pen.setLineDash([]);
  pen.lineWidth = 2.5;
  pen.strokeStyle = inks.track;
  line(ghost.track);
  for (const row of ghost.up) risen(pen, view.toScreen(local(row)), inks);
  then(pen, view, inks, ghost, t, local);
}

/** @param {Pen} pen @param {View} view @param {Inks} inks @param {Ghost} ghost @param {number} t
 * @param {(row: readonly any[]) => Pair} local */
function then(pen, view, inks, ghost, t, local) {
  const i = Math.max(0, ghost.believed.findLastIndex((row) => row[0] <= t));
  const [seen, true_] = [ghost.believed[i], ghost.track[i]];
  if (!seen || !true_) return;
  pen.strokeStyle = inks.vehicle;
  pen.lineWidth = 2.5;
  ring(pen, view, local(seen), seen[3]);
  const [x, y] = view.toScreen(local(true_));
  pen.beginPath();
  pen.arc(x, y, 6, 0, TURN);
  pen.fillStyle = inks.vehicle;
  pen.fill();
  font(pen, 13, 600);
  pen.textAlign = 'left';
  pen.lineWidth = 4;
  pen.strokeStyle = inks.paper;
  const text = `${true_[3].toFixed(1)} m`;
  pen.strokeText(text, x + 10, y + 18);
  pen.fillText(text, x + 10, y + 18);
}

/** @param {Pen} pen @param {View} view @param {Pair} at m @param {Pair3} around */
function ring(pen, view, at, around) {
  pen.beginPath();
  for (const point of ellipse(at, ...around, 32)) pen.lineTo(...view.toScreen(point));
  pen.closePath();
  pen.stroke();
}

/** An arrow upward. @param {Pen} pen @param {Pair} at px @param {Inks} inks */
function risen(pen, [x, y], inks) {
  pen.fillStyle = inks.track;
  pen.beginPath();
  pen.moveTo(x, y - 12);
  pen.lineTo(x + 8, y + 4);
  pen.lineTo(x - 8, y + 4);
  pen.closePath();
  pen.fill();
}
