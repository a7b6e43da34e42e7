import assert from 'node:assert/strict';
import test from 'node:test';

import { resting, withoutMission } from '../../../mission/console/page/bar.js';
import { here, standingOfAll } from '../../../mission/console/page/alarms.js';
import { findings } from '../../../mission/console/page/seen.js';
import { broken } from '../../../mission/console/page/layers.js';
import { Frame } from '../../../mission/console/page/geo.js';
import { byDay, levelOf } from '../../../mission/console/page/journal.js';
import { level, unknown } from '../../../mission/console/page/margins.js';
import { Goal, eventNear } from '../../../mission/console/page/review.js';
import { frameOf, routesOf, sceneOf, stillOf } from '../../../mission/console/page/scene.js';
import { Vehicle, update } from '../../../mission/console/page/state.js';
import { Begun, progress } from '../../../mission/console/page/states.js';
import { bounds, gapOf, runs, turned } from '../../../mission/console/page/strips.js';
import { letter } from '../../../mission/console/page/urgent.js';

test('a margin is careful within a quarter of its limit, bad within a tenth, and beyond it', () => {
  assert.deepEqual([30, 7, 2, -1].map((left) => level(left, 30, 1).level), ['good', 'careful', 'bad', 'bad']);
  assert.equal(level(-1, 30, 1).share, 0);
  assert.equal(level(null, 30, 1).level, 'unknown');
  assert.equal(level(2, null, 1).level, 'good');
  assert.equal(level(0, null, 1).level, 'bad');
});

test('of a vehicle that was never heard neither its mission nor that it has none is known', () => {
  const vehicle = new Vehicle();
  assert.deepEqual([withoutMission(vehicle), unknown('to_time', vehicle.state)], ['not known', 'not known']);
  Object.assign(vehicle.state, { state: 'idle/empty', mission: '' });
  assert.deepEqual([withoutMission(vehicle), unknown('to_time', vehicle.state)], ['no mission', 'not under way']);
});

test('of a vehicle under way whose frames tell no begin it is not said that it is not', () => {
  const vehicle = new Vehicle({ id: '1', name: 'auv', to: 'x', source: 'frames', speed: 1, silent_s: 5 });
  vehicle.state['state'] = 'autonomous';
  assert.equal(resting(vehicle), '');
  vehicle.state['state'] = 'idle/ready';
  assert.equal(resting(vehicle), 'not under way');
});

test('a guard has come as far as its value from the leg\'s begin to the bound', () => {
  assert.deepEqual(progress(['depth >= 10 m', { depth: 4 }], { depth: 2 }), [{ text: 'depth 4.0', share: 0.25 }]);
  assert.equal(progress(['altitude < 1.5', { altitude: 6 }], { altitude: 10.5 })[0].share, 0.5);
  assert.equal(progress(['depth >= 10 m', { depth: 11 }], { depth: 2 })[0].share, 1);
  assert.equal(progress(['depth >= 10 m', { depth: 11 }], {})[0].share, 1);
  assert.equal(progress(['depth >= 10 m', { depth: null }], { depth: 2 })[0].share, null);
});

const PLACE = ['distance <= 15 m', { distance: 40 }];
const FAR = { plan: { home: [60, 25], map: { features: [{ properties: { name: 'home_run' },
  geometry: { type: 'LineString', coordinates: [[25, 60.01], [25, 60]] } }] } } };

function under(leg_ends, more = {}) {
  const vehicle = new Vehicle({ id: '1' });
  return Object.assign(vehicle, { state: { leg: 'home_run', leg_began: 10, leg_ends } }, more);
}

test('a goto comes nearer to its place from the leg\'s begin on, also for who looks late', () => {
  const track = [[8, 60.002, 25, 1], [10, 60.001, 25, 1], [30, 60.0004, 25, 1]];
  const began = new Begun().of(under([PLACE], { ...FAR, track })).distance;
  assert.ok(Math.abs(began - 111.4) < 0.3);
  assert.ok(Math.abs(progress(PLACE, { distance: began })[0].share - 0.74) < 0.01);
});

