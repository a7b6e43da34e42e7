// @ts-check
/**
 * The plan: its text and its chart side by side, checked while it is written.
 *
 *     text --/api/check--> places, proof, faults --> chart, underlines
 *     chart --/api/edit--> text                        the text decides
 *
 * One check runs at a time; the newest text is checked next.
 */

import { Confirm } from './confirm.js';
import { Differing } from './differing.js';
import { byId, el, mark, say } from './dom.js';
import { DraftChart } from './draftchart.js';
import { Editor } from './editor.js';
import { Findings } from './findings.js';
import { GhostBox } from './ghost.js';
import { Importing } from './importing.js';
import { isLive } from './state.js';
import { StillWater } from './still.js';
import { Refused, ask, want } from './wire.js';
import { word } from './words.js';

/** @typedef {import('./station.js').Page} Page
 * @typedef {import('./geo.js').Pair} Pair */

const KINDS = ['goto', 'point', 'rows', 'loiter', 'keep_out', 'keep_in'];
const KEPT = 'plan'; // key in this tab's storage
const MOST_KEPT = 1 << 18; // characters
const AGAIN_MS = 1000;
const MOST_SAID = 1 << 20; // bytes of a request
const MOST_ESCAPED = 6; // bytes of a character, at most
/** @type {import('./history.js').Origin} */
const NEW = { source: 'plan.yaml', notes: [] };

export class Plan {
  /** @type {Array<{name: string, text: string}>} */
  _missions = [];
  _problem = '';
  /** @type {Promise<void> | null} */
  _checking = null;
  _kind = el('select');
  _template = el('select');
  _confirm = new Confirm('upload', () => this._uploadSays(), (says, moved) => this._upload(says, moved));

  /** @param {HTMLElement} root @param {() => Page} page
   * @param {import('./charts.js').Charts} charts */
  constructor(root, page, charts) {
    this._root = root;
    this._page = page;
    this._origin = NEW;
    this._source = NEW.source;
    /** @type {any} the check's newest answer */
    this._said = null;
    this._judged = ''; // the text that it belongs to
    this._isNew = true;
    this._isStarted = false;
    const plan = () => ({ text: this._editor.text, source: this._source });
    this._editor = new Editor(() => this._changed(), () => this._caretMoved());
    this._chart = new DraftChart({ redraw: () => page().redraw(),
      moved: (at, to) => void this._edit({ do: 'move', at, to }),
      removed: (at) => void this._edit({ do: 'remove', at }),
      added: (to) => void this._add(to),
      chosen: (at) => this._editor.choose(this._chart.places[at]?.spans ?? [], true) }, charts);
    this._findings = new Findings((fault) => {
      this._editor.reveal([fault.line, fault.column, fault.length]);
      this._editor.area.focus();
    });
    this._still = new StillWater(() => page().token, (said) => {
      this._chart.takeStill(said);
      page().redraw();
    });
    this._ghost = new GhostBox(page, plan, (ghost) => {
      this._chart.ghost = ghost;
    }, (t) => {
      this._chart.time = t;
    });
    this._differing = new Differing(page, plan);
    this._importing = new Importing(page, (text, source, notes) => this._open(text, source, notes));
    this._tools = this._makeTools();
    this._says = el('p', { class: 'plan-says', role: 'status', tabindex: '0' });
    this._notes = el('ul', { class: 'notes' });
    root.replaceChildren(el('div', { class: 'tools' }, ...Object.values(this._tools).map((t) => t.root),
      this._says), this._importing.root,
      el('div', { class: 'sides' }, this._editor.root, this._chart.root),
      el('div', { class: 'below' }, el('div', {}, this._findings.root, this._notes), this._ghost.root,
        this._differing.root));
    this._listen();
  }

  _makeTools() {
    const button = (/** @type {() => void} */ act) => {
      const made = el('button', { type: 'button', onclick: act });
      return { root: made, face: made };
    };
    this._template.addEventListener('change', () => this._choose());
    const file = el('input', { type: 'file', class: 'unseen' });
    file.addEventListener('change', () => {
      const [one] = file.files ?? [];
      if (one) void this._importing.open(one);
      file.value = '';
    });
    const fileName = el('span');
    this._kind.replaceChildren(...KINDS.map((one) => el('option', { value: one })));
    return {
      template: { root: this._template, face: this._template },
      open: { root: el('label', { class: 'file' }, fileName, file), face: fileName },
      save: button(() => this._save()),
      undo: button(() => this._editor.undo()),
      redo: button(() => this._editor.redo()),
      kind: { root: this._kind, face: this._kind },
      add: button(() => {
        this._chart.isAdding = !this._chart.isAdding;
        this._page().redraw();
      }),
      remove: button(() => void this._edit({ do: 'remove', at: this._chart.chosen })),
      upload: { root: this._confirm.button, face: this._confirm.button },
    };
  }

