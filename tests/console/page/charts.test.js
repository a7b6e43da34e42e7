import assert from 'node:assert/strict';
import test from 'node:test';

import { Charts } from '../../../mission/console/page/charts.js';
import { Frame } from '../../../mission/console/page/geo.js';
import { blend, cell, matrix, share } from '../../../mission/console/page/pictures.js';
import { Shapes, isInside } from '../../../mission/console/page/shapes.js';
import { Tiles, cornerOf, tileAt, zoomFor } from '../../../mission/console/page/tiles.js';
import { View } from '../../../mission/console/page/view.js';

const near = (a, b, within) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test('a tile lies between its corners, and a place within its tile', () => {
  assert.deepEqual(cornerOf(0, 0, 0).map((v) => v.toFixed(4)), ['85.0511', '-180.0000']);
  const [x, y] = tileAt(14, 60.1699, 24.9384); // Helsinki
  assert.deepEqual([Math.floor(x), Math.floor(y)], [9326, 4742]);
  const [lat, lon] = cornerOf(14, x, y);
  near(lat, 60.1699, 1e-9);
  near(lon, 24.9384, 1e-9);
});

test('from zoom 10 on a tile that is placed by its corners is less than a fifth of its pixel off', () => {
  for (const [z, lat] of [[10, 45], [10, 70], [12, 45], [14, 60]]) {
    const y = Math.floor(tileAt(z, lat, 0)[1]);
    const [north, middle, south] = [y, y + 0.5, y + 1].map((row) => cornerOf(z, 0, row)[0]);
    const pixel = (north - south) / 256;
    assert.ok(Math.abs((north + south) / 2 - middle) < 0.2 * pixel, `${z} ${lat}`);
    if (z === 12) near(Math.abs((north + south) / 2 - middle) * 111320, 0.9, 0.1);
  }
});

test('the zoom is the one whose pixels are closest to those of the screen', () => {
  assert.equal(zoomFor(1 / 156543.03, 0, 0, 20), 0);
  assert.equal(zoomFor(1, 60, 0, 20), 16);
  assert.equal(zoomFor(1, 60, 0, 12), 12);
  assert.equal(zoomFor(1e-6, 60, 5, 12), 5);
});

