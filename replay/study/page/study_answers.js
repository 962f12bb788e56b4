'use strict';
// Who takes part and what was answered so far. Kept in the browser's storage after every answer, so that a reload loses
// nothing; at the end a CSV. No document.

const kColumns = ['page', 'seed', 'participant', 'pair', 'transition', 'left', 'right', 'answer', 'seconds', 'replays'];
const kAnswers = ['left', 'right', 'same'];

/** Quoted where commas, quotes or line ends make it necessary. */
function csvCell(value) {
  const text = String(value);
  return /[",;\t\r\n]|^\s|\s$/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
}

class StudyAnswers {
  /** `key`: the page's pairs and what they are. `storage`: like localStorage, or null. */
  constructor(key, storage) {
    this.key = key;
    this.storage = storage;
    this.place = 'risorius-study-' + key.page;  // of the present participant's code; answers: place-CODE
    this.keepsAnswers = storage !== null;
    this.participant = '';
    this.answers = [];
    const participant = this.#kept(this.place);
    if (typeof participant === 'string' && StudyAnswers.problemOf(participant) === '') this.begin(participant);
  }

  get count() { return this.key.trials.length; }
  get done() { return this.answers.length; }
  get isComplete() { return this.done === this.count; }
  /** The pair to be shown next. */
  get trial() { return this.key.trials[this.done]; }

  /** What is wrong with a participant's code, or '' if nothing is. */
  static problemOf(participant) {
    if (participant === '') return 'Please enter the code that you were given.';
    if (!/^[A-Za-z0-9_-]{1,32}$/.test(participant)) return 'A code has letters, digits, - and _ only.';
    return '';
  }

  /** Goes on where the participant of this code was, or begins. */
  begin(participant) {
    this.participant = participant;
    const kept = this.#kept(`${this.place}-${participant}`);
    this.answers = this.#areAnswers(kept) ? kept : [];
    this.#keep(this.place, participant);
  }

  answer(choice, seconds, replays) {
    if (!kAnswers.includes(choice) || this.isComplete) throw new Error('no answer is due: ' + choice);
    this.answers.push({ choice, seconds, replays });
    this.#keep(`${this.place}-${this.participant}`, this.answers);
  }

  /** For the next participant; the answers of this one stay. */
  leave() {
    this.participant = '';
    this.answers = [];
    this.#keep(this.place, '');
  }

  csv() {
    const rows = this.answers.map((answer, i) => {
      const trial = this.key.trials[i];
      return [this.key.page, this.key.seed, this.participant, i + 1, trial.transition, trial.left, trial.right,
        answer.choice, answer.seconds.toFixed(3), answer.replays];
    });
    return [kColumns, ...rows].map((row) => row.map(csvCell).join(',') + '\n').join('');
  }

  #areAnswers(kept) {
    const isWhole = (one) => kAnswers.includes(one?.choice) && Number.isFinite(one.seconds) && one.seconds >= 0 &&
      Number.isInteger(one.replays) && one.replays >= 0;
    return Array.isArray(kept) && kept.length <= this.count && kept.every(isWhole);
  }

  #keep(place, value) {
    try {
      this.storage?.setItem(place, JSON.stringify(value));
    } catch {
      this.keepsAnswers = false;  // full, or forbidden
    }
  }

  /** Null where nothing is kept, or nothing of ours. */
  #kept(place) {
    try {
      return JSON.parse(this.storage?.getItem(place) ?? 'null');
    } catch {
      return null;
    }
  }
}
