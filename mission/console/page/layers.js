// @ts-check
/**
 * The layers of the chart, a function each, lowest first in ``LAYERS``.
 *
 * Points are east and north of the scene's origin, m. Nothing is extrapolated: a vehicle is drawn at
 * its last known position, and marked old when that is old.
 */

import { ellipse } from './geo.js';
import { length } from './format.js';
import { isFree, roundUp, ticks } from './view.js';
import { word } from './words.js';

/**
 * @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./view.js').View} View
 * @typedef {CanvasRenderingContext2D} Pen
 * @typedef {{name: string, what: string, points: Pair[]}} Route
 * @typedef {{at: Pair, heading: number | null, isOld: boolean,
 *   ellipse: readonly [number, number, number] | null}} Here
 * @typedef {{hasPlace: boolean, home: Pair | null, radius: number | null, routes: Route[],
 *   still?: Still | null, leg: string, target: Pair | null, track: Pair[], here: Here | null, others: Other[],
 *   beside?: {now: Beside | null, other: Beside | null}, charts?: {draw: (pen: Pen, view: View) => void}}} Scene
 * @typedef {{name: string, at: Pair, isOld: boolean}} Other
 * @typedef {{line: Pair[], turns: {at: Pair, around: readonly [number, number, number]}[],
 *   problem: string, isFlown?: boolean}} Still isFlown: it is being computed
 * @typedef {import('./compare.js').Beside} Beside
 * @typedef {Record<'paper' | 'grid' | 'ink' | 'soft' | 'track' | 'plan' | 'target' | 'limit'
 *   | 'vehicle' | 'old', string>} Inks
 */

/** A layer's inks, by the names of the theme's colours. */
export const INK_NAMES = { paper: 'sea', grid: 'grid', ink: 'ink', soft: 'soft', track: 'track', plan: 'plan',
  target: 'target', limit: 'limit', vehicle: 'craft', old: 'old' };

const CELL_PX = 3; // legs closer than that are drawn as one
const LINE_PX = 90; // least distance of grid lines
/** @type {readonly Pair[]} */
const HULL = [[0, -15], [9, 11], [0, 6], [-9, 11]]; // px, ahead upward
/** @type {readonly Pair[]} */
const CROSS = [[1, 0], [-1, 0], [0, 1], [0, -1]];
const NARROW = 600; // px: below that the position fills the whole width
const TURN = 2 * Math.PI;

/** @type {ReadonlyArray<(pen: Pen, view: View, scene: Scene, inks: Inks) => void>} */
export const LAYERS = [paper, charts, grid, limit, stillWater, plan, homeMark, besideLines, trackLine, targetMark, others, uncertainty,
  vehicle, scaleBar, northArrow];

/** @param {Pen} pen @param {View} view @param {Scene} _ @param {Inks} inks */
function paper(pen, view, _, inks) {
  pen.fillStyle = inks.paper;
  pen.fillRect(0, 0, view.width, view.height);
}

/** @param {Pen} pen @param {View} view @param {Scene} scene */
function charts(pen, view, scene) {
  scene.charts?.draw(pen, view);
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function grid(pen, view, scene, inks) {
  const step = roundUp(LINE_PX / view.scale);
  const [west, north] = view.toWorld([0, 0]);
  const [east, south] = view.toWorld([view.width, view.height]);
  pen.strokeStyle = inks.grid;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const e of ticks(west, east, step)) {
    const x = Math.round(view.toScreen([e, 0])[0]) + 0.5;
    pen.moveTo(x, 0);
    pen.lineTo(x, view.height);
  }
  for (const n of ticks(south, north, step)) {
    const y = Math.round(view.toScreen([0, n])[1]) + 0.5;
    pen.moveTo(0, y);
    pen.lineTo(view.width, y);
  }
  pen.stroke();
  if (scene.hasPlace) gridNumbers(pen, view, inks, step);
}

/** Metres east and north of the origin, at the edges. @param {Pen} pen @param {View} view
 * @param {Inks} inks @param {number} step m */