  _listen() {
    const root = this._root;
    root.addEventListener('keydown', (event) => {
      const key = event.key.toLowerCase();
      if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
      if (event.target instanceof HTMLInputElement) return;
      if (key === 'z' && !event.shiftKey) this._editor.undo();
      else if (key === 'y' || key === 'z') this._editor.redo();
      else if (key === 's') this._save();
      else return;
      event.preventDefault();
    });
    root.addEventListener('dragover', (event) => event.preventDefault());
    root.addEventListener('drop', (event) => {
      event.preventDefault();
      event.stopPropagation();
      const [file] = event.dataTransfer?.files ?? [];
      if (file) void this._importing.open(file);
    });
  }

  // --- show ---

  /** @param {Page} page @param {number} now ms */
  show(page, now) {
    const isSeen = this._root.clientHeight > 0;
    document.body.classList.toggle('planning', isSeen);
    if (!isSeen) return;
    if (!this._isStarted) void this._start();
    this._showTools(now);
    this._importing.show(now);
    this._editor.show();
    this._chart.show();
    this._findings.show(this._judged === this._editor.text, now);
    this._ghost.show();
    this._differing.show(this._judged === this._editor.text ? this._said : null);
    const fate = page.chosen.intents.last('upload');
    if (fate && fate.since > now - 8000 && !this._problem) {
      say(this._says, `${word('upload')}: ${word(fate.is)} ${fate.says}`);
    } else say(this._says, this._problem);
    mark(this._says, 'data-level', this._problem ? 'bad' : null);
  }

  /** @param {number} now ms */
  _showTools(now) {
    const { open, save, undo, redo, add, remove } = this._tools;
    say(open.face, word('choose_file'));
    say(save.face, word('plan_save'));
    say(undo.face, word('plan_undo'));
    say(redo.face, word('plan_redo'));
    say(add.face, word(this._chart.isAdding ? 'plan_press' : 'plan_add'));
    say(remove.face, word('plan_remove'));
    undo.face.disabled = !this._editor.history.canUndo;
    redo.face.disabled = !this._editor.history.canRedo;
    remove.face.disabled = !this._chart.places[this._chart.chosen];
    mark(add.face, 'aria-pressed', String(this._chart.isAdding));
    mark(this._template, 'aria-label', word('plan_template'));
    mark(this._kind, 'aria-label', word('plan_kind'));
    for (const option of this._kind.options) say(option, word(`plan_${option.value}`));
    const first = this._template.options[0];
    if (first) say(first, word('plan_template'));
    this._confirm.show(now);
    this._confirm.button.hidden = !isLive(this._page().chosen.vehicle);
  }

  /** @param {string} says @param {number} moved ms */
  _upload(says, moved) {
    const mission = { text: this._judged, source: this._source };
    this._page().chosen.intents.command('upload', says, mission, moved);
    this._page().redraw();
  }

  _uploadSays() {
    const said = this._said;
    if (!said?.ok || this._judged !== this._editor.text) return '';
    const { vehicle } = this._page().chosen;
    return word('will_upload', `${said.name} ${said.digest.slice(0, 8)}`, vehicle.setup.name);
  }

  // --- the text ---

  async _start() {
    this._isStarted = true;
    const { token } = this._page();
    const kept = JSON.parse(sessionStorage.getItem(KEPT) ?? 'null');
    if (kept?.text && !this._editor.text) this._open(kept.text, kept.source, []);
    this._editor.words = await ask('/api/words', token).catch(() => []);
    this._missions = await ask('/api/missions', token).catch(() => []);
    this._template.replaceChildren(el('option', { value: '' }),
      ...this._missions.map((m) => el('option', { value: m.name }, m.name)));
    this._page().redraw();
  }

  _choose() {
    const found = this._missions.find((m) => m.name === this._template.value);
    this._template.value = '';
    if (found) this._open(found.text, `${found.name}.yaml`, []);
  }

  /** Open another mission, as one step that can be undone. @param {string} text @param {string} source
   * @param {string[]} notes */
  _open(text, source, notes) {
    this._problem = '';
    this._editor.put(text.replaceAll('\r\n', '\n'), 0, { source, notes });
  }

