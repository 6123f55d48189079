// Every job with its deadline, by kind and in the order of its deadlines (of its release, where it has none).
import type { Recording } from "./recording";

export interface Jobs {
  kind: number;
  name: string;
  at: Float64Array; // deadline, else release
  run: Int32Array; // its last run
  missed: Int32Array; // places in `run` of those that missed
  missedAt: Float64Array; // their deadlines
}

/** The run that tells of a job: the one that finished, else the last one. */
function lastRuns(recording: Recording): Int32Array {
  const { runs } = recording;
  const key = (i: number): number => (runs.number[i] * 256 + runs.robot[i]) * 64 + runs.kind[i];
  const several = new Map<number, number>();
  for (let i = 0; i < runs.count; ++i) if (runs.end[i] !== 0) several.set(key(i), -1);
  if (several.size) for (let i = 0; i < runs.count; ++i) if (several.has(key(i))) several.set(key(i), i);
  const last: number[] = [];
  for (let i = 0; i < runs.count; ++i) if (!several.size || (several.get(key(i)) ?? i) === i) last.push(i);
  return Int32Array.from(last);
}

export function jobsByKind(recording: Recording): Jobs[] {
  const { runs, header } = recording;
  const by: number[][] = header.kinds.map(() => []);
  for (const i of lastRuns(recording)) by[runs.kind[i]].push(i);
  const due = (i: number): number => (Number.isNaN(runs.deadline[i]) ? runs.released[i] : runs.deadline[i]);
  return by.flatMap((list, kind) => {
    if (!list.length) return [];
    list.sort((a, b) => due(a) - due(b));
    const missed = list.flatMap((i, place) => (runs.missed[i] ? [place] : []));
    return [{ kind, name: header.kinds[kind], at: Float64Array.from(list, due), run: Int32Array.from(list), missed: Int32Array.from(missed), missedAt: Float64Array.from(missed, (place) => due(list[place])) }];
  });
}

/** All missed jobs as run numbers, in the order of their deadlines. */
export function missesOf(jobs: Jobs[]): { at: Float64Array; run: Int32Array } {
  const all = jobs.flatMap((of) => Array.from(of.missed, (place) => [of.at[place], of.run[place]] as const));
  all.sort((a, b) => a[0] - b[0]);
  return { at: Float64Array.from(all, (one) => one[0]), run: Int32Array.from(all, (one) => one[1]) };
}
