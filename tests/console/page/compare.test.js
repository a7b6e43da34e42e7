import assert from 'node:assert/strict';
import test from 'node:test';

import { ALONE, apart, besides, lastAt, timeThere } from '../../../mission/console/page/compare.js';
import { Frame } from '../../../mission/console/page/geo.js';
import { Vehicle, update } from '../../../mission/console/page/state.js';

const dive = (begin, wall, then = [], now = []) => ({ begin, wall, then, now, apart: null, problem: '' });

test('two dives are aligned by the start of their missions or by the clock', () => {
  const [own, other] = [dive(100, 5000), dive(30, 5600)];
  assert.equal(timeThere('start', 110, own, other), 40);
  assert.equal(timeThere('clock', 610, own, other), 10);
  assert.equal(timeThere('start', 110, dive(null, 0), other), 140);
});

test('where a dive was is where it was known last, and nowhere before its begin and behind its end', () => {
  const points = [[1, 60, 25], [2, 61, 25], [9, 62, 25]];
  assert.deepEqual([0.9, 1, 1.9, 2, 8.9, 9, 9.9, 10.1].map((t) => lastAt(points, t)?.[1] ?? null),
    [null, 60, 60, 61, 61, 62, 62, null]);
  assert.equal(lastAt([], 1), null);
});

test('the distance of two places is in metres', () => {
  assert.ok(Math.abs(apart([0, 60, 25], [0, 60.001, 25]) - 111.3) < 0.1);
  assert.ok(Math.abs(apart([0, 60, 25], [0, 60, 25.001]) - 55.7) < 0.1);
});

const station = (id, hindsight) => {
  const vehicle = new Vehicle({ id, name: `dive ${id}`, to: '', source: 'recording', speed: 1, silent_s: 5 });
  update(vehicle, { n: 1, t: 110, state: { review: { playing: false } } }, 0);
  return { vehicle, hindsight };
};

test('the other dive stands where it was at its own time, and the smoothed track is drawn when asked for', () => {
  const own = station('1', dive(100, 0, [[110, 60, 25]], [[110, 60.001, 25]]));
  const other = station('2', dive(30, 0, [[39, 60, 25.001], [41, 60, 25.002]]));
  const page = { chosen: own, stations: [own, other], compared: { ...ALONE, other: '2' } };
  const frame = new Frame(60, 25);
  const found = besides(page, frame, 0);
  assert.equal(found.now, null);
  assert.deepEqual([found.other.name, found.other.line.length], ['dive 2', 2]);
  assert.deepEqual(found.other.at, frame.toLocal(60, 25.001));
  Object.assign(page.compared, { smoothed: true, other: '1' });
  const alone = besides(page, frame, 0);
  assert.equal(alone.other, null); // not with itself
  assert.deepEqual(alone.now.at, frame.toLocal(60.001, 25));
  assert.deepEqual(besides(page, null, 0), { now: null, other: null });
});
