import assert from 'node:assert/strict';
import test from 'node:test';

import {
  EVENTS, PAST, ROWS, TRACK, Vehicle, age, freshness, isHung, isLive, pace, runsOut, silence, sinceWord, timeOf, update,
} from '../../../mission/console/page/state.js';

const SETUP = { id: '1', name: 'auv-1', to: 'tcp://vehicle:4000', source: 'monitor', under_water: false,
  speed: 1, checklist: [] };
const STALE = 6;

function row(t, values) {
  return [t, ...PAST.map((name) => values[name] ?? null)];
}

function heard(...frames) {
  const vehicle = new Vehicle({ ...SETUP });
  frames.forEach((frame, i) => update(vehicle, frame, 1000 + i));
  return vehicle;
}

test('a delta overwrites what it names and leaves the rest', () => {
  const vehicle = heard({ n: 1, t: 10, state: { depth: 2, heading: 90 }, events: ['a'] },
    { n: 2, t: 11, state: { depth: null }, events: ['b'], gap: 3 });
  assert.deepEqual(vehicle.state, { depth: null, heading: 90 });
  assert.deepEqual([vehicle.events, vehicle.told, vehicle.gap], [['a', 'b'], 2, 3]);
});

test('a snapshot forgets everything that was known before', () => {
  const vehicle = heard({ n: 1, t: 10, state: { depth: 2, report_at: 9 }, events: ['a'], track: [[9, 1, 2, 3]] },
    { n: 1, t: 0.5, state: { heading: 90 } });
  assert.deepEqual([vehicle.state, vehicle.events, vehicle.track, vehicle.strips, vehicle.known],
    [{ heading: 90 }, [], [], {}, {}]);
  assert.equal(vehicle.told, 0);
});

test('an age is what the vehicle says of it, and goes on by itself', () => {
  const vehicle = heard({ n: 1, t: 100, state: { report_at: 98.5 } });
  assert.equal(age(vehicle, 'report_at', 1000), 1.5);
  assert.equal(age(vehicle, 'report_at', 4000), 4.5);
  assert.equal(age(vehicle, 'fix_at', 4000), null);
});

test('a frame without news does not make a value younger', () => {
  const vehicle = heard({ n: 1, t: 100, state: { report_at: 98 } }, { n: 2, t: 130, state: { wall: 5 } });
  assert.equal(age(vehicle, 'report_at', 1001), 32);
});

test('a value is old after the seconds that it may be, and unknown when it is null', () => {
  const vehicle = heard({ n: 1, t: 100, state: { report_at: 95, depth: 3, heading: null } });
  const of = (name, now) => freshness(vehicle, vehicle.state[name], 'report_at', STALE, now);
  assert.equal(of('depth', 1000), 'fresh');
  assert.equal(of('depth', 2001), 'old');
  assert.equal(of('heading', 1000), 'unknown');
  assert.equal(of('speed', 1000), 'unknown');
});

test('nothing is fresh while the console hangs', () => {
  const vehicle = heard({ n: 1, t: 100, state: { report_at: 100, depth: 3 } });
  assert.equal(isHung(vehicle, 3000), false);
  assert.equal(isHung(vehicle, 3001), true);
  assert.equal(freshness(vehicle, 3, 'report_at', STALE, 3001), 'old');
});

test('nothing was heard before the first frame', () => {
  const vehicle = new Vehicle({ ...SETUP });
  assert.ok(isHung(vehicle, 0));
  assert.equal(silence(vehicle, 0), null);
  assert.equal(age(vehicle, 'report_at', 0), null);
});

test('silence goes on while nothing comes', () => {
  const vehicle = heard({ n: 1, t: 100, state: { silence: 4 } });
  assert.equal(silence(vehicle, 2500), 5.5);
});

test('the last that was known of a value is kept with its time', () => {
  const vehicle = heard({ n: 1, t: 10, state: { depth: 7, report_at: 9 } },
    { n: 2, t: 12, state: { depth: null, report_at: 11 } });
  assert.deepEqual(vehicle.known.depth, [9, 7]);
});

