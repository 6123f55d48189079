// A recording, decoded: the dock at equal intervals, every run of a job on a DSP, the buses, the report.
import { Columns } from "./columns";

export interface Layout {
  size: [number, number, number];
  containers: [number, number, number, number][];
  ship: number[];
  ship_moves: boolean;
  boxes: number[][];
  movers: [number, number][];
  lanes: [number, number, number, number, number][];
  spot: [number, number];
  warehouse: [number, number, number];
  agv: { count: number; length: number; width: number; deck: number };
  crane: {
    machine: "gantry" | "slewing";
    a0: number;
    pivot: number;
    counterweight: number;
    reach: [number, number];
    falls: [number, number];
    portal: { along: number; rails: [number, number]; leg: number; height: number };
  };
}

export type ContainerStep = [time: number, where: "ship" | "carried" | "agv" | "set" | "gone", place: number[]];
export type DockEvent = [time: number, kind: string, object: string, details: string];

export interface Header {
  title: string;
  from_s: number;
  to_s: number;
  tick_ps: number;
  slots: number;
  cycle_s: number;
  kinds: string[];
  outcomes: string[];
  ends: string[];
  bus_slice_s: number;
  stretches_left_out: number;
  lanes_until_s: number | null;
  ideal_until_s: number | null;
  layout: Layout;
  containers: ContainerStep[][];
  dock_events: DockEvent[];
}

export interface Miss {
  kind: string;
  robot: number;
  number: number;
  outcome: string;
  release_ps: number;
  deadline_ps: number | null;
  end_ps: number;
  lateness_ps: number | null;
  usual_ps: number | null;
  unavoidable_ps: number | null;
  parts_ps: Record<string, number>;
  behind: { kind: string; robot: number; number: number; dsp: number; claimed_ps: number; from_ps: number; to_ps: number; overtook: boolean; share_ps: number }[];
  runs: { dsp: number; claimed_ps: number; ended_ps: number; end: string }[];
  previous?: number;
}

export interface Report {
  stop_reason: string;
  simulated_s: number;
  hash: string;
  misses: Miss[];
  misses_left_out: number;
  tasks: Record<string, { released: number; misses: number; on_time: number }>;
  buses: Record<string, unknown>;
  timed_events: { time_s: number; what: string }[];
  failures: { time_s: number; dsp: number | null; kind: string; message: string }[];
  errors: null | { window_s: [number, number]; load_m: { rms: number; peak: number; end: number } };
  configuration: Record<string, unknown>;
  [key: string]: unknown;
}

/** Runs of jobs in the order of their claims, then jobs that no DSP ever ran (`slot` -1). Times in s. */
export interface Runs {
  count: number;
  claimed: Float64Array;
  ended: Float64Array;
  released: Float64Array;
  deadline: Float64Array; // NaN: none
  number: Float64Array;
  slot: Int8Array;
  kind: Uint8Array;
  robot: Uint8Array;
  outcome: Uint8Array;
  missed: Uint8Array;
  end: Uint8Array;
  waits: Float32Array[]; // s that it waited, by WAITS
  outcomes: string[]; // in words, by number: what became of the job
  ends: string[]; // and how the run ended
}

/** What a stretch of a lane may wait for. */
export const WAITS = ["bus A", "bus B", "the list"];

/** What one DSP did, one thing after another: 0 off, 1 dead, 2 asleep, 3 its executive, from 4 on a job of kind n - 4. */
export interface Lane {
  slot: number;
  from: Float64Array; // s; each lasts until the next one, the last until `end`
  what: Uint8Array;
  run: Int32Array; // of a job; -1: none
  waits: Float32Array[]; // s for which bus A, bus B and the list (WAITS) held it up
  end: number;
}

export interface Bus {
  name: string;
  masters: { name: string; held: Float64Array }[]; // thousandths of a slice
  refused: Float64Array;
}

export interface Recording {
  header: Header;
  report: Report;
  time: Float64Array;
  signals: Map<string, Float64Array>;
  runs: Runs;
  lanes: Lane[];
  buses: Bus[];
}

const FIRST_KIND = 4;

/** Numbers are recorded as differences from the job before of the same kind and robot. */
function absolute(number: Float64Array, kind: ArrayLike<number>, robot: ArrayLike<number>): void {
  const last = new Map<number, number>();
  for (let i = 0; i < number.length; ++i) {
    const of = kind[i] * 256 + robot[i];
    number[i] += last.get(of) ?? 0;
    last.set(of, number[i]);
  }
}

async function all(columns: Columns, prefix: string, names: string): Promise<Float64Array[]> {
  return Promise.all(names.split(" ").map((name) => columns.numbers(`${prefix}.${name}`)));
}

function joined(a: ArrayLike<number>, b: ArrayLike<number>): Float64Array {
  const out = new Float64Array(a.length + b.length);
  out.set(a);
  out.set(b, a.length);
  return out;
}

function inWords(name: string): string {
  return name.replaceAll("_", " ");
}