test('without a plan a distance has come from the greatest that was seen, and to each corner anew', () => {
  const begun = new Begun();
  const seen = [40, 60, 12, 100, 70].map((distance) =>
    begun.of(under([['each corner: distance <= 10 m', { distance }]], FAR)).distance);
  assert.deepEqual(seen, [40, 60, 60, 100, 100]);
});

test('what a guard looked at when the leg began stands in the strips', () => {
  const guard = ['depth >= 10 m or elapsed > 60 or leak > 0', { depth: 4, elapsed: 20, leak: 0 }];
  const vehicle = under([guard], { strips: { depth: [[8, 1], [10, null], [12, 2], [14, 3]] } });
  assert.deepEqual(new Begun().of(vehicle), { depth: 2, elapsed: 0, leak: 0 });
  vehicle.state.leg_ends = [['leak > 0', { leak: 1 }]];
  const begun = new Begun();
  begun.of(under([guard]));
  assert.equal(begun.of(vehicle).leak, 0);
});

test('each comparison of a guard is shown', () => {
  const found = progress(['elapsed > 60 or altitude < 1.5 sure 0.9', { elapsed: 15, altitude: 3 }],
    { elapsed: 0, altitude: 3 });
  assert.deepEqual(found.map((p) => p.share), [0.25, 0]);
});

test('a line of a strip breaks where nothing was known, or for long', () => {
  const samples = [[0, 1], [1, 2], [2, null], [3, 4], [30, 5]];
  assert.deepEqual(runs(samples, 0, 40), [[[0, 1], [1, 2]], [[3, 4]], [[30, 5]]]);
  assert.deepEqual(runs(samples, 2, 10), [[[3, 4]]]);
  assert.equal(runs(samples, 3, 40, 50).length, 1);
});

test('no line is drawn over a hole, but over what is left of a long past', () => {
  const every = (s, n) => Array.from({ length: n }, (_, i) => [i * s, 1]);
  const lines = (samples) => runs(samples, 0, Infinity, gapOf(samples)).length;
  assert.equal(lines([[0, 1], [15, 1], [31, 1]]), 2);
  assert.equal(lines(every(1, 4096)), 1);
  assert.equal(lines(every(32, 2700)), 1); // a day
  assert.equal(lines([...every(32, 1300), ...every(32, 1300).map(([t]) => [t + 42_000, 1])]), 2);
});

test('strips that have no room have their turn', () => {
  const all = ['a', 'b', 'c', 'd', 'e'];
  assert.deepEqual([0, 2, 4].map((first) => turned(all, first, 2).join('')), ['ab', 'cd', 'ea']);
  assert.deepEqual(turned(all, 4, 5), all);
});

test('depth begins at the surface, and a voltage does not begin at zero', () => {
  assert.equal(bounds([3, 8], { name: 'depth', unit: 'm', least: 2, down: true })[0], 0);
  const [low, up] = bounds([11.9, 12.1], { name: 'battery', unit: 'V', least: 1 });
  assert.ok(low > 11 && up < 13 && up - low >= 1);
});

test('the journal shows what somebody should look at', () => {
  assert.equal(levelOf('41.0 s ALARM limit: depth'), 'danger');
  assert.equal(levelOf('41.0 s warning: N to @AA'), 'warning');
  assert.equal(levelOf('41.0 s info: now idle/ready'), null);
  assert.equal(levelOf('41.0 s warning: now emergency/surfacing - W'), 'danger');
  assert.equal(levelOf('41.0 s info: now autonomous/up - depth: emergency surfacing: entry of up'), null);
});

test('the journal tells the day where it is another', () => {
  const lines = ['2026-11-23T23:59:59Z info: a', '2026-11-23T23:59:59Z info: b', 'what', '2026-11-24T00:00:01Z info: c'];
  assert.deepEqual(byDay(lines), ['2026-11-23 23:59:59Z info: a', '23:59:59Z info: b', 'what', '2026-11-24 00:00:01Z info: c']);
});

