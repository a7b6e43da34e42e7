import assert from 'node:assert/strict';
import test from 'node:test';

import { completions, contextAt, helpOn, wordAt, written } from '../../../mission/console/page/completing.js';
import { near } from '../../../mission/console/page/differing.js';
import { DraftChart } from '../../../mission/console/page/draftchart.js';
import { Frame } from '../../../mission/console/page/geo.js';
import { History } from '../../../mission/console/page/history.js';
import { base64, Importing, inFields } from '../../../mission/console/page/importing.js';
import { drawPlaces, placeNear } from '../../../mission/console/page/places.js';
import { lineAt, linesOf, rangeOf } from '../../../mission/console/page/texts.js';
import { View } from '../../../mission/console/page/view.js';

const WORDS = [
  { word: 'goto', says: 'to a place', of: 'leg' }, { word: 'gear', says: 'ahead', of: 'leg' },
  { word: 'depth', says: 'hold', of: 'leg' }, { word: 'depth', says: 'below (m)', of: 'guard' },
  { word: 'safety', says: 'limits', of: 'mission' }, { word: 'radius', says: 'from home', of: 'safety' },
  { word: 'when', says: 'a guard', of: 'handler' }, { word: 'legs', says: 'in order', of: 'group' },
];

test('what is typed in one go is one step, and an edit of the chart is one of its own', () => {
  const history = new History({ text: '', at: 0 });
  history.add({ text: 'a', at: 1 }, 1000);
  history.add({ text: 'ab', at: 2 }, 1100);
  history.add({ text: 'ab!', at: 0 });
  history.add({ text: 'abc', at: 3 }, 1200);
  assert.deepEqual([history.undo().text, history.undo().text, history.undo().text, history.undo().text],
    ['ab!', 'ab', '', '']);
  assert.deepEqual([history.redo().text, history.canUndo, history.canRedo], ['ab', true, true]);
  history.add({ text: 'x', at: 1 }, 9000);
  assert.equal(history.canRedo, false);
});

test('what was undone takes its name and its notes with it', () => {
  const [first, second] = ['a.yaml', 'b.yaml'].map((source) => ({ source, notes: [] }));
  const history = new History({ text: '', at: 0 });
  history.add({ text: 'a', at: 0, of: first });
  history.add({ text: 'ab', at: 2 }, 1000);
  history.add({ text: 'b', at: 0, of: second });
  assert.equal(history.now.of, second);
  assert.deepEqual([history.undo(), history.undo()].map((step) => step.of), [first, first]);
  assert.equal(history.undo().of, undefined);
  history.redo();
  history.add({ text: 'a', at: 0, of: second });
  assert.equal(history.now.of, second);
});

test('the first typing after a pause begins another step', () => {
  const history = new History({ text: 'a', at: 0 });
  history.add({ text: 'ab', at: 2 }, 1000);
  history.add({ text: 'abc', at: 3 }, 5000);
  assert.equal(history.undo().text, 'ab');
});

test('a history is bounded in steps and in characters', () => {
  const history = new History({ text: '', at: 0 });
  for (let i = 0; i < 30; i += 1) history.add({ text: String(i % 10).repeat(1 << 20), at: 0 });
  let steps = 0;
  for (; history.canUndo; steps += 1) history.undo();
  assert.ok(steps >= 1 && steps <= 8, `${steps}`);
});

test('a place of the text is found by line and column in characters', () => {
  const text = '# Ä 😀 1\nhome: 30.28\n\nlast';
  const starts = linesOf(text);
  const of = (/** @type {[number, number, number]} */ span) => text.slice(...rangeOf(text, starts, span));
  assert.equal(of([1, 7, 1]), '1');
  assert.equal(of([2, 7, 5]), '30.28');
  assert.equal(of([2, 7, 99]), '30.28');
  assert.equal(of([4, 1, 4]), 'last');
  assert.equal(of([3, 1, 4]), '');
  assert.deepEqual([0, 9, 10, 21, 23, 99].map((at) => lineAt(starts, at)), [1, 2, 2, 3, 4, 4]);
});

test('what is offered fits where the caret is', () => {
  const of = (/** @type {string} */ text, yaml = true) => contextAt(text, text.length, yaml);
  assert.deepEqual(of('legs:\n  - a: {'), ['leg', 'group']);
  assert.deepEqual(of(''), ['mission']);
  assert.deepEqual(of('safety: {radius: 3 m, '), ['safety']);
  assert.deepEqual(of('  - a: {depth: 3 m, until: '), ['guard']);
  assert.deepEqual(of('  - a: {until: depth > 3 or '), ['guard']);
  assert.deepEqual(of('  - a: {until: depth > 3 -> '), ['name']);
  assert.deepEqual(of('  - {when: depth > 3, '), ['handler']);
  assert.deepEqual(of('  - a: {depth: 3 m, else: '), ['name']);
  assert.deepEqual(of('# a note: '), []);
  assert.deepEqual(of('on ', false), ['guard']);
  assert.deepEqual(of('dive: ', false), ['leg']);
});

test('a completion is offered for what has begun, or for everything by the key', () => {
  const offered = (/** @type {string} */ text, all = false) =>
    completions(WORDS, ['home_run'], text, text.length, true, all).map((one) => one.word);
  assert.deepEqual(offered('  - a: {g'), ['goto', 'gear']);
  assert.deepEqual(offered('  - a: {'), []);
  assert.deepEqual(offered('  - a: {', true), ['goto', 'gear', 'depth', 'legs']);
  assert.deepEqual(offered('  - a: {goto'), []);
  assert.deepEqual(offered('  - a: {gear: 3, else: h'), ['home_run']);
  assert.equal(written(WORDS[0], 'g', 1, true), 'goto: ');
  assert.equal(written(WORDS[0], 'g: x', 1, true), 'goto');
  assert.equal(written(WORDS[0], 'g', 1, false), 'goto');
  assert.equal(written(WORDS[3], 'd', 1, true), 'depth');
});