  _save() {
    const url = URL.createObjectURL(new Blob([this._editor.text], { type: 'text/plain' }));
    const name = /\.(ya?ml|mission)$/i.test(this._source) ? this._source : `${this._source}.yaml`;
    el('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), AGAIN_MS);
  }

  _changed() {
    const { text } = this._editor;
    this._come();
    this._editor.isYaml = !/\.mission$/i.test(this._source) || /^(mission|legs)\s*:/m.test(text);
    if (text !== this._judged) {
      this._ghost.forget();
      this._still.forget();
      this._differing.forget();
    }
    if (text.length < MOST_KEPT) sessionStorage.setItem(KEPT, JSON.stringify({ text, source: this._source }));
    else sessionStorage.removeItem(KEPT); // else an older text would come back
    void this._check();
    this._page().redraw();
  }

  /** Another mission than before: one was opened, or that was undone. */
  _come() {
    const { of = NEW } = this._editor.history.now;
    if (of === this._origin) return;
    this._origin = of;
    this._source = of.source;
    this._isNew = true;
    this._notes.replaceChildren(...of.notes.map((line) => el('li', {}, word('plan_left_out', line))));
  }

  /** Check the newest text; one check at a time. */
  _check() {
    this._checking ??= this._checkAll().finally(() => {
      this._checking = null;
    });
    return this._checking;
  }

  async _checkAll() {
    while (this._judged !== this._editor.text) {
      const { text } = this._editor;
      if (isTooLarge({ text, source: this._source })) {
        this._leave(text);
        this._tell(word('too_large', this._source));
      } else try {
        this._take(text, await ask('/api/check', this._page().token, { text, source: this._source }));
      } catch (error) {
        this._tell(error);
        if (error instanceof Refused) this._leave(text); // asking again is useless
        else await new Promise((again) => setTimeout(again, AGAIN_MS));
      }
    }
  }

  /** @param {string} text @param {any} said */
  _take(text, said) {
    this._said = said;
    this._judged = text;
    this._problem = '';
    if (text === this._editor.text) {
      this._chart.take(said, this._isNew);
      if (said.ok) this._still.want({ text, source: this._source });
      else if (said.digest) this._still.refuse(word('still_refused'));
      this._isNew = false;
      this._editor.names = said.names;
      this._editor.judge(said.refusals.filter((/** @type {any} */ one) => one.line));
      this._findings.take(said);
      this._mark();
    }
    this._page().redraw();
  }

  /** The check does not accept this text: remove all results of earlier ones. @param {string} text */
  _leave(text) {
    [this._judged, this._said] = [text, null];
    this._chart.take({}, true);
    this._editor.names = [];
    this._editor.judge([]);
    this._findings.take(null);
    this._mark();
  }

  /** Choose the place whose line the caret is in. */
  _caretMoved() {
    if (this._judged !== this._editor.text || document.activeElement !== this._editor.area) return;
    const { line } = this._editor;
    const places = this._chart.places;
    const now = places[this._chart.chosen];
    if (now?.spans.some((span) => span[0] === line)) return;
    this._chart.choose(places.findIndex((one) => one.spans.some((span) => span[0] === line)));
    this._mark();
    this._page().redraw();
  }

  _mark() {
    this._editor.choose(this._chart.places[this._chart.chosen]?.spans ?? []);
  }

  // --- the chart ---

  /** @param {Pair} to */
  async _add(to) {
    const what = this._kind.value;
    const chosen = this._chart.places[this._chart.chosen];
    const after = chosen && chosen.kind !== 'home' ? { at: this._chart.chosen } : {};
    await this._edit({ do: 'add', what, to, ...after }, to);
  }

  /** @param {object} edit @param {Pair} [fresh] the place that will be there then */
  async _edit(edit, fresh) {
    const { text } = this._editor;
    if (this._judged !== text) return this._tell(word('plan_changed')); // the places are of another text
    try {
      const found = await want('/api/edit', this._page().token, { text, source: this._source, ...edit });
      if (this._editor.text !== text) return this._tell(word('plan_changed'));
      this._problem = '';
      this._editor.put(found.text);
      await this._check();
      if (fresh) this._chooseAt(fresh);
    } catch (error) {
      this._tell(error);
    }
    this._page().redraw();
  }

  /** @param {Pair} at */
  _chooseAt(at) {
    const far = this._chart.places.map((one) => (one.at ? Math.hypot(one.at[0] - at[0], one.at[1] - at[1]) : Infinity));
    this._chart.choose(far.indexOf(Math.min(...far)));
    this._mark();
  }

  /** @param {unknown} error */
  _tell(error) {
    this._problem = error instanceof Error ? error.message : String(error);
    this._page().redraw();
  }
}

/** Larger than the server accepts. @param {{text: string, source: string}} mission */
export function isTooLarge(mission) {
  const size = () => new TextEncoder().encode(JSON.stringify(mission)).length;
  return mission.text.length * MOST_ESCAPED > MOST_SAID && size() > MOST_SAID;
}

/** The room, at its place on the page. @param {() => Page} page
 * @param {import('./charts.js').Charts} charts */
export function planRoom(page, charts) {
  return new Plan(byId('planner'), page, charts);
}