test('the alarms of every live vehicle stand, worst first, whichever is looked at', () => {
  const station = (id, to, level) => {
    const vehicle = new Vehicle({ id, name: `auv-${id}`, to, source: to ? 'monitor' : 'recording', speed: 1, silent_s: 5 });
    const alarms = level ? [{ name: 'limit', level, words: '', do: '' }] : [];
    update(vehicle, { n: 1, t: 1, state: { silence: 0, alarms } }, 0);
    return { vehicle, problem: '' };
  };
  const stations = [station('1', 'tcp://a:1', 'warning'), station('2', 'tcp://b:1', 'danger'), station('3', '', 'danger')];
  const told = (page) => standingOfAll(page, 0).map((one) => `${one.whose} ${one.level}`);
  assert.deepEqual(told({ stations, chosen: stations[0] }), ['auv-2 danger', 'auv-1 warning']);
  assert.deepEqual(told({ stations, chosen: stations[2] }), ['auv-2 danger', 'auv-3 danger', 'auv-1 warning']);
  assert.deepEqual(told({ stations: [stations[0]], chosen: stations[0] }), [' warning']);
});

test('a recording that cannot go on says why', () => {
  const vehicle = new Vehicle({ id: '1', name: 'dive', to: '', source: 'recording', speed: 1, silent_s: 5 });
  update(vehicle, { n: 1, t: 1, state: { silence: 0, problem: 'it cannot be run beyond 3.0 s' } }, 0);
  const station = { vehicle, problem: '' };
  const told = standingOfAll({ stations: [station], chosen: station }, 0);
  assert.deepEqual(told.map((one) => [one.level, one.words]), [['danger', 'it cannot be run beyond 3.0 s']]);
});

test('what is to be done is called as the button of the page is', () => {
  assert.equal(here('find out why, then `auvmission clear` at the surface'), 'find out why, then “Clear” at the surface');
  assert.equal(here('look at the cable and at `auvmission doctor`'), 'look at the cable and at `auvmission doctor`');
});

test('how long a vehicle may be silent is its own: by modem longer', () => {
  const station = (silent) => {
    const vehicle = new Vehicle({ id: '1', name: 'auv', to: 'x', source: 'frames', speed: 1, silent_s: silent });
    update(vehicle, { n: 1, t: 1, state: { silence: 14 } }, 0);
    return { vehicle, problem: '' };
  };
  const told = (one) => standingOfAll({ stations: [one], chosen: one }, 0).map((a) => a.level);
  assert.deepEqual(told(station(35)), []);
  assert.deepEqual(told(station(5)), ['danger']);
});

test('that a vehicle is silent is said once, with what to do', () => {
  const alarms = [{ name: 'no contact', level: 'warning', words: 'heard 6 s ago', do: 'ask again' },
    { name: 'emergency', level: 'danger', words: '', do: '' }];
  const told = (silent) => {
    const vehicle = new Vehicle({ id: '1', name: 'auv', to: 'x', source: 'frames', speed: 1, silent_s: 5 });
    update(vehicle, { n: 1, t: 1, state: { silence: silent, alarms } }, 0);
    const station = { vehicle, problem: '' };
    return standingOfAll({ stations: [station], chosen: station }, 0).map((one) => [one.name.slice(0, 11), one.do]);
  };
  assert.deepEqual(told(6), [['NOTHING NEW', 'ask again'], ['emergency', '']]);
  assert.deepEqual(told(1), [['emergency', ''], ['no contact', 'ask again']]);
});

