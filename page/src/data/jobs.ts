// Every job with its deadline, by kind and in the order of its deadlines (of its release, where it has none).
import { before, type Recording, type Runs } from "./recording";

export interface Jobs {
  kind: number;
  name: string;
  at: Float64Array; // deadline, else release
  run: Int32Array; // its last run
  missed: Int32Array; // places in `run` of those that missed
  missedAt: Float64Array; // their deadlines
  metAt: Float64Array; // deadlines of those that met them
  otherAt: Float64Array; // of those that did neither: no deadline, or not finished when the run ended
  latest: Float64Array; // the last instant of this job and all before
  earliest: Float64Array; // the first instant of this job and all after
}

/** The deadline; of a job without one its end. */
export function due(runs: Runs, run: number): number {
  return Number.isNaN(runs.deadline[run]) ? runs.ended[run] : runs.deadline[run];
}

export function met(runs: Runs, run: number): boolean {
  return runs.outcomes[runs.outcome[run]] === "on time" && !runs.missed[run] && !Number.isNaN(runs.deadline[run]);
}

/** The time that a job is about, however long before its deadline it ended, or after. */
function span(runs: Runs, run: number): [number, number] {
  return [Math.min(runs.released[run], runs.claimed[run], runs.ended[run]), Math.max(due(runs, run), runs.ended[run])];
}

/** Places of the jobs of that time, in their order. */
export function during(jobs: Jobs, runs: Runs, from: number, to: number): number[] {
  const places: number[] = [];
  for (let i = before(jobs.latest, from - 1e-12) + 1, upTo = before(jobs.earliest, to); i <= upTo; ++i) {
    const [begin, end] = span(runs, jobs.run[i]);
    if (begin <= to && end >= from) places.push(i);
  }
  return places;
}

/** The run that tells of a job: the one that finished, else the last one. */
function lastRuns(recording: Recording): Int32Array {
  const { runs } = recording;
  const key = (i: number): number => (runs.number[i] * 256 + runs.robot[i]) * 64 + runs.kind[i];
  const several = new Map<number, number>();
  for (let i = 0; i < runs.count; ++i) if (runs.ends[runs.end[i]] !== "done") several.set(key(i), -1);
  if (several.size) for (let i = 0; i < runs.count; ++i) if (several.has(key(i))) several.set(key(i), i);
  const last: number[] = [];
  for (let i = 0; i < runs.count; ++i) if (!several.size || (several.get(key(i)) ?? i) === i) last.push(i);
  return Int32Array.from(last);
}

export function jobsByKind(recording: Recording): Jobs[] {
  const { runs, header } = recording;
  const by: number[][] = header.kinds.map(() => []);
  for (const i of lastRuns(recording)) by[runs.kind[i]].push(i);
  const at = (i: number): number => (Number.isNaN(runs.deadline[i]) ? runs.released[i] : runs.deadline[i]);
  return by.flatMap((list, kind) => {
    if (!list.length) return [];
    list.sort((a, b) => at(a) - at(b));
    const missed = list.flatMap((i, place) => (runs.missed[i] ? [place] : []));
    const latest = new Float64Array(list.length), earliest = new Float64Array(list.length);
    list.forEach((i, place) => (latest[place] = Math.max(span(runs, i)[1], place ? latest[place - 1] : -Infinity)));
    for (let place = list.length - 1; place >= 0; --place) earliest[place] = Math.min(span(runs, list[place])[0], earliest[place + 1] ?? Infinity);
    return [{
      kind, name: header.kinds[kind], at: Float64Array.from(list, at), run: Int32Array.from(list), missed: Int32Array.from(missed), latest, earliest,
      missedAt: Float64Array.from(missed, (place) => at(list[place])), metAt: Float64Array.from(list.filter((i) => met(runs, i)), at),
      otherAt: Float64Array.from(list.filter((i) => !runs.missed[i] && !met(runs, i)), at),
    }];
  });
}

/** All missed jobs as run numbers, in the order of their deadlines. */
export function missesOf(jobs: Jobs[]): { at: Float64Array; run: Int32Array } {
  const all = jobs.flatMap((of) => Array.from(of.missed, (place) => [of.at[place], of.run[place]] as const));
  all.sort((a, b) => a[0] - b[0]);
  return { at: Float64Array.from(all, (one) => one[0]), run: Int32Array.from(all, (one) => one[1]) };
}