test('however far the chart is drawn out, only so many tiles are asked for', async () => {
  const asked = [];
  const tiles = new Tiles({ least: 12, greatest: 16 }, async (...tile) => {
    asked.push(tile);
    return null;
  }, () => {});
  const view = new View();
  Object.assign(view, { width: 1400, height: 900, scale: 1e-4 });
  for (let i = 0; i < 100; i += 1) {
    tiles.draw({ drawImage() {} }, view, new Frame(60, 25));
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.equal(new Set(asked.map(String)).size, asked.length);
  assert.ok(asked.length <= 150, `${asked.length}`);
});

test('a tile that is on its way is drawn from a larger one that is there', async () => {
  const whole = { width: 256, height: 256 };
  const tiles = new Tiles({ least: 0, greatest: 1 }, async (z) => (z === 0 ? whole : null), () => {});
  const [view, frame] = [new View(), new Frame(0, 0)];
  const drawn = [];
  const pen = { drawImage: (picture, ...where) => drawn.push(where.slice(0, 4)) };
  Object.assign(view, { width: 256, height: 256, scale: 1 / 156543 });
  tiles.draw(pen, view, frame);
  await new Promise((resolve) => setImmediate(resolve));
  view.scale *= 2;
  tiles.draw(pen, view, frame);
  assert.deepEqual(drawn.map(String).sort(), ['0,0,128,128', '0,128,128,128', '128,0,128,128', '128,128,128,128']);
});

test('the pixels of a picture come to the places of its corners', () => {
  const place = (lat, lon) => [10 * lon, -100 * lat];
  const [a, b, c, d, e, f] = matrix([24, 0.1, 0.01, 60, 0.02, -0.05], 40, 20, place);
  const at = (x, y) => [a * x + c * y + e, b * x + d * y + f];
  for (const [x, y] of [[0, 0], [40, 0], [0, 20], [40, 20]]) {
    const wanted = place(60 + 0.02 * x - 0.05 * y, 24 + 0.1 * x + 0.01 * y);
    at(x, y).forEach((value, i) => near(value, wanted[i], 1e-9));
  }
});

test('the depth under the pointer is that of its cell, and none beside the grid', () => {
  const about = { columns: 2, rows: 2, bounds: [24, 60, 25, 61] };
  const depths = Float32Array.from([1, 2, 3, NaN]);
  assert.equal(cell(depths, about, 60.9, 24.1), 1);
  assert.equal(cell(depths, about, 60.9, 24.9), 2);
  assert.equal(cell(depths, about, 60.1, 24.1), 3);
  assert.equal(cell(depths, about, 60.1, 24.9), null);
  assert.equal(cell(depths, about, 59.9, 24.1), null);
  assert.equal(cell(depths, about, 60.5, 25.1), null);
});

test('the shallows have most of the colours, and land none of them', () => {
  assert.deepEqual([0, 25, 100, 200].map((depth) => share(depth, -5, 100)), [0, 0.5, 1, 1]);
  assert.equal(share(7, 7, 7), 0);
  assert.deepEqual(blend('#000000', '#ff8000', 0.5), [128, 64, 0]);
});

const shape = (form, at, depth, deeper = null) => ({ form, at, name: '', depth, deeper });

test('the depth of a sounding that is close comes before that of the area around it', () => {
  const [frame, view] = [new Frame(60, 25), new View()];
  const ring = [[24.9, 59.9], [25.1, 59.9], [25.1, 60.1], [24.9, 60.1]];
  const shapes = new Shapes([shape('area', [ring], 5, 10), shape('point', [[[25, 60]]], 7.25)]);
  assert.equal(shapes.depthAt([10, 0], view, frame), '7.3 m');
  assert.equal(shapes.depthAt([30, 0], view, frame), '5.0 – 10 m');
  assert.equal(shapes.depthAt([30_000, 0], view, frame), '');
  assert.deepEqual([shapes.least, shapes.greatest], [5, 7.25]);
});

test('what is in the hole of an area is not in it', () => {
  const square = (r) => [[-r, -r], [r, -r], [r, r], [-r, r]];
  assert.equal(isInside([0, 0], [square(10)]), true);
  assert.equal(isInside([0, 0], [square(10), square(5)]), false);
  assert.equal(isInside([7, 0], [square(10), square(5)]), true);
  assert.equal(isInside([11, 0], [square(10), square(5)]), false);
});

test('a coast that goes round the world has no line across it', () => {
  const frame = new Frame(30, 120);
  const along = frame.alongOf([[-70, 10], [-62, 10], [-58, 10], [-50, 10]]);
  for (const [i, [east]] of along.slice(1).entries()) {
    const jump = Math.abs(east - along[i][0]);
    assert.ok(jump < 1.2e6, `${jump}`);
  }
  assert.deepEqual(frame.alongOf([[121, 31]])[0], frame.toLocal(31, 121));
});

test('what may lie far off is drawn only where that is little on the screen', () => {
  const charts = Object.assign(Object.create(Charts.prototype), { _frame: null });
  let drawn = 0;
  const rough = { on: true, opacity: 1, off_m: 10_000, bounds: [-180, -85, 180, 84],
    drawn: { draw: () => { drawn += 1; } } };
  charts.layers = [rough];
  const pen = { save() {}, restore() {} };
  globalThis.document = {};
  globalThis.getComputedStyle = () => ({ getPropertyValue: () => '' });
  for (const scale of [1, 0.01, 0.001]) charts.draw(pen, { scale }, new Frame(0, 0));
  assert.equal(drawn, 1);
  assert.equal(charts.frame(), null);
  assert.deepEqual(charts.corners(new Frame(0, 0)), []);
});