test('a strip has each row once, by time, in whatever order and pieces they come', () => {
  const rows = [10, 20, 30, 40].map((t) => row(t, { battery: t / 10 }));
  const strip = [[10, 1], [20, 2], [30, 3], [40, 4]];
  for (const pieces of [[rows], [rows.slice(2), rows.slice(0, 2)], [[...rows].reverse()], [rows, rows],
    rows.map((one) => [one]), [[rows[3]], [rows[0]], rows]]) {
    const vehicle = heard({ n: 1, t: 50 }, ...pieces.map((past) => ({ n: 2, t: 50, past })));
    assert.deepEqual(vehicle.strips.battery, strip);
  }
});

test('a page that joins late has every strip of before', () => {
  const values = { depth: 9, altitude: 3, heading: 90, pitch: 1, roll: 2, battery: 12, uncertainty: 4,
    to_depth: 20, to_radius: 300, to_time: 10, to_voltage: 2 };
  const vehicle = heard({ n: 1, t: 50, state: { depth: 9, report_at: 50 }, past: [row(10, values)] });
  for (const [name, value] of Object.entries({ ...values, floor: 12 })) {
    assert.deepEqual(vehicle.strips[name], [[10, value]], name);
  }
});

test('the floor is known where depth and altitude are', () => {
  const vehicle = heard({ n: 1, t: 11, past: [row(9, { depth: 7, altitude: 3 }), row(11, { depth: 7 })] });
  assert.deepEqual(vehicle.strips.floor, [[9, 10], [11, null]]);
});

test('a page that is open for days holds no more than its bounds', () => {
  const vehicle = heard({ n: 1, t: 0, state: {} });
  for (let t = 1; t < 3 * TRACK; t += 1) {
    update(vehicle, { n: 2, t, past: [row(t, { depth: 1 })], events: [`${t}`], track: [[t, 0, 0, 1]] }, t);
  }
  assert.equal(vehicle.track.length, TRACK);
  assert.equal(vehicle.events.length, EVENTS);
  assert.ok(vehicle.past.length <= ROWS);
  assert.equal(vehicle.strips.depth.length, vehicle.past.length);
  assert.equal(vehicle.strips.depth[0][0], 1);
  assert.equal(vehicle.strips.depth.at(-1)[0], 3 * TRACK - 1);
});

test('a recording stands still until it is played, and then runs as fast as it is told', () => {
  const vehicle = heard({ n: 1, t: 100, state: { review: { playing: false, speed: 10 } } });
  vehicle.setup.source = 'recording';
  assert.equal(pace(vehicle), 0);
  assert.equal(timeOf(vehicle, 5000), 100);
  update(vehicle, { n: 2, t: 100, state: { review: { playing: true, speed: 10 } } }, 5000);
  assert.equal(timeOf(vehicle, 6000), 110);
  assert.equal(isLive(vehicle), false);
});

test('a word of the vehicle is an answer, too', () => {
  const lines = (orders, commands) => heard({ n: 1, t: 1, state: { silence: 3, lines: { orders, commands } } });
  assert.equal(sinceWord(lines(0.5, null), 2000), 1.5);
  assert.equal(sinceWord(lines(null, 0.25), 2000), 1.25);
  assert.equal(sinceWord(lines(null, null), 2000), 4);
  assert.equal(sinceWord(lines(8, 9), 2000), 4);
  assert.equal(sinceWord(heard({ n: 1, t: 1, state: { silence: null } }), 0), null);
});

test('a margin that falls says when it is used up, and one that does not says nothing', () => {
  const falling = Array.from({ length: 61 }, (_, t) => [t, 100 - t]);
  assert.equal(runsOut(falling), 40);
  assert.equal(runsOut(falling.map(([t]) => [t, 5])), null);
  assert.equal(runsOut(falling.slice(0, 10)), null);
  assert.equal(runsOut([...falling, [61, null]]), null);
  assert.equal(runsOut([]), null);
});

test('a margin that falls no more is not said to be used up soon', () => {
  const dived = Array.from({ length: 61 }, (_, t) => [t, 100 - Math.min(t, 40)]);
  assert.equal(runsOut(dived), null);
  const begun = Array.from({ length: 61 }, (_, t) => [t, 100 - Math.max(0, t - 30)]);
  assert.equal(runsOut(begun), 140);
  const seldom = [[0, 100], [40, 60], [80, 20]];
  assert.equal(runsOut(seldom), 20);
});
