// @ts-check
/**
 * The part of the chart that is on the screen: metres to pixels and back, north up.
 *
 * East and north in m, x and y in CSS pixels from the upper left corner.
 */

/** @typedef {import('./geo.js').Pair} Pair */

const FINEST = 200; // px a metre
const COARSEST = 1e-4;
const ALONE = 60; // m around a single point

export class View {
  east = 0;
  north = 0; // m, in the middle of the screen
  scale = 1; // px a metre
  width = 1;
  height = 1; // px

  /** @param {Pair} point m @returns {Pair} px */
  toScreen([east, north]) {
    return [
      this.width / 2 + (east - this.east) * this.scale,
      this.height / 2 - (north - this.north) * this.scale,
    ];
  }

  /** @param {Pair} point px @returns {Pair} m */
  toWorld([x, y]) {
    return [
      this.east + (x - this.width / 2) / this.scale,
      this.north - (y - this.height / 2) / this.scale,
    ];
  }

  /** @param {number} x @param {number} y px by which the chart moves */
  pan(x, y) {
    this.east -= x / this.scale;
    this.north += y / this.scale;
  }

  /** Zoom in (factor above 1) or out; the point under ``at`` stays. @param {number} factor
   * @param {Pair} [at] px */
  zoom(factor, at = [this.width / 2, this.height / 2]) {
    const [east, north] = this.toWorld(at);
    this.scale = Math.min(FINEST, Math.max(COARSEST, this.scale * factor));
    const [e, n] = this.toWorld(at);
    this.east += east - e;
    this.north += north - n;
  }

  /** Does this radius around the middle exceed the screen? @param {number} radius m */
  isOutgrown(radius) {
    return radius * this.scale > Math.min(this.width, this.height) / 2;
  }

  /** @param {Pair} point m */
  centre([east, north]) {
    this.east = east;
    this.north = north;
  }

  /** Move the origin without moving the picture. @param {Pair} by m, its new position */
  shift([east, north]) {
    this.centre([this.east - east, this.north - north]);
  }

  /** Fit all points on the screen. @param {Pair[]} points m @param {number} [margin] px */
  fit(points, margin = 56) {
    if (points.length === 0) return;
    const [west, east] = extent(points.map((p) => p[0]));
    const [south, north] = extent(points.map((p) => p[1]));
    const room = (/** @type {number} */ px) => Math.max(px - 2 * margin, px / 4);
    const wide = room(this.width) / Math.max(east - west, ALONE);
    const high = room(this.height) / Math.max(north - south, ALONE);
    this.scale = Math.min(FINEST, Math.max(COARSEST, Math.min(wide, high)));
    this.centre([(west + east) / 2, (south + north) / 2]);
  }
}

/** Minimum and maximum. @param {number[]} values @returns {Pair} */
export function extent(values) {
  return values.reduce((/** @type {Pair} */ [a, b], v) => [Math.min(a, v), Math.max(b, v)],
    [Infinity, -Infinity]);
}

/** The least round length (1, 2 or 5 times a power of ten) of ``least`` or more.
 * @param {number} least above 0 */
export function roundUp(least) {
  const ten = 10 ** Math.floor(Math.log10(least) + 1e-9);
  return ten * ([1, 2, 5].find((n) => n * ten >= least * (1 - 1e-9)) ?? 10);
}

/** The grid lines between two values. @param {number} from @param {number} to
 * @param {number} step @returns {number[]} */
export function ticks(from, to, step) {
  const first = Math.ceil(from / step - 1e-9);
  const count = Math.floor(to / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(0, Math.min(count, 1000)) }, (_, i) => (first + i) * step);
}

/** In sight, and in a free cell: only as many are drawn as can be distinguished.
 * @param {View} view @param {Pair} at px @param {Set<string>} taken cells @param {number} cell px */
export function isFree(view, [x, y], taken, cell) {
  if (x < -cell || y < -cell || x > view.width + cell || y > view.height + cell) return false;
  const name = `${Math.floor(x / cell)} ${Math.floor(y / cell)}`;
  if (taken.has(name)) return false;
  taken.add(name);
  return true;
}
