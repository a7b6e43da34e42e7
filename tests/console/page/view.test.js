import assert from 'node:assert/strict';
import test from 'node:test';

import { View, roundUp, ticks } from '../../../mission/console/page/view.js';

const view = () => Object.assign(new View(), { width: 400, height: 200, scale: 2, east: 10, north: 20 });

test('north is up and the middle of the screen is the middle of the view', () => {
  assert.deepEqual(view().toScreen([10, 20]), [200, 100]);
  assert.deepEqual(view().toScreen([10, 30]), [200, 80]);
  assert.deepEqual(view().toScreen([20, 20]), [220, 100]);
});

test('what is under the finger stays under it while it is drawn nearer', () => {
  const shown = view();
  const before = shown.toWorld([50, 30]);
  shown.zoom(3, [50, 30]);
  const after = shown.toWorld([50, 30]);
  assert.equal(shown.scale, 6);
  after.forEach((m, i) => assert.ok(Math.abs(m - before[i]) < 1e-9));
});

test('what is moved to the right shows what lies to the west', () => {
  const shown = view();
  shown.pan(20, 0);
  assert.equal(shown.east, 0);
  shown.pan(0, 20);
  assert.equal(shown.north, 30);
});

test('all that is to be seen is on the screen', () => {
  const shown = view();
  const points = [[-500, 0], [300, 900], [0, -50]];
  shown.fit(points, 20);
  for (const point of points) {
    const [x, y] = shown.toScreen(point);
    assert.ok(x >= 19.9 && x <= 380.1 && y >= 19.9 && y <= 180.1, `${x} ${y}`);
  }
});

test('what has been fitted is not outgrown, and what reaches beyond the screen is', () => {
  const shown = view();
  shown.fit([[-90, 0], [90, 0], [0, -90], [0, 90]]);
  assert.deepEqual([shown.isOutgrown(90), shown.isOutgrown(300), shown.isOutgrown(0)], [false, true, false]);
});

test('a single point is shown with some water around it', () => {
  const shown = view();
  shown.fit([[3, 4]]);
  assert.deepEqual([shown.east, shown.north], [3, 4]);
  assert.ok(shown.scale < 200);
});

test('a scale is a round length', () => {
  assert.deepEqual([0.7, 1, 1.1, 3, 51, 999, 1000].map(roundUp), [1, 1, 2, 5, 100, 1000, 1000]);
});

test('the lines of a grid are multiples of its step', () => {
  assert.deepEqual(ticks(-25, 25, 10), [-20, -10, 0, 10, 20]);
  assert.deepEqual(ticks(0.1, 0.4, 0.1).length, 4);
  assert.deepEqual(ticks(11, 19, 10), []);
});
