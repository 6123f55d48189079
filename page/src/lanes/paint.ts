// Paints lanes of a canvas: shares by column as stacked colours, segments as boxes, deadlines as marks.
import { exactShares, FAILED, type Pyramid } from "../data/lanes";
import { due, during, met, type Jobs } from "../data/jobs";
import { before, WAITS, type Bus, type Lane, type Runs } from "../data/recording";
import { GROUP_ASLEEP, GROUP_AWAKE, GROUP_FAILED, GROUPS, OKABE_ITO, rgb, WAIT_COLOURS, type Theme } from "../ui/colours";

export interface Stretch {
  from: number;
  to: number;
}

/** The place of a row on the canvas, in its dots. */
export interface Place {
  left: number;
  width: number;
  top: number;
  height: number;
}

const SEEN = 4; // dots that work gets at least
const FOOT = 0.27; // of a lane's height, for its waits
const WAITS_FULL = 0.05; // of the time: the meaning of the foot's full height

type Context = CanvasRenderingContext2D;

// Bottom to top: work that is short and often below, sleep above.
const STACK = [4, 5, 6, 7, 8, 9, 10, 3, 1, 0, 2];

export class LanePainter {
  private shares = new Float32Array(0);
  private image: ImageData | null = null;
  private hatch: CanvasPattern | null = null;

  constructor(private readonly groupOf: Uint8Array, private theme: Theme) {}

  dress(theme: Theme): void {
    this.theme = theme;
    this.hatch = null;
  }

  /** What the DSP did, and at its foot what it waited for. */
  lane(context: Context, place: Place, view: Stretch, lane: Lane, pyramid: Pyramid): void {
    const perColumn = (view.to - view.from) / place.width, foot = Math.round(place.height * FOOT);
    const first = Math.max(0, before(lane.from, view.from)), last = before(lane.from, view.to);
    const body = { ...place, height: place.height - foot - 1 }, below = { ...place, top: place.top + place.height - foot, height: foot };
    const width = Math.round(place.width), columns = GROUPS.length + WAITS.length;
    if (this.shares.length < width * columns) this.shares = new Float32Array(width * columns);
    const shares = this.shares.subarray(0, width * columns);
    if (perColumn >= pyramid.width) pyramid.shares(view.from, perColumn, width, shares);
    else exactShares(lane, this.groupOf, GROUPS.length, view.from, perColumn, width, shares);
    if (last - first < place.width / 3) this.segments(context, body, view, lane, first, last);
    else this.stacked(context, body, view, lane, shares);
    this.waits(context, below, shares);
  }

  /** Shares of the time that went into waiting, by cause. Where they are more than its full height means, they fill the foot. */
  private waits(context: Context, place: Place, shares: Float32Array): void {
    const width = Math.round(place.width), height = Math.round(place.height), columns = GROUPS.length + WAITS.length;
    const dots = this.dots(context, width, height), colours = WAIT_COLOURS.map(packed), ground = packed(this.theme.groups[GROUP_ASLEEP]);
    for (let x = 0; x < width; ++x) {
      const at = x * columns + GROUPS.length;
      let all = 0, y = height, sum = 0;
      for (let cause = 0; cause < WAITS.length; ++cause) all += shares[at + cause];
      const scale = height / Math.max(WAITS_FULL, all);
      for (let cause = 0; cause < WAITS.length; ++cause) {
        sum += shares[at + cause] * scale;
        const upTo = Math.max(0, Math.round(height - sum - (cause === 0 && all > 0.002 ? 0.5 : 0))); // a little is seen
        for (; y > upTo; --y) dots[(y - 1) * width + x] = colours[cause];
      }
      for (; y > 0; --y) dots[(y - 1) * width + x] = ground;
    }
    context.putImageData(this.image!, Math.round(place.left), Math.round(place.top));
  }