test('before a dive the page says what it can see of link, sensors, limits, alarms and mission', () => {
  const stale = { intent: 0.5, report: 6, fix: 5 };
  const setup = { id: '1', name: 'auv', to: 'x', source: 'monitor', speed: 1, silent_s: 5 };
  const levels = (state, later = 0) => {
    const vehicle = new Vehicle(setup);
    if (state) update(vehicle, { n: 1, t: 100, state }, 0);
    return findings(vehicle, stale, later).map((one) => one.level).join(' ');
  };
  const well = { silence: 0, report_at: 99, fix_at: 98, alarms: [], mission: '',
    to_depth: [5, 10], to_radius: [90, 100], to_voltage: [2, 10], to_time: [20, 20],
    depth: 3, altitude: 5, command: { is: 'us', age: 0 } };
  assert.equal(levels(well), 'good good good good good careful good good');
  assert.equal(levels(null), 'bad bad bad unknown unknown unknown unknown unknown');
  assert.equal(levels(well, 10_000), 'bad bad bad good good careful good good');
  assert.equal(levels({ ...well, altitude: null }).split(' ')[6], 'careful');
  assert.equal(levels({ ...well, command: { is: 'other' } }).split(' ')[7], 'careful');
  assert.equal(levels({ ...well, to_radius: [null, null] }).split(' ')[3], 'careful');
  assert.equal(levels({ ...well, to_depth: [-1, 10] }).split(' ')[3], 'bad');
  assert.equal(levels({ ...well, alarms: [{ name: 'disk', level: 'danger' }] }).split(' ')[4], 'bad');
  assert.equal(levels({ ...well, fix_at: 80 }).split(' ')[2], 'bad');
});

test('X and W are their letters on every keyboard', () => {
  const of = (key, code) => letter({ key, code });
  assert.equal(of('x', 'KeyX'), 'x');
  assert.equal(of('X', 'KeyX'), 'x');
  assert.equal(of('z', 'KeyW'), 'z'); // a French one: W is where W is written
  assert.equal(of('w', 'KeyZ'), 'w');
  assert.equal(of('ч', 'KeyX'), 'x'); // a Russian one
  assert.equal(of('Process', 'KeyW'), 'w'); // while Chinese is written
  assert.equal(of('é', 'Digit2'), '');
  assert.equal(of('ç', 'KeyX'), '');
  assert.equal(of('ArrowUp', 'ArrowUp'), '');
});

test('one jumps to what matters before and after, and not to where one stands', () => {
  const events = [[1, 2], [10, 3], [20, 2], [30, 4]].map(([t, level]) => ({ t, level, of: '', says: '' }));
  assert.equal(eventNear(events, 5, 1).t, 10);
  assert.equal(eventNear(events, 10, 1).t, 30);
  assert.equal(eventNear(events, 30.5, -1).t, 10);
  assert.equal(eventNear(events, 5, -1), null);
  assert.equal(eventNear([], 5, 1), null);
});

test('a jump forward stands at its goal until the recording is there', () => {
  const goal = new Goal();
  assert.equal(goal.at(10, 1), 10);
  goal.set(600, 1);
  assert.deepEqual([[10, 1], [300, 1], [600.2, 2], [601, 2]].map((one) => goal.at(...one)), [600, 600, 600.2, 601]);
});

test('a jump back is over with the snapshot of there, however fast it plays', () => {
  const goal = new Goal();
  goal.set(60, 1);
  assert.deepEqual([[700, 1], [701, 1], [80, 2], [100, 2]].map((one) => goal.at(...one)), [60, 60, 80, 100]);
});

const PLAN = { digest: 'a', home: [30, 120], radius: 500, map: { features: [
  { properties: { name: 'home', what: '' }, geometry: { type: 'Point', coordinates: [120, 30] } },
  { properties: { name: 'rows/out', what: 'goto' }, geometry: { type: 'LineString', coordinates: [[120, 30], [120.001, 30]] } },
] } };

function vehicle(state) {
  const made = new Vehicle({ id: '1', to: '', source: 'monitor', speed: 1 });
  update(made, { n: 1, t: 10, state: { report_at: 9, ...state }, track: [[8, 30, 120, 1]] }, 0);
  made.plan = PLAN;
  return made;
}

