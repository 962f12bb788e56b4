// Takes part in a study without a browser: node take_part.mjs PAGE.html ANSWERS.csv. Runs the page's own scripts in a
// document of stubs, answers left, right, same in turn (every fourth pair after playing it again), reloads the page in
// the middle, and writes the CSV that the page offers. Prints what it saw as JSON.
import { readFileSync, writeFileSync } from 'node:fs';
import vm from 'node:vm';

const [pagePath, answersPath] = process.argv.slice(2);
const html = readFileSync(pagePath, 'utf8');
const kReloadAfter = 7;
const kFrameMs = 100;  // a slow browser: every frame moves and shades two faces
const kKeys = { 0: 'ArrowLeft', 1: 'ArrowRight', 2: 'ArrowDown' };

const seen = { texts: new Set(), downloads: [] };
const kept = new Map();  // of the browser, over reloads

/** Answers every question of the drawing code. */
const gl = new Proxy({}, {
  get: (_, name) => ({
    getProgramParameter: () => true,
    getAttribLocation: () => 0,
    isContextLost: () => false,
  })[name] ?? (/^[A-Z_]+$/.test(name) ? 0 : () => ({})),
});

class Element {
  constructor(id) {
    this.id = id;
    this.listeners = {};
    this.style = {};
    this.textContent = '';
    this.value = '';
    this.checked = false;
    this.disabled = false;
    this.hidden = false;
    this.clientWidth = 400;
    this.clientHeight = 400;
  }
  addEventListener(type, listener) { (this.listeners[type] ??= []).push(listener); }
  send(type, event = {}) {
    for (const listener of this.listeners[type] ?? []) listener({ preventDefault() {}, ...event });
  }
  click() {
    if (this.download) seen.downloads.push({ name: this.download, href: this.href });
    else if (!this.disabled) this.send('click');
  }
  getContext() { return gl; }
  select() {}
}

class Browser {
  constructor() {
    this.nowMs = 1000;
    this.frames = [];
    this.keys = new Element('document');
    this.elements = new Map();
    for (const [, id] of html.matchAll(/\bid="([^"]+)"/g)) this.elements.set(id, new Element(id));
    for (const [, id, text] of html.matchAll(/<script type="application\/json" id="([^"]+)">([^<]*)<\/script>/g))
      this.elements.get(id).textContent = text;
    const localStorage = {
      getItem: (name) => kept.get(name) ?? null,
      setItem: (name, value) => kept.set(name, value),
    };
    const document = {
      getElementById: (id) => this.elements.get(id) ?? null,
      createElement: (tag) => new Element(tag),
      addEventListener: (type, listener) => this.keys.addEventListener(type, listener),
      execCommand: () => true,
    };
    this.context = vm.createContext({
      document, atob, TextDecoder,
      window: { devicePixelRatio: 2, localStorage, addEventListener() {} },
      performance: { now: () => this.nowMs },
      requestAnimationFrame: (callback) => this.frames.push(callback),
    });
    for (const [, script] of html.matchAll(/<script>([\s\S]*?)<\/script>/g)) vm.runInContext(script, this.context);
  }
  get(id) { return this.elements.get(id); }
  run(seconds) {
    for (const end = this.nowMs + 1000 * seconds; this.nowMs < end; this.nowMs += kFrameMs) {
      for (const callback of this.frames.splice(0)) callback();
      if (!this.get('end').hidden) continue;
      for (const [id, element] of this.elements) {
        if (!id.endsWith('-data')) seen.texts.add(`${element.textContent}|${element.value}`);
      }
    }
  }
  /** Until answers are allowed. */
  watch() {
    for (let tries = 0; this.get('answer-left').disabled; ++tries) {
      if (tries > 200) throw new Error('no answer is ever allowed: ' + this.get('problem').textContent);
      this.press('ArrowLeft');  // too early: must not count
      this.run(0.1);
    }
  }
  press(key) { this.keys.send('keydown', { key }); }
  begin(code, agrees) {
    this.get('participant').value = code;
    this.get('consent').checked = agrees;
    this.get('enter').send('submit');
    return this.get('problem').textContent;
  }
}

function answer(browser, from, to) {
  for (let i = from; i < to; ++i) {
    browser.watch();
    if (i % 4 === 0) {
      browser.press(' ');
      browser.run(0.5);
    }
    browser.press(kKeys[i % 3]);
    browser.run(0.4);
  }
}

const first = new Browser();
seen.without_code = first.begin('', true);
seen.bad_code = first.begin('a,b', true);
seen.without_consent = first.begin('P-07', false);
first.begin('P-07', true);
answer(first, 0, kReloadAfter);

const second = new Browser();
seen.welcome = second.get('problem').textContent;
seen.reloaded_at = vm.runInContext(`JSON.parse(window.localStorage.getItem(
  'risorius-study-' + dataOf('study-data').page + '-P-07')).length`, second.context);
second.begin(second.get('participant').value, true);
const count = vm.runInContext(
  `JSON.parse(new TextDecoder().decode(bytesOf(dataOf('study-data').key))).trials.length`, second.context);
answer(second, kReloadAfter, count);
if (second.get('end').hidden) throw new Error('the end is not shown');

const offered = seen.downloads.at(-1);
const csv = decodeURIComponent(offered.href.slice(offered.href.indexOf(',') + 1));
writeFileSync(answersPath, csv);
seen.file = offered.name;
seen.page = vm.runInContext(`dataOf('study-data').page`, second.context);
seen.shown_for_copying = second.get('csv').value === csv;
second.get('next').click();
seen.after_next = second.get('participant').value;

seen.places = vm.runInContext(`(() => {
  const study = dataOf('study-data'), face = new Face(dataOf('face-data')), pose = new FacePose(face);
  const row = new Float32Array(face.aus.length);
  pose.set(new Clip(study.clips[0], row.length, study.full_scale).at(40, row));
  const places = [];
  for (let v = 0; v < face.count; v += 7)
    places.push([...face.rest.slice(3 * v, 3 * v + 3), ...pose.positions.slice(3 * v, 3 * v + 3)]);
  return places;
})()`, second.context);
console.log(JSON.stringify({ ...seen, texts: [...seen.texts], downloads: undefined }));
