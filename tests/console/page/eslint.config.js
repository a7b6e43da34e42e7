// What tsc does not see of the page's JavaScript; names and types are its own (tsconfig.json).
import js from '@eslint/js';

const HTML = 'text of vehicles and missions never becomes HTML';
const AWAY = 'wire.js alone asks the server, and nobody asks another';

export default [
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2023, sourceType: 'module' },
    linterOptions: { reportUnusedDisableDirectives: 'error' },
    rules: {
      'no-undef': 'off', // tsc
      'array-callback-return': 'error',
      'consistent-return': 'off', // tsc
      'default-case-last': 'error',
      eqeqeq: 'error',
      'max-lines': ['error', 400],
      'max-lines-per-function': ['error', { max: 60, skipComments: true }],
      'no-alert': 'error',
      'no-console': 'error',
      'no-constructor-return': 'error',
      'no-eval': 'error',
      'no-implied-eval': 'error',
      'no-new-func': 'error',
      'no-param-reassign': 'error',
      'no-self-compare': 'error',
      'no-shadow': 'error',
      'no-template-curly-in-string': 'error',
      'no-unreachable-loop': 'error',
      'no-unused-expressions': 'error',
      'no-use-before-define': ['error', { functions: false, classes: false, variables: false }],
      'no-var': 'error',
      'object-shorthand': 'error',
      'prefer-const': 'error',
      'prefer-promise-reject-errors': 'error',
      'no-restricted-properties': ['error',
        ...['innerHTML', 'outerHTML', 'insertAdjacentHTML', 'write', 'setHTMLUnsafe']
          .map((property) => ({ property, message: HTML }))],
    },
  },
  {
    files: ['tests/**'],
    rules: { 'no-shadow': 'off' },
  },
  {
    files: ['mission/console/page/*.js'],
    ignores: ['mission/console/page/wire.js'],
    rules: {
      'no-restricted-globals': ['error', ...['fetch', 'WebSocket', 'XMLHttpRequest', 'EventSource']
        .map((name) => ({ name, message: AWAY }))],
    },
  },
];