async function lanesOf(columns: Columns, header: Header): Promise<{ lanes: Lane[]; runs: Runs }> {
  const [slot, what, took, busA, busB, list] = await all(columns, "lane", "slot what took bus_a bus_b list");
  const [number, robot, end, waited, allowed, outcome, missed] = await all(columns, "run", "number robot end waited allowed outcome missed");
  const never = await all(columns, "job", "number kind robot released took allowed outcome missed");
  const second = header.tick_ps * 1e-12, count = number.length;
  const clock = new Float64Array(header.slots).fill(Math.floor(header.from_s / second + 1e-6)), counts = new Int32Array(header.slots);
  for (let i = 0; i < slot.length; ++i) ++counts[slot[i]];
  const lanes: Lane[] = Array.from({ length: header.slots }, (_, n) => ({
    slot: n, from: new Float64Array(counts[n]), what: new Uint8Array(counts[n]), run: new Int32Array(counts[n]).fill(-1), waits: WAITS.map(() => new Float32Array(counts[n])), end: header.from_s,
  }));
  counts.fill(0);
  const kind = new Float64Array(count), claimed = new Float64Array(count), ended = new Float64Array(count), of = new Float64Array(count);
  const waits = WAITS.map(() => new Float32Array(count)), released = new Float64Array(count), deadline = new Float64Array(count);
  let run = 0;
  for (let i = 0; i < slot.length; ++i) {
    const lane = lanes[slot[i]], at = counts[slot[i]]++, from = clock[slot[i]];
    clock[slot[i]] += took[i];
    lane.from[at] = from * second;
    lane.what[at] = what[i];
    [busA, busB, list].forEach((column, cause) => (lane.waits[cause][at] = column[i] * second));
    lane.end = clock[slot[i]] * second;
    if (what[i] < FIRST_KIND) continue;
    lane.run[at] = run;
    kind[run] = what[i] - FIRST_KIND;
    of[run] = slot[i];
    claimed[run] = from * second;
    ended[run] = (from + took[i]) * second;
    released[run] = (from - waited[run]) * second;
    deadline[run] = allowed[run] === 0 ? NaN : (from - waited[run] + allowed[run] - 1) * second;
    waits.forEach((column, cause) => (column[run] = lane.waits[cause][at]));
    ++run;
  }
  absolute(number, kind, robot);
  absolute(never[0], never[1], never[2]);
  const [neverReleased, neverTook, neverAllowed] = [never[3], never[4], never[5]], none = new Float64Array(never[0].length);
  const since = neverReleased.map((tick) => tick * second);
  const runs: Runs = {
    count: count + none.length,
    claimed: joined(claimed, since),
    ended: joined(ended, neverReleased.map((tick, i) => (tick + neverTook[i]) * second)),
    released: joined(released, since),
    deadline: joined(deadline, neverReleased.map((tick, i) => (neverAllowed[i] === 0 ? NaN : (tick + neverAllowed[i] - 1) * second))),
    number: joined(number, never[0]),
    slot: Int8Array.from(joined(of, none.map(() => -1))),
    kind: Uint8Array.from(joined(kind, never[1])), robot: Uint8Array.from(joined(robot, never[2])), outcome: Uint8Array.from(joined(outcome, never[6])),
    missed: Uint8Array.from(joined(missed, never[7])), end: Uint8Array.from(joined(end, none)), waits: waits.map((column) => Float32Array.from(joined(column, none))),
    outcomes: header.outcomes.map(inWords), ends: header.ends.map(inWords),
  };
  return { lanes, runs };
}

async function busesOf(columns: Columns, report: Report): Promise<Bus[]> {
  const buses: Bus[] = [];
  for (const name of Object.keys(report.buses)) {
    const prefix = `bus.${name}.`;
    const masters = columns.names().filter((column) => column.startsWith(prefix) && !column.endsWith(".refused"));
    if (!masters.length) continue;
    buses.push({
      name,
      masters: await Promise.all(masters.map(async (column) => ({ name: column.slice(prefix.length), held: await columns.numbers(column) }))),
      refused: await columns.numbers(`${prefix}refused`),
    });
  }
  return buses;
}

export async function decode(base64: string): Promise<Recording> {
  const columns = Columns.of(base64);
  const header = columns.header as unknown as Header;
  const report = JSON.parse(await columns.text("report")) as Report;
  const signals = new Map<string, Float64Array>();
  const names = columns.names().filter((name) => !/^(lane|run|job|bus)\.|^report$/.test(name));
  await Promise.all(names.map(async (name) => signals.set(name, await columns.numbers(name))));
  const [{ lanes, runs }, buses] = await Promise.all([lanesOf(columns, header), busesOf(columns, report)]);
  return { header, report, time: signals.get("time_s")!, signals, lanes, runs, buses };
}

/** The last index whose value is at most `value`; -1: none is. */
export function before(sorted: ArrayLike<number>, value: number): number {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
