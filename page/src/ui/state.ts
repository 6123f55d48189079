// What is shown: the instant, the stretch of time of the lanes, the speed, the miss that was chosen. One place, and its listeners.

export type Part = "now" | "view" | "playing" | "speed" | "miss" | "theme" | "options";

export const SPEEDS = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100];
const SHORTEST_VIEW = 2e-6; // s
const STEP = 0.5; // s between two steps where little motion is wanted

export class State {
  now: number;
  from: number;
  to: number;
  playing = false;
  speed = 1;
  miss = -1; // run of the job
  options = { rays: true, ghost: true, path: true };
  readonly still: boolean; // the reader wants little motion: playing moves in steps and does not glide
  private owed = 0; // s of the reader's that have passed since the last step
  private readonly listeners: ((part: Part) => void)[] = [];

  private readonly last: number; // the end of the longest view

  constructor(readonly begin: number, readonly end: number) {
    this.now = this.from = begin;
    this.to = this.last = Math.max(end, begin + SHORTEST_VIEW);
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  }

  listen(listener: (part: Part) => void): void {
    this.listeners.push(listener);
  }

  tell(part: Part): void {
    for (const listener of this.listeners) listener(part);
  }

  seek(time: number): void {
    const now = Math.min(this.end, Math.max(this.begin, time));
    if (now === this.now) return;
    this.now = now;
    this.tell("now");
  }

  /** The view that is possible and nearest. Where it touches an end of the run it is that end, without rounding. */
  show(from: number, to: number): void {
    const { begin, last } = this, width = this.possible(to - from);
    let [left, right] = width === to - from ? [from, to] : [(from + to - width) / 2, (from + to + width) / 2];
    if (width >= last - begin) [left, right] = [begin, last];
    else if (right >= last) [left, right] = [last - width, last];
    else if (left <= begin) [left, right] = [begin, begin + width];
    if (left === this.from && right === this.to) return;
    this.from = left;
    this.to = right;
    this.tell("view");
  }

  /** `factor` below 1 shows less; `around` stays where it is. */
  zoom(factor: number, around: number): void {
    const width = this.to - this.from, by = this.possible(width * factor) / width;
    this.show(around - (around - this.from) * by, around + (this.to - around) * by);
  }

  private possible(width: number): number {
    return Math.min(this.last - this.begin, Math.max(SHORTEST_VIEW, width));
  }

  pan(by: number): void {
    this.show(this.from + by, this.to + by);
  }

  whole(): void {
    this.show(this.begin, this.end);
  }

  /** Turns the leaf when the instant has left the view. */
  follow(): void {
    const width = this.to - this.from;
    if (this.now < this.from || this.now > this.to) this.show(this.now - 0.05 * width, this.now + 0.95 * width);
  }

  play(playing: boolean): void {
    if (playing && this.now >= this.end) this.seek(this.begin);
    this.playing = playing;
    this.owed = 0;
    this.tell("playing");
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.tell("speed");
  }

  choose(run: number): void {
    this.miss = run;
    this.tell("miss");
  }

  set(option: keyof State["options"], value: boolean): void {
    this.options[option] = value;
    this.tell("options");
  }

  /** Moves on by so many seconds of the reader's. */
  advance(seconds: number): void {
    if (!this.playing) return;
    this.owed += seconds;
    if (this.still && this.owed < STEP) return;
    this.seek(this.now + this.owed * this.speed);
    this.owed = 0;
    if (this.now >= this.end) this.play(false);
    this.follow();
  }
}