test('a word is explained wherever the caret is in it', () => {
  assert.equal(wordAt('  goto: home', 4), 'goto');
  assert.equal(helpOn(WORDS, 'depth'), 'depth: hold · depth: below (m)');
  assert.equal(helpOn(WORDS, 'nothing'), '');
});

test('the nearest place is taken, within reach of a finger', () => {
  const view = Object.assign(new View(), { width: 400, height: 400 });
  const frame = new Frame(30, 120);
  const place = (/** @type {string} */ kind, /** @type {number} */ east) =>
    ({ path: '', kind, word: '', at: frame.toEarth(east, 0), row: [0, 1], spans: [], fixed: '' });
  const places = /** @type {any} */ ([place('home', 0), place('place', 0), place('corner', 30)]);
  assert.equal(placeNear(places, frame, view, [201, 200], false), 1);
  assert.equal(placeNear(places, frame, view, [228, 200], false), 2);
  assert.equal(placeNear(places, frame, view, [250, 200], false), -1);
  assert.equal(placeNear(places, frame, view, [250, 200], true), 2);
  assert.equal(placeNear([{ ...places[0], at: null }], frame, view, [200, 200], false), -1);
});

test('of a difference the lines that differ are shown, with some around them', () => {
  const rows = Array.from({ length: 20 }, (_, i) => /** @type {[string, string]} */ ([i === 9 ? '-' : ' ', `${i}`]));
  assert.deepEqual(near(rows).map(([, line]) => line), ['7', '8', '9', '10', '11']);
});

test('a file of any bytes goes out whole', () => {
  const bytes = Uint8Array.from({ length: 70000 }, (_, i) => i % 256);
  assert.deepEqual(Uint8Array.from(Buffer.from(base64(bytes), 'base64')), bytes);
});

test('of ten thousand places no more are drawn than can be told apart, and the chosen one always', () => {
  const view = Object.assign(new View(), { width: 400, height: 400, scale: 1, east: 0, north: 0 });
  const frame = new Frame(30, 120);
  const at = (metres) => [30 + metres / 110852, 120];
  const many = Array.from({ length: 10_000 }, (_, i) => ({ kind: 'place', at: at(i / 100), fixed: '' }));
  let drawn = 0;
  const pen = new Proxy({}, { get: (_, name) => (name === 'fill' ? () => { drawn += 1; } : () => {}), set: () => true });
  drawPlaces(pen, view, frame, {}, many, -1, null);
  assert.ok(drawn >= 20 && drawn <= 25, `${drawn}`); // 100 m are 100 px
  const first = drawn;
  drawn = 0;
  drawPlaces(pen, view, frame, {}, many, 5001, null);
  assert.equal(drawn, first + 1);
});

/** Of an element what an import panel asks of one. @returns {any} */
function plainElement() {
  const heard = {};
  return { textContent: '', hidden: false, append() {}, setAttribute() {}, removeAttribute() {},
    toggleAttribute(name, on) { this[name] = on; }, getAttribute: () => null,
    addEventListener(name, listener) { heard[name] = listener; }, click: () => heard.click() };
}

test('an import that is closed replaces no text, whatever its answer is', async () => {
  const made = [];
  globalThis.document = { createElement: (tag) => {
    const element = Object.assign(plainElement(), { tag });
    made.push(element);
    return element;
  } };
  for (const [closes, texts] of [[true, []], [false, ['imported']]]) {
    for (const said of [{ text: 'imported', source: 'bay.gpx', left_out: [] }, { says: 'no' }]) {
      let answer;
      globalThis.fetch = () => new Promise((done) => { answer = done; });
      const opened = [];
      const panel = new Importing(() => ({ redraw() {}, token: '' }), (text) => { opened.push(text); });
      const close = made.filter((element) => element.tag === 'button').at(-1);
      const over = panel.open(new File(['<gpx/>'], 'bay.gpx'));
      while (!answer) await new Promise((done) => { setTimeout(done); });
      if (closes) close.click();
      answer({ ok: true, json: async () => said });
      await over;
      assert.deepEqual(opened, said.says ? [] : texts);
      assert.equal(panel.root.hidden, closes || !said.says);
    }
  }
});

test('what an import asks for is named as the fields are', () => {
  assert.equal(inFields('say --home LATITUDE,LONGITUDE, or --home first'), 'say “Home” LATITUDE,LONGITUDE, or “Home” first');
  assert.equal(inFields('say --depth, or --altitude'), 'say “Depth”, or --altitude');
});

test('the grid of a plan counts from its home, and a home that is moved moves nothing on the screen', () => {
  const view = Object.assign(new View(), { width: 400, height: 200, scale: 2, east: 10, north: 20 });
  const chart = Object.assign(Object.create(DraftChart.prototype), { _frame: new Frame(60, 25), _view: view });
  const middle = () => chart._frame.toEarth(...view.toWorld([200, 100]));
  const before = middle();
  chart.take({ home: [60.001, 25.001], places: [] }, false);
  assert.deepEqual([chart._frame.lat, chart._frame.lon], [60.001, 25.001]);
  middle().forEach((degrees, i) => assert.ok(Math.abs(degrees - before[i]) < 1e-7));
});
