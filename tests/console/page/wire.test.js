import assert from 'node:assert/strict';
import test from 'node:test';

import { Refused, ask, load, takeToken, want } from '../../../mission/console/page/wire.js';

/** A server that answers so, and what it was asked. */
function server(status, body) {
  const asked = [];
  globalThis.fetch = async (path, init) => {
    const sent = new Request(new URL(path, 'http://127.0.0.1:1'), init);
    asked.push({ path, method: sent.method, token: sent.headers.get('Authorization'),
      kind: sent.headers.get('Content-Type'), body: await sent.text() });
    return new Response(body, { status, statusText: 'Odd' });
  };
  return asked;
}

test('whatever is asked shows the token', async () => {
  const asked = server(200, '{}');
  await ask('/api/setup', 'secret');
  await ask('/api/check', 'secret', { text: '' });
  await want('/api/charts/a', 'secret', new Blob(['scan']));
  await load('/api/charts/a', 'secret');
  assert.deepEqual(asked.map((one) => [one.method, one.token]), [['GET', 'Bearer secret'],
    ['POST', 'Bearer secret'], ['POST', 'Bearer secret'], ['GET', 'Bearer secret']]);
});

test('an object leaves as JSON, and a file as it is', async () => {
  const asked = server(200, '{}');
  await ask('/api/check', 't', { text: 'a' });
  await want('/api/charts/a.png', 't', new Blob(['\x89PNG'], { type: 'image/png' }));
  assert.deepEqual([asked[0].kind, asked[0].body], ['application/json', '{"text":"a"}']);
  assert.deepEqual([asked[1].kind, asked[1].body], ['image/png', '\x89PNG']);
});

test('what is refused is told in the server\'s words, or by its status', async () => {
  server(404, '{"says": "no such vehicle"}');
  await assert.rejects(ask('/api/x', 't'), (error) => error instanceof Refused && error.status === 404
    && error.message === 'no such vehicle');
  server(502, 'no JSON');
  await assert.rejects(ask('/api/x', 't'), { status: 502, message: 'Odd' });
  await assert.rejects(load('/api/x', 't'), { status: 502, message: 'Odd' });
  server(200, '{"says": "the text does not allow that"}');
  await assert.rejects(want('/api/edit', 't', {}), { status: 200, message: 'the text does not allow that' });
});

test('the token is taken out of the address and known to this tab', () => {
  const kept = new Map();
  globalThis.sessionStorage = { getItem: (name) => kept.get(name) ?? null, setItem: (name, to) => kept.set(name, to) };
  globalThis.location = { hash: '#secret', pathname: '/', search: '' };
  globalThis.history = { replaceState: (_state, _title, to) => { globalThis.location = { hash: '', pathname: to, search: '' }; } };
  assert.equal(takeToken(), 'secret');
  assert.equal(globalThis.location.hash, '');
  assert.equal(takeToken(), 'secret'); // it is loaded anew
});
