// @ts-check
/**
 * Positions on the earth (WGS 84) and in metres on a plane that touches it at an origin.
 *
 * Up to about 20 km from the origin the plane is accurate to 0.1 %. Latitude and longitude in
 * degrees, east and north in metres, bearings in degrees clockwise from north.
 */

/** @typedef {[number, number]} Pair */

const MAJOR = 6378137.0; // m
const E2 = 6.69437999014e-3; // first eccentricity squared
const DEG = Math.PI / 180;

export class Frame {
  /** @param {number} lat @param {number} lon the origin, deg */
  constructor(lat, lon) {
    this.lat = lat;
    this.lon = lon;
    const sin = Math.sin(lat * DEG);
    const w = Math.sqrt(1 - E2 * sin * sin);
    this._north = ((MAJOR * (1 - E2)) / (w * w * w)) * DEG; // m per degree
    this._east = (MAJOR / w) * Math.cos(lat * DEG) * DEG;
  }

  /** @param {number} lat @param {number} lon deg @returns {Pair} east, north, m */
  toLocal(lat, lon) {
    return [turned(lon - this.lon) * this._east, (lat - this.lat) * this._north];
  }

  /** A line that stays continuous across the date line. @param {readonly Pair[]} line
   * longitude and latitude @returns {Pair[]} east, north, m */
  alongOf(line) {
    let last = this.lon;
    let turn = 0; // deg
    return line.map(([lon, lat], i) => {
      turn = i === 0 ? turned(lon - this.lon) : turn + turned(lon - last);
      last = lon;
      return [turn * this._east, (lat - this.lat) * this._north];
    });
  }

  /** @param {number} east @param {number} north m @returns {Pair} latitude, longitude, deg */
  toEarth(east, north) {
    return [this.lat + north / this._north, turned(this.lon + east / this._east)];
  }
}

/** An angle from -180 to 180. @param {number} deg */
export function turned(deg) {
  return deg - 360 * Math.round(deg / 360);
}

/** Range and bearing from one point to another. @param {Pair} from @param {Pair} to m
 * @returns {{range: number, bearing: number}} m, deg from 0 to 360 */
export function between(from, to) {
  const [east, north] = [to[0] - from[0], to[1] - from[1]];
  return { range: Math.hypot(east, north), bearing: (Math.atan2(east, north) / DEG + 360) % 360 };
}

/** The corners of an ellipse. @param {Pair} at its middle, m @param {number} long half axis, m
 * @param {number} short half axis, m @param {number} bearing of the long one, deg
 * @returns {Pair[]} */
export function ellipse(at, long, short, bearing, corners = 48) {
  const [sin, cos] = [Math.sin(bearing * DEG), Math.cos(bearing * DEG)];
  return Array.from({ length: corners }, (_, i) => {
    const a = (2 * Math.PI * i) / corners;
    const [along, across] = [long * Math.cos(a), short * Math.sin(a)];
    return [at[0] + along * sin + across * cos, at[1] + along * cos - across * sin];
  });
}
