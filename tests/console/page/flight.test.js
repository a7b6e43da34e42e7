import assert from 'node:assert/strict';
import test from 'node:test';

import { asked } from '../../../mission/console/page/flight.js';

/** Sockets that do what the test says, and no clock but its own. */
function world(t) {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  const sockets = [];
  globalThis.location = { href: 'http://127.0.0.1:1/' };
  globalThis.WebSocket = class {
    static CONNECTING = 0;
    static OPEN = 1;
    readyState = 0;
    said = [];
    constructor() {
      sockets.push(this);
    }
    open() {
      this.readyState = 1;
      this.onopen();
    }
    send(line) {
      this.said.push(JSON.parse(line));
    }
    close() {
      this.readyState = 3;
    }
  };
  const heard = [];
  const refused = [];
  const line = asked('token', { do: 'fly' }, { heard: (m) => heard.push(m), refused: (why) => refused.push(why) });
  return { sockets, heard, refused, line, pass: (ms) => t.mock.timers.tick(ms) };
}

test('a flight whose connection does not open in time is asked for when it opens', (t) => {
  const { sockets, heard, refused, pass } = world(t);
  pass(3000);
  pass(60000);
  assert.deepEqual([sockets.length, sockets[0].readyState], [1, 0]); // closed now, the browser would say that it failed
  sockets[0].open();
  assert.deepEqual(sockets[0].said, [{ do: 'fly' }]);
  sockets[0].onmessage({ data: '{"is": "done"}' });
  assert.deepEqual([heard, refused], [[{ is: 'done' }], []]);
});

test('a flight whose connection fails after it was late is asked for by the next one', (t) => {
  const { sockets, pass } = world(t);
  pass(3000);
  sockets[0].readyState = 3;
  sockets[0].onclose({ code: 1006, reason: '' });
  pass(1000);
  sockets[1].open();
  assert.deepEqual([sockets[0].said, sockets[1].said], [[], [{ do: 'fly' }]]);
});

test('a flight whose connection is lost is asked for again', (t) => {
  const { sockets, refused, pass } = world(t);
  sockets[0].open();
  sockets[0].onclose({ code: 1006, reason: '' });
  pass(1000);
  sockets[1].open();
  assert.deepEqual([sockets[1].said, refused], [[{ do: 'fly' }], []]);
});

test('a flight that is refused or not wanted any more is not asked for again', (t) => {
  const { sockets, refused, line, pass } = world(t);
  sockets[0].open();
  sockets[0].onclose({ code: 1008, reason: 'that is no flight' });
  assert.deepEqual(refused, ['that is no flight']);
  line.close();
  pass(10000);
  assert.equal(sockets.length, 1);
});

test('a flight that is not wanted any more while its connection opens leaves no error behind', (t) => {
  const { sockets, line, pass } = world(t);
  line.close();
  assert.equal(sockets[0].readyState, 0); // closed now, the browser would say that it failed
  sockets[0].open();
  assert.deepEqual([sockets[0].readyState, sockets[0].said], [3, []]);
  pass(10000);
  assert.equal(sockets.length, 1);
});
