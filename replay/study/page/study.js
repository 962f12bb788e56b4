'use strict';
// The page: start, pairs, end. Both faces of a pair follow one clock.

const kRestBeforeS = 0.5, kRestAfterS = 0.7, kPauseS = 0.25;  // held at the first frame, at the last; between pairs

const element = (id) => document.getElementById(id);
const dataOf = (id) => JSON.parse(element(id).textContent);

/** localStorage, or null where the browser forbids it. */
function storageOf() {
  try {
    return window.localStorage ?? null;
  } catch {
    return null;
  }
}

/** Two clips side by side, played together. Times in seconds of performance.now(). */
class Player {
  constructor(face, rateHz) {
    this.rateHz = rateHz;
    this.views = ['left-face', 'right-face'].map((id) => new FaceView(element(id), face));
    this.poses = this.views.map(() => new FacePose(face));
    this.row = new Float32Array(face.aus.length);
    this.clips = null;
    this.shownFrame = -1;
  }

  start(left, right, nowS) {
    this.clips = [left, right];
    this.replay(nowS);
  }

  replay(nowS) {
    this.beganS = nowS;
    this.shownFrame = -1;
  }

  get motionS() { return (this.clips[0].frames - 1) / this.rateHz; }

  /** Draws the moment; true once the clips are over. */
  show(nowS) {
    const sinceS = nowS - this.beganS;
    const frame = Math.max(0, Math.min(this.motionS, sinceS - kRestBeforeS)) * this.rateHz;
    if (frame !== this.shownFrame) this.draw(frame);
    return sinceS >= kRestBeforeS + this.motionS + kRestAfterS;
  }

  draw(frame) {
    this.views.forEach((view, side) => {
      this.poses[side].set(this.clips[side].at(frame, this.row));
      view.draw(this.poses[side]);
    });
    this.shownFrame = frame;
  }
}

class StudyPage {
  constructor() {
    const study = dataOf('study-data');
    const key = JSON.parse(new TextDecoder().decode(bytesOf(study.key)));
    const face = new Face(dataOf('face-data'));
    this.clips = study.clips.map((clip) => new Clip(clip, face.aus.length, study.full_scale));
    this.answers = new StudyAnswers(key, storageOf());
    this.player = new Player(face, study.rate_hz);
    this.state = 'start';  // 'playing', 'played' (an answer may be given), 'pause', 'end'
    this.#listen();
    this.#showStart();
    requestAnimationFrame(() => this.#tick());
  }

  #listen() {
    element('enter').addEventListener('submit', (event) => {
      event.preventDefault();
      this.#begin();
    });
    for (const choice of kAnswers) element('answer-' + choice).addEventListener('click', () => this.#answer(choice));
    element('again').addEventListener('click', () => this.#again());
    element('download').addEventListener('click', () => this.#download());
    element('copy').addEventListener('click', () => this.#copy());
    element('next').addEventListener('click', () => this.#nextParticipant());
    document.addEventListener('keydown', (event) => this.#key(event));
    window.addEventListener('resize', () => { this.player.shownFrame = -1; });
  }

  #key(event) {
    if (!this.#isTask() || event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
    const choice = { ArrowLeft: 'left', ArrowRight: 'right', ArrowDown: 'same' }[event.key];
    if (choice === undefined && event.key !== ' ') return;
    event.preventDefault();  // no scrolling, no button pressed besides
    if (choice === undefined) this.#again();
    else this.#answer(choice);
  }

  #isTask() { return this.state === 'playing' || this.state === 'played' || this.state === 'pause'; }

  #show(section) {
    for (const id of ['start', 'task', 'end']) element(id).hidden = id !== section;
  }

  #showStart() {
    const { answers } = this;
    this.state = 'start';
    element('count').textContent = String(answers.count);
    element('participant').value = answers.participant;
    element('consent').checked = false;
    element('problem').textContent = answers.keepsAnswers ? '' :
      'This browser keeps no answers: please do not reload or close the page before the end.';
    if (answers.participant !== '') {
      element('problem').textContent = answers.isComplete ? 'All pairs are answered.' :
        `Welcome back: ${answers.done} of ${answers.count} pairs are answered.`;
    }
    element('begin').textContent = answers.participant === '' ? 'Begin' : 'Go on';
    this.#show('start');
  }

  #begin() {
    const participant = element('participant').value.trim();
    const problem = StudyAnswers.problemOf(participant) ||
      (element('consent').checked ? '' : 'Please agree by the tick, or close the page.');
    element('problem').textContent = problem;
    if (problem !== '') return;
    this.answers.begin(participant);
    this.#nextTrial();
  }

  #nextTrial() {
    const { answers, player } = this;
    if (answers.isComplete) {
      this.#showEnd();
      return;
    }
    this.#show('task');
    element('progress').textContent = `Pair ${answers.done + 1} of ${answers.count}`;
    element('bar').style.width = `${100 * answers.done / answers.count}%`;
    const nowS = performance.now() / 1000;
    player.start(this.clips[answers.trial.left_clip], this.clips[answers.trial.right_clip], nowS);
    this.shownS = nowS;
    this.replays = 0;
    this.#allowAnswers(false);
    this.state = 'playing';
  }

  /** Only once the pair was seen to its end. */
  #allowAnswers(isAllowed) {
    for (const id of [...kAnswers.map((choice) => 'answer-' + choice), 'again']) element(id).disabled = !isAllowed;
    element('hint').textContent = isAllowed ? '' : 'Watch both to the end first.';
  }

  #again() {
    if (this.state !== 'played') return;
    this.#replay();
  }

  #replay() {
    ++this.replays;
    this.player.replay(performance.now() / 1000);
  }

  #answer(choice) {
    if (this.state !== 'played') return;
    const nowS = performance.now() / 1000;
    this.answers.answer(choice, nowS - this.shownS, this.replays);
    this.#allowAnswers(false);
    element('hint').textContent = '';
    this.state = 'pause';
    this.pauseEndsS = nowS + kPauseS;
  }

  #tick() {
    const nowS = performance.now() / 1000;
    if (this.state === 'pause' && nowS >= this.pauseEndsS) this.#nextTrial();
    if (this.state === 'playing' || this.state === 'played') {
      const isOver = this.player.show(nowS);
      if (isOver && this.state === 'playing') {
        this.state = 'played';
        this.#allowAnswers(true);
      }
      if (isOver && element('loop').checked) this.#replay();
    }
    requestAnimationFrame(() => this.#tick());
  }

  #showEnd() {
    this.state = 'end';
    element('csv').value = this.answers.csv();
    this.#show('end');
    this.#download();
  }

  #download() {
    const link = document.createElement('a');
    link.href = 'data:text/csv;charset=utf-8,' + encodeURIComponent(this.answers.csv());
    link.download = `answers-${this.answers.key.page}-${this.answers.participant}.csv`;
    link.click();
  }

  #copy() {
    element('csv').select();
    document.execCommand('copy');  // navigator.clipboard is not there for pages opened from a file
  }

  #nextParticipant() {
    this.answers.leave();
    element('csv').value = '';
    this.#showStart();
  }
}

try {
  new StudyPage();
} catch (error) {
  element('problem').textContent = error.message;
  element('begin').disabled = true;
}
