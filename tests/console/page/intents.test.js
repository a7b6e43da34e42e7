import assert from 'node:assert/strict';
import test from 'node:test';

import { Intents, KEPT } from '../../../mission/console/page/intents.js';

function made() {
  const way = () => ({ isOpen: true, said: [], send(m) { if (this.isOpen) this.said.push(m); return this.isOpen; } });
  const clock = { ms: 5000, wall: 1763820000 };
  const ways = { orders: way(), commands: way() };
  return { ...ways, clock, intents: new Intents(ways, () => clock.ms, () => clock.wall) };
}

test('X and W leave by the connection of their own', () => {
  const { intents, orders, commands } = made();
  intents.order('stop');
  intents.order('surface');
  assert.deepEqual(orders.said.map((m) => m.do), ['stop', 'surface']);
  assert.equal(commands.said.length, 0);
});

test('an order without a connection leaves as soon as there is one', () => {
  const { intents, orders } = made();
  orders.isOpen = false;
  const order = intents.order('stop');
  assert.equal(order.is, 'waiting');
  orders.isOpen = true;
  intents.opened();
  assert.deepEqual(orders.said.map((m) => [m.id, m.do]), [[order.id, 'stop']]);
  assert.equal(order.is, 'sent');
});

test('an order that nobody has acknowledged leaves again by the next connection, and then no more', () => {
  const { intents, orders } = made();
  const order = intents.order('surface');
  intents.heard({ id: order.id, is: 'unanswered', says: '' });
  intents.opened();
  assert.deepEqual(orders.said.map((m) => [m.id, m.do]), [[order.id, 'surface'], [order.id, 'surface']]);
  intents.heard({ id: order.id, is: 'acknowledged', says: '' });
  intents.opened();
  assert.equal(orders.said.length, 2);
});

test('of two orders that wait the newer one leaves', () => {
  const { intents, orders } = made();
  orders.isOpen = false;
  intents.order('surface');
  intents.order('stop');
  orders.isOpen = true;
  intents.opened();
  assert.deepEqual(orders.said.map((m) => m.do), ['stop']);
});

test('a command without a connection is not sent, then or later', () => {
  const { intents, commands } = made();
  commands.isOpen = false;
  assert.equal(intents.command('start', 'start it', { digest: 'a' }).is, 'unsent');
  commands.isOpen = true;
  intents.opened();
  assert.equal(commands.said.length, 0);
});

test('a command tells when the finger moved, and not when it left', () => {
  const { intents, commands } = made();
  intents.command('start', 'start it', { digest: 'a' }, 4700);
  assert.equal(commands.said[0].at, 1763820000 - 0.3);
});

test('each answer is told of the command that it answers', () => {
  const { intents, clock } = made();
  const first = intents.command('upload', 'upload a', {});
  const second = intents.command('start', 'start b', {});
  clock.ms = 6000;
  intents.heard({ id: second.id, is: 'refused', says: 'no fix' });
  intents.heard({ id: first.id, is: 'progress', says: '', have: 3, of: 12 });
  intents.heard({ id: 1, is: 'refused', says: 'of another page' });
  assert.deepEqual([first.is, first.have, first.of], ['progress', 3, 12]);
  assert.deepEqual([second.is, second.says, second.since], ['refused', 'no fix', 6000]);
});

test('nobody knows what became of a command whose connection is gone', () => {
  const { intents } = made();
  const [gone, done] = [intents.command('clear', 'clear', {}), intents.command('start', 'start', {})];
  const order = intents.order('stop');
  intents.heard({ id: done.id, is: 'acknowledged', says: 'started' });
  intents.lost();
  assert.deepEqual([gone.is, done.is, order.is], ['unanswered', 'acknowledged', 'sent']);
});

test('two pages give their commands different numbers', () => {
  const [one, other] = [made(), made()];
  other.clock.wall += 1;
  const later = new Intents({ orders: other.orders, commands: other.commands }, () => 0, () => other.clock.wall + 500);
  assert.notEqual(one.intents.order('stop').id, later.order('stop').id);
});

test('no more than the newest are kept', () => {
  const { intents } = made();
  for (let i = 0; i < KEPT + 10; i += 1) intents.order('stop');
  assert.equal(intents.list.length, KEPT);
});
