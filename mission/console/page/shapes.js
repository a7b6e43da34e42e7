// @ts-check
/**
 * Charts of shapes: the user's own points, lines and areas, with their depths.
 */

import { length } from './format.js';
import { font } from './layers.js';

/** @typedef {import('./geo.js').Pair} Pair
 * @typedef {import('./geo.js').Frame} Frame
 * @typedef {import('./view.js').View} View
 * @typedef {import('./charts.js').Inks} Inks
 * @typedef {CanvasRenderingContext2D} Pen
 * @typedef {{form: 'point' | 'line' | 'area', at: Pair[][], name: string, depth: number | null,
 *   deeper: number | null}} Shape longitude and latitude; depths in m */

const DOT_PX = 3;
const NUMBERS = 400; // soundings shown as numbers; more are shown as dots only
const NEAR_PX = 24;

export class Shapes {
  /** @param {Shape[]} shapes */
  constructor(shapes) {
    this._shapes = shapes;
    /** @type {{frame: string, drawn: {shape: Shape, at: Pair[][]}[]}} */
    this._local = { frame: '', drawn: [] };
    const known = shapes.flatMap((s) => (s.depth === null ? [] : [s.depth]));
    this.least = known.reduce((a, b) => Math.min(a, b), Infinity);
    this.greatest = known.reduce((a, b) => Math.max(a, b), -Infinity);
  }

  /** @param {Frame} frame */
  _in(frame) {
    const of = `${frame.lat} ${frame.lon}`;
    if (this._local.frame !== of) {
      const drawn = this._shapes.map((shape) => ({ shape,
        at: shape.at.map((ring) => frame.alongOf(ring)) }));
      this._local = { frame: of, drawn };
    }
    return this._local.drawn;
  }

  /** Areas below lines below points. @param {Pen} pen @param {View} view @param {Frame} frame
   * @param {Inks} inks */
  draw(pen, view, frame, inks) {
    const drawn = this._in(frame);
    for (const { shape, at } of drawn) if (shape.form === 'area') this._area(pen, view, shape, at, inks);
    pen.strokeStyle = inks.shape;
    pen.lineWidth = 1.5;
    for (const { shape, at } of drawn) {
      if (shape.form !== 'line') continue;
      trace(pen, view, at);
      pen.stroke();
    }
    this._points(pen, view, drawn.filter(({ shape, at }) => shape.form === 'point'
      && isSeen(view, /** @type {Pair} */ (at[0]?.[0]))), inks);
    for (const { shape, at } of drawn) if (shape.form !== 'point') title(pen, view, shape, at, inks);
  }

  /** @param {Pen} pen @param {View} view @param {Shape} shape @param {Pair[][]} at
   * @param {Inks} inks */
  _area(pen, view, shape, at, inks) {
    trace(pen, view, at);
    pen.closePath();
    if (shape.depth !== null) {
      pen.fillStyle = inks.depth(shape.depth, this.least, this.greatest);
      pen.fill('evenodd');
    }
    pen.strokeStyle = inks.shape;
    pen.lineWidth = 1;
    pen.stroke();
  }

  /** @param {Pen} pen @param {View} view @param {{shape: Shape, at: Pair[][]}[]} seen
   * @param {Inks} inks */
  _points(pen, view, seen, inks) {
    font(pen, 12);
    pen.textAlign = 'center';
    pen.fillStyle = inks.shape;
    for (const { shape, at } of seen) {
      const [x, y] = view.toScreen(/** @type {Pair} */ (at[0]?.[0]));
      const text = `${shape.name} ${shape.depth?.toFixed(1) ?? ''}`.trim();
      if (text && seen.length <= NUMBERS) pen.fillText(text, x, y - 6);
      pen.fillRect(x - DOT_PX / 2, y - DOT_PX / 2, DOT_PX, DOT_PX);
    }
  }

  /** The depth in words, of the smallest depth area around it or the nearest sounding; else ''.
   * @param {Pair} at east, north @param {View} view @param {Frame} frame */
  depthAt(at, view, frame) {
    const near = { far: NEAR_PX / view.scale, says: '' };
    let area = '';
    for (const { shape, at: rings } of this._in(frame)) {
      if (shape.depth === null) continue;
      if (shape.form === 'area' && isInside(at, rings)) area = depths(shape);
      const [one] = rings[0] ?? [];
      if (shape.form !== 'point' || one === undefined) continue;
      const far = Math.hypot(one[0] - at[0], one[1] - at[1]);
      if (far < near.far) Object.assign(near, { far, says: depths(shape) });
    }
    return near.says || area;
  }
}

/** @param {Shape} shape */
function depths({ depth, deeper }) {
  if (depth === null) return '';
  return deeper === null ? length(depth) : `${depth.toFixed(1)} – ${length(deeper)}`;
}

/** By the even-odd rule, so that holes count. @param {Pair} point @param {Pair[][]} rings */
export function isInside([x, y], rings) {
  let inside = false;
  for (const ring of rings) {
    ring.forEach(([ax, ay], i) => {
      const [bx, by] = ring[(i + 1) % ring.length] ?? [ax, ay];
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
    });
  }
  return inside;
}

/** @param {View} view @param {Pair} at */
function isSeen(view, at) {
  const [x, y] = view.toScreen(at);
  return x > 0 && y > 0 && x < view.width && y < view.height;
}

/** @param {Pen} pen @param {View} view @param {Pair[][]} rings */
function trace(pen, view, rings) {
  pen.beginPath();
  for (const ring of rings) {
    ring.forEach((point, i) => {
      const [x, y] = view.toScreen(point);
      if (i === 0) pen.moveTo(x, y);
      else pen.lineTo(x, y);
    });
  }
}

/** @param {Pen} pen @param {View} view @param {Shape} shape @param {Pair[][]} at
 * @param {Inks} inks */
function title(pen, view, shape, at, inks) {
  const text = shape.name || (shape.form === 'line' && shape.depth !== null ? String(shape.depth) : '');
  const first = at[0]?.[0];
  if (!text || first === undefined || !isSeen(view, first)) return;
  font(pen, 12);
  pen.textAlign = 'left';
  pen.fillStyle = inks.shape;
  pen.fillText(text, ...view.toScreen(first));
}
