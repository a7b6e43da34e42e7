import assert from 'node:assert/strict';
import test from 'node:test';

import { Hand, STILL_MS, beyond } from '../../../mission/console/page/hand.js';

/** A hand that has seen the pad with the button let go. */
function free() {
  const hand = new Hand();
  assert.deepEqual(hand.held(pad(0, false), true, 0), { axes: null, why: '' });
  return hand;
}

const pad = (timestamp, held = true, axes = [0, -1, 0, 0]) => ({
  id: 'pad', connected: true, timestamp, axes,
  buttons: Array.from({ length: 8 }, (_, i) => ({ pressed: held && i === 4 })),
});

test('without the dead man\'s button no axis counts', () => {
  const hand = new Hand();
  assert.equal(hand.held(pad(1, false), true, 0).axes, null);
  hand.press('ArrowUp', false);
  assert.equal(hand.held(null, true, 0).axes, null);
});

test('a pad that is pushed ahead goes ahead, and one to the right to starboard', () => {
  const { axes } = free().held(pad(1, true, [0.5, -1, 0, -1]), true, 0);
  assert.equal(axes.surge, 1);
  assert.equal(axes.heave, 1);
  assert.ok(axes.turn > 0.4 && axes.turn < 0.5);
});

test('keys are as strong as was chosen', () => {
  const hand = new Hand();
  hand.press('Digit6', true);
  hand.press('ArrowUp', true);
  hand.press('PageDown', true);
  assert.deepEqual(hand.held(null, true, 0).axes, { surge: 0.5, turn: 0, heave: -0.5 });
  hand.release('ArrowUp', true);
  assert.equal(hand.held(null, true, 0).axes.surge, 0);
  hand.release('PageDown', false);
  assert.equal(hand.held(null, true, 0).axes, null);
});

test('a page that is not in front lets go, and goes on only after the button was let go', () => {
  const hand = free();
  assert.ok(hand.held(pad(1), true, 0).axes);
  assert.deepEqual(hand.held(pad(2), false, 100), { axes: null, why: 'hidden' });
  assert.deepEqual(hand.held(pad(3), true, 200), { axes: null, why: 'away' });
  assert.deepEqual(hand.held(pad(4, false), true, 300), { axes: null, why: '' });
  assert.ok(hand.held(pad(5), true, 400).axes);
});

test('a key that was down when the page went away is not down when it is back', () => {
  const hand = new Hand();
  hand.press('ArrowUp', true);
  hand.drop('hidden');
  hand.press('PageUp', true, true);
  hand.press('ShiftLeft', true, true);
  assert.deepEqual(hand.held(null, true, 0), { axes: null, why: 'away' });
  hand.release('PageUp', true);
  hand.release('ShiftLeft', false);
  hand.press('ShiftLeft', true);
  assert.deepEqual(hand.held(null, true, 0).axes, { surge: 0, turn: 0, heave: 0 });
});

test('a pad that is pulled lets go, and does not go on when it is plugged in again', () => {
  const hand = free();
  assert.ok(hand.held(pad(1), true, 0).axes);
  assert.deepEqual(hand.held(null, true, 100), { axes: null, why: 'gone' });
  assert.deepEqual(hand.held(pad(2), true, 200), { axes: null, why: 'gone' });
  assert.deepEqual(hand.held(pad(3, false), true, 300), { axes: null, why: '' });
  assert.ok(hand.held(pad(4), true, 400).axes);
});

test('keys take over from a pad that is gone', () => {
  const hand = free();
  hand.held(null, true, 0);
  hand.press('ShiftLeft', true);
  hand.press('ArrowUp', true);
  assert.equal(hand.held(null, true, 100).axes.surge, 0.25);
});

test('a button that is held when the stick is taken has to be let go first', () => {
  assert.deepEqual(new Hand().held(pad(1), true, 0), { axes: null, why: 'first' });
});

test('a pad that says nothing new lets go, and counts again when it does', () => {
  const hand = free();
  assert.ok(hand.held(pad(7), true, 0).axes);
  assert.ok(hand.held(pad(7), true, STILL_MS).axes);
  assert.deepEqual(hand.held(pad(7), true, STILL_MS + 1), { axes: null, why: 'still' });
  assert.ok(hand.held(pad(8), true, STILL_MS + 2).axes);
});

test('an axis at rest is zero, and at its end one', () => {
  assert.deepEqual([0, 0.1, -0.1, 1, -1, 2].map(beyond), [0, 0, 0, 1, -1, 1]);
  assert.equal(beyond(NaN), 0);
});

test('the strength of the keys goes up and down by gears, and no further', () => {
  const hand = free();
  const strengths = [1, 20, -20].map((by) => {
    hand.change(by);
    return hand.strength;
  });
  assert.deepEqual(strengths, [4, 12, 1]);
});
