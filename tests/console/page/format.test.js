import assert from 'node:assert/strict';
import test from 'node:test';

import { ago, bearing, clock, lasting, length, number, place } from '../../../mission/console/page/format.js';

test('an age has the digits that matter', () => {
  assert.deepEqual([0, 0.44, 9.94, 9.96, 119.4, 120, 7100, 7200].map(lasting),
    ['0.0 s', '0.4 s', '9.9 s', '10 s', '119 s', '2 min', '118 min', '2.0 h']);
  assert.equal(lasting(-3), '0.0 s');
  assert.equal(ago(null), 'not yet');
});

test('what is not known is a dash, never a zero', () => {
  for (const nothing of [null, undefined, NaN, Infinity]) assert.equal(number(nothing), '—');
  assert.equal(bearing(null), '—');
  assert.equal(number(0), '0.0');
});

test('a number that rounds to zero has no sign', () => {
  assert.equal(number(-0.04), '0.0');
  assert.equal(number(-0.06), '−0.1');
});

test('a heading has three figures, and north is 000', () => {
  assert.deepEqual([0, 5, 359.4, 359.6, -90, 360, -450].map(bearing),
    ['000°', '005°', '359°', '000°', '270°', '000°', '270°']);
});

test('a place has degrees and minutes, and 60 minutes are a degree', () => {
  assert.equal(place(30.2874, -120.1), '30°\u202f17.244′N 120°\u202f06.000′W');
  assert.equal(place(-0.99999999, 9), '01°\u202f00.000′S 009°\u202f00.000′E');
});

test('times and lengths are short', () => {
  assert.deepEqual([5, 65, 3600, 3725].map(clock), ['0:05', '1:05', '1:00:00', '1:02:05']);
  assert.deepEqual([3.14, 31.4, 1999, 2345, 23_450, 100_000].map(length),
    ['3.1 m', '31 m', '1999 m', '2.35 km', '23.4 km', '100 km']);
});