function gridNumbers(pen, view, inks, step) {
  const [west, north] = view.toWorld([0, 0]);
  const [east, south] = view.toWorld([view.width, view.height]);
  font(pen, 11);
  pen.fillStyle = inks.soft;
  Object.assign(pen, { strokeStyle: inks.paper, lineWidth: 3, lineJoin: 'round' }); // for bright scans
  const put = (/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y) => {
    pen.strokeText(text, x, y);
    pen.fillText(text, x, y);
  };
  const far = (/** @type {number} */ m, /** @type {string} */ more, /** @type {string} */ less) =>
    m === 0 ? '0' : `${length(Math.abs(m)).replace('.0 ', ' ')} ${m > 0 ? more : less}`;
  pen.textAlign = 'center';
  for (const e of ticks(west, east, step)) {
    const [x] = view.toScreen([e, 0]);
    if (x > 60 && x < view.width - 60) put(far(e, 'E', 'W'), x, 13);
  }
  pen.textAlign = 'left';
  for (const n of ticks(south, north, step)) {
    const [, y] = view.toScreen([0, n]);
    if (y > 26 && y < view.height - 60) put(far(n, 'N', 'S'), 5, y - 4);
  }
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function limit(pen, view, scene, inks) {
  pen.strokeStyle = inks.limit;
  pen.lineWidth = 2;
  pen.setLineDash([10, 6]);
  if (scene.home !== null && scene.radius !== null) {
    const [x, y] = view.toScreen(scene.home);
    pen.beginPath();
    pen.arc(x, y, scene.radius * view.scale, 0, TURN);
    pen.stroke();
    if (scene.radius * view.scale > 40) {
      label(pen, `${word('radius')} ${length(scene.radius)}`, x,
        y - scene.radius * view.scale - 7, inks.limit, inks.paper, 'center');
    }
  }
  pen.setLineDash([]);
}

/** Every leg, also by heading, with the 95 % ellipse at each turn.
 * @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function stillWater(pen, view, { still }, inks) {
  if (!still) return;
  pen.strokeStyle = inks.plan;
  pen.lineWidth = 1.25;
  pen.setLineDash([4, 4]);
  stroke(pen, view, still.line);
  pen.globalAlpha = 0.6;
  pen.setLineDash([2, 3]);
  for (const { at, around } of still.turns) {
    const ring = ellipse(at, ...around);
    stroke(pen, view, [...ring, ...ring.slice(0, 1)]);
  }
  pen.globalAlpha = 1;
  pen.setLineDash([4, 4]);
  const y = view.height - 46;
  if (still.line.length) {
    pen.beginPath();
    pen.moveTo(14, y);
    pen.lineTo(44, y);
    pen.stroke();
  }
  pen.setLineDash([]);
  const says = still.isFlown ? word('still_flown')
    : still.problem ? word('still_none', still.problem) : word('still_water');
  const lines = broken(says, Math.max(12, Math.floor((view.width - 140) / 8)));
  lines.forEach((line, i) => label(pen, line, still.line.length ? 50 : 14, y + 4 - 16 * (lines.length - 1 - i),
    inks.plan, inks.paper));
}

/** Break a text into lines of ``room`` characters. @param {string} text @param {number} room */
export function broken(text, room) {
  /** @type {string[]} */
  const lines = [];
  for (const part of text.split(' ')) {
    const last = lines.at(-1);
    if (last !== undefined && last.length + part.length < room) lines[lines.length - 1] = `${last} ${part}`;
    else lines.push(part);
  }
  return lines;
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function plan(pen, view, scene, inks) {
  const isActive = (/** @type {Route} */ route) => route.name === scene.leg;
  /** @type {Set<string>} */
  const taken = new Set();
  const seen = scene.routes.filter((route) => isActive(route) || isApart(view, route.points, taken));
  for (const route of seen.sort((a, b) => Number(isActive(a)) - Number(isActive(b)))) {
    pen.strokeStyle = isActive(route) ? inks.target : inks.plan;
    pen.lineWidth = isActive(route) ? 3.5 : 2;
    pen.setLineDash(isActive(route) ? [] : [7, 5]);
    stroke(pen, view, route.points);
    pen.setLineDash([]);
    for (const point of route.points.slice(1)) corner(pen, view, point, isActive(route), inks);
  }
  routeNames(pen, view, { ...scene, routes: seen }, inks);
}

/** In sight, and distinguishable from those before. @param {View} view @param {Pair[]} points m
 * @param {Set<string>} taken cells */
function isApart(view, points, taken) {
  const [west, north, east, south] = points.reduce(([w, n, e, s], point) => {
    const [x, y] = view.toScreen(point);
    return [Math.min(w, x), Math.min(n, y), Math.max(e, x), Math.max(s, y)];
  }, [Infinity, Infinity, -Infinity, -Infinity]);
  const isSeen = east > 0 && west < view.width && south > 0 && north < view.height;
  const isLarge = Math.max(east - west, south - north) > CELL_PX;
  return isSeen && (isLarge || isFree(view, [east, south], taken, CELL_PX));
}

/** Of two names that would overlap, the later one is left out. @param {Pen} pen @param {View} view
 * @param {Scene} scene @param {Inks} inks */
function routeNames(pen, view, scene, inks) {
  /** @type {Pair[]} */
  const taken = [];
  for (const route of scene.routes) {
    const last = route.points.at(-1);
    if (last === undefined) continue;
    const [x, y] = view.toScreen(last);
    if (taken.some(([a, b]) => Math.abs(a - x) < 90 && Math.abs(b - y) < 16)) continue;
    taken.push([x, y]);
    const leaf = route.name.split('/').at(-1) ?? '';
    label(pen, leaf.length > 24 ? `${leaf.slice(0, 23)}…` : leaf, x + 9, y - 7,
      route.name === scene.leg ? inks.target : inks.plan, inks.paper);
  }
}

/** @param {Pen} pen @param {View} view @param {Pair} point @param {boolean} isActive
 * @param {Inks} inks */
function corner(pen, view, point, isActive, inks) {
  const [x, y] = view.toScreen(point);
  pen.fillStyle = isActive ? inks.target : inks.plan;
  pen.beginPath();
  pen.arc(x, y, isActive ? 4 : 3, 0, TURN);
  pen.fill();
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function homeMark(pen, view, scene, inks) {
  if (scene.home === null) return;
  const [x, y] = view.toScreen(scene.home);
  pen.strokeStyle = inks.ink;
  pen.fillStyle = inks.paper;
  pen.lineWidth = 2.5;
  pen.beginPath();
  pen.moveTo(x - 10, y);
  pen.lineTo(x, y - 10);
  pen.lineTo(x + 10, y);
  pen.moveTo(x - 7, y - 2);
  pen.lineTo(x - 7, y + 9);
  pen.lineTo(x + 7, y + 9);
  pen.lineTo(x + 7, y - 2);
  pen.stroke();
  label(pen, word('home'), x + 14, y + 13, inks.ink, inks.paper);
}

/** The smoothed track, and another dive's. @param {Pen} pen @param {View} view
 * @param {Scene} scene @param {Inks} inks */
function besideLines(pen, view, scene, inks) {
  const { now = null, other = null } = scene.beside ?? {};
  if (now) besideLine(pen, view, now, inks.vehicle, inks.paper, -10);
  if (other) besideLine(pen, view, other, inks.target, inks.paper, 18, [8, 5]);
}

/** @param {Pen} pen @param {View} view @param {Beside} beside @param {string} ink
 * @param {string} back @param {number} down px, of its name @param {number[]} [dashes] */
function besideLine(pen, view, { name, line, at }, ink, back, down, dashes = []) {
  pen.strokeStyle = ink;
  pen.lineWidth = 2;
  pen.setLineDash(dashes);
  stroke(pen, view, line);
  pen.setLineDash([]);
  if (at === null) return;
  const [x, y] = view.toScreen(at);
  pen.beginPath();
  pen.arc(x, y, 6, 0, TURN);
  pen.stroke();
  label(pen, name, x + 10, y + down, ink, back);
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function trackLine(pen, view, scene, inks) {
  pen.strokeStyle = inks.track;
  pen.lineWidth = 2.5;
  stroke(pen, view, scene.track);
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function targetMark(pen, view, scene, inks) {
  if (scene.target === null) return;
  const [x, y] = view.toScreen(scene.target);
  pen.strokeStyle = inks.target;
  pen.lineWidth = 2.5;
  pen.beginPath();
  pen.arc(x, y, 11, 0, TURN);
  for (const [a, b] of CROSS) {
    pen.moveTo(x + a * 7, y + b * 7);
    pen.lineTo(x + a * 16, y + b * 16);
  }
  pen.stroke();
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function uncertainty(pen, view, scene, inks) {
  const around = scene.here?.ellipse;
  if (!scene.here || !around) return;
  pen.beginPath();
  for (const point of ellipse(scene.here.at, ...around)) pen.lineTo(...view.toScreen(point));
  pen.closePath();
  pen.globalAlpha = 0.1;
  pen.fillStyle = scene.here.isOld ? inks.old : inks.vehicle;
  pen.fill();
  pen.globalAlpha = 1;
  pen.strokeStyle = pen.fillStyle;
  pen.lineWidth = 1.5;
  pen.stroke();
}

/** The other vehicles, small and with their names. @param {Pen} pen
 * @param {View} view @param {Scene} scene @param {Inks} inks */
function others(pen, view, scene, inks) {
  for (const { name, at, isOld } of scene.others) {
    const [x, y] = view.toScreen(at);
    pen.strokeStyle = isOld ? inks.old : inks.ink;
    pen.lineWidth = 2;
    pen.strokeRect(x - 6, y - 6, 12, 12);
    label(pen, name, x + 11, y - 9, isOld ? inks.old : inks.ink, inks.paper);
  }
}

/** @param {Pen} pen @param {View} view @param {Scene} scene @param {Inks} inks */
function vehicle(pen, view, scene, inks) {
  if (scene.here === null) return;
  const { at, heading, isOld } = scene.here;
  const [x, y] = view.toScreen(at);
  pen.save();
  pen.translate(x, y);
  pen.beginPath();
  if (heading === null) pen.arc(0, 0, 9, 0, TURN);
  else {
    pen.rotate((heading * Math.PI) / 180);
    for (const [a, b] of HULL) pen.lineTo(a, b);
    pen.closePath();
  }
  pen.fillStyle = isOld ? inks.paper : inks.vehicle;
  pen.strokeStyle = isOld ? inks.old : inks.paper;
  pen.lineWidth = isOld ? 2.5 : 1.5;
  pen.fill();
  pen.stroke();
  pen.restore();
}

/** @param {Pen} pen @param {View} view @param {Scene} _ @param {Inks} inks */
function scaleBar(pen, view, _, inks) {
  const m = roundUp(70 / view.scale);
  const [x, y, px] = [14, view.height - 16, m * view.scale];
  pen.strokeStyle = inks.ink;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y - 6);
  pen.lineTo(x, y);
  pen.lineTo(x + px, y);
  pen.lineTo(x + px, y - 6);
  pen.stroke();
  label(pen, length(m).replace('.0 ', ' '), x + px / 2, y - 8, inks.ink, inks.paper, 'center');
}

/** @param {Pen} pen @param {View} view @param {Scene} _ @param {Inks} inks */
function northArrow(pen, view, _, inks) {
  const [x, y] = [view.width - 86, view.width > NARROW ? 40 : 92]; // beside the buttons
  pen.fillStyle = inks.ink;
  pen.beginPath();
  pen.moveTo(x, y - 22);
  pen.lineTo(x + 8, y + 6);
  pen.lineTo(x, y);
  pen.lineTo(x - 8, y + 6);
  pen.closePath();
  pen.fill();
  label(pen, 'N', x, y + 22, inks.ink, inks.paper, 'center');
}

/** @param {Pen} pen @param {View} view @param {Pair[]} points */
function stroke(pen, view, points) {
  pen.lineJoin = 'round';
  pen.beginPath();
  for (const point of points) pen.lineTo(...view.toScreen(point));
  pen.stroke();
}

/** @param {Pen} pen @param {number} px */
export function font(pen, px, weight = 500) {
  pen.font = `${weight} ${px}px ui-sans-serif, system-ui, "Noto Sans CJK SC", sans-serif`;
}

/** Text with a rim in the paper's colour, so that it stays readable over lines. @param {Pen} pen
 * @param {string} text @param {number} x @param {number} y px @param {string} ink
 * @param {string} rim @param {CanvasTextAlign} [align] */
function label(pen, text, x, y, ink, rim, align = 'left') {
  font(pen, 13, 600);
  pen.textAlign = align;
  pen.lineJoin = 'round';
  pen.strokeStyle = rim;
  pen.lineWidth = 4;
  pen.strokeText(text, x, y);
  pen.fillStyle = ink;
  pen.fillText(text, x, y);
}
