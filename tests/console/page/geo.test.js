import assert from 'node:assert/strict';
import test from 'node:test';

import { Frame, between, ellipse, turned } from '../../../mission/console/page/geo.js';

const close = (a, b, within) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test('a place two kilometres away is where the engine has it, to half a metre', () => {
  const frame = new Frame(36.05, 120.3); // from mission.navigation.geodesy.LocalFrame
  for (const [north, east, lat, lon] of [
    [2000, 1500, 36.06802334224061, 120.31665072053698],
    [-500, 800, 36.045493538317736, 120.30887785337619],
  ]) {
    const [e, n] = frame.toLocal(lat, lon);
    close(e, east, 0.5);
    close(n, north, 0.5);
  }
});

test('there and back again is the same place', () => {
  const frame = new Frame(-33.9, 18.4);
  const [lat, lon] = frame.toEarth(...frame.toLocal(-33.91, 18.42));
  close(lat, -33.91, 1e-12);
  close(lon, 18.42, 1e-12);
});

test('the date line is no edge of the world', () => {
  const [east] = new Frame(0, 179.999).toLocal(0, -179.999);
  close(east, 0.002 * 111319.49, 0.1);
  assert.equal(turned(361), 1);
});

test('bearings count clockwise from north', () => {
  assert.deepEqual(between([0, 0], [0, 10]), { range: 10, bearing: 0 });
  assert.deepEqual(between([0, 0], [10, 0]), { range: 10, bearing: 90 });
  assert.deepEqual(between([0, 0], [-10, 0]), { range: 10, bearing: 270 });
});

test('the long axis of an ellipse lies along its bearing', () => {
  const [first] = ellipse([5, 5], 20, 10, 90, 4);
  close(first[0], 25, 1e-9);
  close(first[1], 5, 1e-9);
  const [, side] = ellipse([0, 0], 20, 10, 0, 4);
  close(Math.abs(side[0]), 10, 1e-9);
  close(side[1], 0, 1e-9);
});