  private stacked(context: Context, place: Place, view: Stretch, lane: Lane, shares: Float32Array): void {
    const groups = GROUPS.length + WAITS.length, width = Math.round(place.width), height = Math.round(place.height);
    const dots = this.dots(context, width, height), colours = this.theme.groups.map(packed);
    for (let x = 0; x < width; ++x) {
      let sum = 0, y = height, busy = 0;
      for (let group = GROUP_AWAKE; group < GROUPS.length; ++group) busy += shares[x * groups + group];
      const scale = busy > 0 ? Math.max(1, SEEN / (busy * height)) : 1; // a little is seen to be something
      for (const group of STACK) {
        const share = shares[x * groups + group];
        if (share <= 0) continue;
        sum += group >= GROUP_AWAKE ? share * scale : share;
        const upTo = Math.max(0, Math.round(height * (1 - sum)));
        for (; y > upTo; --y) dots[(y - 1) * width + x] = colours[group];
      }
      for (; y > 0; --y) dots[(y - 1) * width + x] = sum > 0.5 ? colours[GROUP_ASLEEP] : 0;
    }
    context.putImageData(this.image!, Math.round(place.left), Math.round(place.top));
    this.failures(context, place, view, lane);
  }

  private segments(context: Context, place: Place, view: Stretch, lane: Lane, first: number, last: number): void {
    const scale = place.width / (view.to - view.from);
    for (let i = first; i <= last; ++i) {
      const upTo = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end;
      const left = Math.max(place.left, place.left + (lane.from[i] - view.from) * scale);
      const right = Math.min(place.left + place.width, place.left + (upTo - view.from) * scale);
      const group = this.groupOf[lane.what[i]], run = lane.run[i] >= 0;
      context.fillStyle = this.theme.groups[group];
      const inset = group === GROUP_AWAKE ? place.height * 0.25 : 0;
      context.fillRect(left, place.top + inset, Math.max(1, right - left), place.height - 2 * inset);
      if (group === GROUP_FAILED) this.dead(context, place, left, right);
      if (run && right - left > 3) {
        context.fillStyle = this.theme.panel;
        context.fillRect(right - 1, place.top, 1, place.height);
      }
    }
  }

