import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import test from 'node:test';

import { WORDS, named, setLanguage, word } from '../../../mission/console/page/words.js';

const PAGE = new URL('../../../mission/console/page/', import.meta.url);
const sources = readdirSync(PAGE).filter((name) => /\.(js|html)$/.test(name) && name !== 'words.js')
  .map((name) => readFileSync(new URL(name, PAGE), 'utf8')).join('\n');

test('every word stands in both languages with the same places to fill', () => {
  for (const [key, [english, chinese]] of Object.entries(WORDS)) {
    assert.ok(english && chinese, key);
    const places = (text) => [...new Set(text.match(/\{\d\}/g) ?? [])].sort().join();
    if (!key.startsWith('will_')) assert.equal(places(english), places(chinese), key);
    if (key !== 'language') assert.match(chinese, /[\u4e00-\u9fff]/, key);
  }
});

test('every word that the page asks for is in the table', () => {
  const asked = [...sources.matchAll(/\bword\(\s*'([a-z_]+)'/g), ...sources.matchAll(/data-(?:word|label)="([a-z_]+)"/g)];
  assert.ok(asked.length > 80);
  for (const [, key] of asked) assert.ok(key in WORDS, key);
});

test('every word of the table is said somewhere', () => {
  const made = [...sources.matchAll(/`(?:([a-z]+_)\$\{[^}]*\}|\$\{[^}]*\}(_[a-z]+))`/g)];
  const isMade = (key) => made.some(([, begin, end]) => (begin ? key.startsWith(begin) : key.endsWith(end)));
  const unsaid = Object.keys(WORDS).filter((key) => !/['"]/.test(key)
    && !sources.includes(`'${key}'`) && !sources.includes(`"${key}"`) && !isMade(key)
    && !new RegExp(`\\b${key}: `).test(sources));
  assert.deepEqual(unsaid, []);
});

test('a word that is not there is a fault, and never an empty place', () => {
  assert.throws(() => word('nonsense'));
});

test('what is put in stands in each language', () => {
  assert.equal(word('will_start', 'harbour 9a8c', 'auv-1'), 'start harbour 9a8c on auv-1');
  setLanguage('zh');
  assert.equal(word('will_start', 'harbour 9a8c', 'auv-1'), '在 auv-1 上开始 harbour 9a8c');
  assert.equal(named('no fix'), '无定位');
  assert.equal(named('a new alarm'), 'a new alarm');
  setLanguage('en');
});