test('the target is the end of the leg that is flown', () => {
  const flown = vehicle({ leg: 'rows/out', latitude: 30, longitude: 120.0005, heading: 90 });
  const scene = sceneOf(flown, frameOf(flown), 6, 0);
  assert.ok(Math.abs(scene.target[0] - 96.5) < 0.2);
  assert.equal(sceneOf(vehicle({ leg: 'up' }), frameOf(flown), 6, 0).target, null);
  assert.deepEqual(scene.home, [0, 0]);
  assert.equal(scene.radius, 500);
  assert.equal(scene.here.isOld, false);
  assert.deepEqual(routesOf(PLAN.map, new Frame(30, 120)).map((r) => r.name), ['rows/out']);
});

test('a vehicle whose place is not known stands where it was, and looks old', () => {
  const lost = vehicle({ latitude: null, longitude: null, ellipse: null });
  const { here } = sceneOf(lost, frameOf(lost), 6, 0);
  assert.deepEqual([here.at, here.isOld, here.ellipse], [[0, 0], true, null]);
});

test('another vehicle is shown where it is, by its name', () => {
  const [own, far] = [vehicle({ latitude: 30, longitude: 120 }), vehicle({ latitude: 30, longitude: 120.001 })];
  far.setup.name = 'auv-2';
  const [other] = sceneOf(own, frameOf(own), 6, 0, [far]).others;
  assert.equal(other.name, 'auv-2');
  assert.ok(Math.abs(other.at[0] - 96.5) < 0.2);
});

test('the limit that is in force is drawn, and not the mission\'s wider one', () => {
  const tight = vehicle({ to_radius: [80, 100] });
  assert.equal(sceneOf(tight, frameOf(tight), 6, 0).radius, 100);
});

test('where no place is known there is no chart to be wrong', () => {
  const nowhere = new Vehicle({ id: '1', to: '', source: 'monitor', speed: 1 });
  const scene = sceneOf(nowhere, frameOf(nowhere), 6, 0);
  assert.deepEqual([scene.hasPlace, scene.here, scene.home, scene.routes], [false, null, null, []]);
});

test('the track in still water is drawn with what it is unsure of, or the reason why there is none', () => {
  const frame = new Frame(30, 120);
  assert.equal(stillOf(null, frame), null);
  const found = stillOf({ is: 'planned', track: [[0, 30, 120], [9, 30.001, 120]], turns: [[9, 30.001, 120, [7, 5, 20], 'out']] }, frame);
  assert.deepEqual(found.line.map(([, north]) => Math.round(north)), [0, 111]);
  assert.deepEqual([found.turns[0].around, found.problem], [[7, 5, 20], '']);
  assert.deepEqual(stillOf({ is: 'refused', says: 'why' }, frame), { line: [], turns: [], problem: 'why' });
  assert.ok(stillOf({ is: 'flown' }, frame).isFlown); // it is told, not waited for in silence
});

test('a reason is told in lines that fit', () => {
  assert.deepEqual(broken('in still water it is not done', 12), ['in still', 'water it is', 'not done']);
  assert.deepEqual(broken('averylongwordindeed it', 5), ['averylongwordindeed', 'it']);
});

test('that X and W have no connection is told after 3 s, though frames come', () => {
  const told = (lines, setup = {}) => {
    const vehicle = new Vehicle({ id: '1', name: 'auv', to: 'x', source: 'monitor', speed: 1, silent_s: 5, ...setup });
    for (const t of [0, 1, 2, 3, 4]) update(vehicle, { n: t + 1, t, state: { silence: 0, lines } }, 1000 * t);
    const station = { vehicle, problem: '' };
    return [2500, 4100].map((now) => standingOfAll({ stations: [station], chosen: station }, now).map((one) => one.level));
  };
  assert.deepEqual(told({ orders: null, commands: null }), [[], ['danger']]);
  assert.deepEqual(told({ orders: 0.5, commands: 0.5 }), [[], []]);
  assert.deepEqual(told({ orders: null, commands: 0.5 }, { under_water: true }), [[], []]);
});