  /** Names in the boxes that have room for them. */
  names(context: Context, place: Place, view: Stretch, lane: Lane, runs: Runs, kinds: string[], dots: number): void {
    const first = Math.max(0, before(lane.from, view.from)), last = before(lane.from, view.to);
    if (last - first > place.width / (30 * dots)) return;
    const scale = place.width / (view.to - view.from);
    context.font = `${11 * dots}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    for (let i = first; i <= last; ++i) {
      if (lane.run[i] < 0) continue;
      const upTo = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end;
      const left = Math.max(place.left, place.left + (lane.from[i] - view.from) * scale);
      const right = Math.min(place.left + place.width, place.left + (upTo - view.from) * scale);
      const text = `${kinds[runs.kind[lane.run[i]]].split(".")[0].replaceAll("_", " ")} ${runs.number[lane.run[i]]}`;
      if (context.measureText(text).width + 8 * dots > right - left) continue;
      const [r, g, b] = rgb(this.theme.groups[this.groupOf[lane.what[i]]]);
      context.fillStyle = 0.299 * r + 0.587 * g + 0.114 * b > 120 ? "#000000" : "#ffffff";
      context.fillText(text, left + 4 * dots, place.top + (place.height * (1 - FOOT)) / 2);
    }
  }

  /** Also where it is too short for the stack: a dead DSP is seen. */
  private failures(context: Context, place: Place, view: Stretch, lane: Lane): void {
    const scale = place.width / (view.to - view.from);
    for (const i of this.deadSegments(lane)) {
      const upTo = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end;
      if (upTo < view.from || lane.from[i] > view.to) continue;
      const left = Math.max(place.left, place.left + (lane.from[i] - view.from) * scale);
      const right = Math.min(place.left + place.width, place.left + (upTo - view.from) * scale);
      context.fillStyle = this.theme.groups[GROUP_FAILED];
      context.fillRect(left, place.top, Math.max(3, right - left), place.height);
      this.dead(context, place, left, Math.max(left + 3, right));
    }
  }

  private readonly dying = new WeakMap<Lane, number[]>();
  private deadSegments(lane: Lane): number[] {
    let all = this.dying.get(lane);
    if (!all) {
      all = [];
      for (let i = 0; i < lane.what.length; ++i) if (lane.what[i] === FAILED) all.push(i);
      this.dying.set(lane, all);
    }
    return all;
  }

  private dead(context: Context, place: Place, left: number, right: number): void {
    if (!this.hatch) {
      const tile = document.createElement("canvas");
      tile.width = tile.height = 8;
      const ink = tile.getContext("2d")!;
      ink.strokeStyle = "rgba(0,0,0,.75)";
      ink.lineWidth = 1.5;
      ink.beginPath();
      for (const by of [-8, 0, 8]) ink.moveTo(by, 8), ink.lineTo(by + 8, 0);
      ink.stroke();
      this.hatch = context.createPattern(tile, "repeat");
    }
    context.fillStyle = this.hatch ?? "#000000";
    context.fillRect(left, place.top, right - left, place.height);
  }

  /** Deadlines of a kind: one by one where there is room, else how many were met and missed. */
  deadlines(context: Context, place: Place, view: Stretch, jobs: Jobs, runs: Runs, dots: number): void {
    const first = before(jobs.at, view.from) + 1, last = before(jobs.at, view.to);
    if (last - first < place.width / (7 * dots)) {
      this.eachDeadline(context, place, view, during(jobs, runs, view.from, view.to).map((i) => jobs.run[i]), runs, dots);
      return;
    }
    const middle = place.top + place.height / 2, band = Math.max(2 * dots, place.height * 0.35);
    context.fillStyle = this.theme.dark ? "#4b7f95" : "#5f93ab";
    this.columns(context, place, view, jobs.metAt, 1, middle - band / 2, band);
    context.fillStyle = this.theme.ink;
    this.columns(context, place, view, jobs.otherAt, 1, middle - dots / 2, dots);
    context.fillStyle = OKABE_ITO.vermillion;
    this.columns(context, place, view, jobs.missedAt, Math.max(2 * dots, 1), place.top, place.height);
  }

  /** A bar at every instant; those of columns that touch are one. */
  private columns(context: Context, place: Place, view: Stretch, at: Float64Array, wide: number, top: number, height: number): void {
    const scale = place.width / (view.to - view.from);
    let left = -1, right = -1;
    for (let i = before(at, view.from) + 1; i < at.length && at[i] <= view.to; ) {
      const column = Math.floor((at[i] - view.from) * scale);
      if (column > right) {
        if (right > left) context.fillRect(place.left + left, top, right - left, height);
        left = column;
      }
      right = column + wide;
      i = Math.max(i, before(at, view.from + (column + 1) / scale)) + 1;
    }
    if (right > left) context.fillRect(place.left + left, top, right - left, height);
  }

  /** From the release to the deadline a line. Where it was missed, a triangle at the deadline; else a dot at the job's end, hollow where no deadline was met. */
  private eachDeadline(context: Context, place: Place, view: Stretch, list: number[], runs: Runs, dots: number): void {
    const scale = place.width / (view.to - view.from), middle = place.top + place.height / 2;
    const x = (time: number): number => place.left + (time - view.from) * scale;
    const seen = (time: number): boolean => time >= view.from && time <= view.to;
    context.fillStyle = this.theme.soft;
    const line = (from: number, to: number): void => {
      const left = x(Math.max(view.from, from)), right = x(Math.min(view.to, to));
      if (right >= left) context.fillRect(left, middle - dots / 2, Math.max(dots, right - left), dots);
    };
    let from = Infinity, to = -Infinity; // lines that touch are one
    for (let i = list.length - 1; i >= 0; --i) {
      const run = list[i], until = due(runs, run);
      if (until < from && to >= from) line(from, to), (from = Infinity), (to = -Infinity);
      from = Math.min(from, runs.released[run]);
      to = Math.max(to, until);
      if (seen(runs.deadline[run])) context.fillRect(x(until) - dots, place.top + 2 * dots, 2 * dots, place.height - 4 * dots);
    }
    if (to >= from) line(from, to);
    const size = place.height / 2, round = Math.min(place.height / 3, 4 * dots);
    context.lineWidth = 1.5 * dots;
    context.strokeStyle = this.theme.ink;
    for (const run of list) {
      const missed = runs.missed[run], time = missed ? due(runs, run) : runs.ended[run], at = x(time);
      if (!seen(time)) continue;
      context.beginPath();
      if (missed) context.moveTo(at, place.top), context.lineTo(at + size * 0.8, place.top + place.height), context.lineTo(at - size * 0.8, place.top + place.height);
      else context.arc(at, middle, round, 0, 7);
      context.fillStyle = missed ? OKABE_ITO.vermillion : met(runs, run) ? OKABE_ITO.sky : this.theme.panel;
      context.fill();
      if (!missed && !met(runs, run)) context.stroke();
    }
  }

  /** How much of a bus each master uses, stacked; what is left is free. */
  bus(context: Context, place: Place, view: Stretch, bus: Bus, slice: number, begin: number, colours: string[], full: number): void {
    const count = bus.refused.length, width = Math.round(place.width), height = Math.round(place.height), perColumn = (view.to - view.from) / width;
    const dots = this.dots(context, width, height), inks = colours.map(packed), free = packed(this.theme.groups[GROUP_ASLEEP]);
    for (let x = 0; x < width; ++x) {
      const first = Math.max(0, Math.floor((view.from + x * perColumn - begin) / slice));
      const last = Math.min(count - 1, Math.max(first, Math.ceil((view.from + (x + 1) * perColumn - begin) / slice) - 1));
      let y = height, sum = 0;
      for (let m = 0; m < inks.length; ++m) {
        const { held } = bus.masters[m];
        for (let i = first; i <= last; ++i) sum += held[i] / (last - first + 1);
        for (const upTo = Math.max(0, Math.round(height * (1 - sum / (10 * full)))); y > upTo; --y) dots[(y - 1) * width + x] = inks[m];
      }
      for (; y > 0; --y) dots[(y - 1) * width + x] = free;
    }
    context.putImageData(this.image!, Math.round(place.left), Math.round(place.top));
  }

  /** An empty picture for the place of a row. */
  private dots(context: Context, width: number, height: number): Uint32Array {
    if (this.image?.width !== width || this.image.height !== height) this.image = context.createImageData(width, height);
    return new Uint32Array(this.image.data.buffer);
  }
}

function packed(hex: string): number {
  const [r, g, b] = rgb(hex);
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

/** The full height of a bus's row, in percent: the least round number that holds its busiest slice. */
export function fullScale(bus: Bus): number {
  let most = 0;
  for (let i = 0; i < bus.refused.length; ++i) most = Math.max(most, bus.masters.reduce((sum, master) => sum + master.held[i], 0) / 10);
  return [5, 10, 20, 50].find((scale) => most <= scale) ?? 100;
}

/** The host in one colour, DSPs in others that tell neighbours apart. */
export function masterColours(bus: Bus, theme: Theme): string[] {
  const dsps = [OKABE_ITO.blue, OKABE_ITO.orange, OKABE_ITO.green, OKABE_ITO.purple, OKABE_ITO.sky, OKABE_ITO.yellow];
  return bus.masters.map(({ name }) => (name === "host" ? theme.soft : dsps[Number(name.replace(/\D/g, "")) % dsps.length]));
}
