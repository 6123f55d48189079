// What DSPs did, in coarser and coarser slices of time.
import { before, WAITS, type Lane } from "./recording";

export const OFF = 0, FAILED = 1, ASLEEP = 2, AWAKE = 3;

/** Shares of time by group, and behind them by what was waited for (WAITS), in slices that double from level to level. A share of 255 is all of a slice. */
export class Pyramid {
  readonly levels: Uint8Array[] = [];
  readonly width: number; // s of a slice of the lowest level
  private readonly columns: number;

  constructor(lane: Lane, readonly groupOf: Uint8Array, readonly groups: number, private readonly begin: number, slices = 32768) {
    this.columns = groups + WAITS.length;
    this.width = Math.max(1e-9, (lane.end - begin) / slices);
    this.levels.push(this.lowest(lane, slices));
    for (let n = slices >> 1; n >= 64; n >>= 1) this.levels.push(this.halved(this.levels[this.levels.length - 1], n));
  }

  private lowest(lane: Lane, slices: number): Uint8Array {
    const out = new Uint8Array(slices * this.columns);
    const sums = new Float64Array(this.columns);
    let segment = 0;
    for (let i = 0; i < slices; ++i) {
      const from = this.begin + i * this.width, to = from + this.width;
      sums.fill(0);
      while (segment < lane.from.length) {
        const upTo = segment + 1 < lane.from.length ? lane.from[segment + 1] : lane.end;
        const inside = Math.min(upTo, to) - Math.max(lane.from[segment], from);
        if (inside > 0) {
          sums[this.groupOf[lane.what[segment]]] += inside;
          const share = inside / (upTo - lane.from[segment]); // of its waits it is not known when they were
          for (let cause = 0; cause < WAITS.length; ++cause) sums[this.groups + cause] += share * lane.waits[cause][segment];
        }
        if (upTo > to) break;
        ++segment;
      }
      for (let g = 0; g < this.columns; ++g) out[i * this.columns + g] = Math.round((255 * sums[g]) / this.width);
    }
    return out;
  }

  private halved(finer: Uint8Array, slices: number): Uint8Array {
    const out = new Uint8Array(slices * this.columns), g = this.columns;
    for (let i = 0; i < slices; ++i) for (let k = 0; k < g; ++k) out[i * g + k] = (finer[2 * i * g + k] + finer[(2 * i + 1) * g + k] + 1) >> 1;
    return out;
  }

  /** Shares by column of `perColumn` s each, from `from` on. Only where a column is at least as wide as a slice. */
  shares(from: number, perColumn: number, columns: number, out: Float32Array): void {
    let level = 0;
    while (level + 1 < this.levels.length && this.width * 2 ** (level + 1) <= perColumn) ++level;
    const data = this.levels[level], width = this.width * 2 ** level, all = this.columns, count = data.length / all;
    out.fill(0);
    for (let x = 0; x < columns; ++x) {
      const first = Math.floor((from + x * perColumn - this.begin) / width);
      const last = Math.max(first, Math.ceil((from + (x + 1) * perColumn - this.begin) / width) - 1);
      for (let i = Math.max(0, first); i <= Math.min(count - 1, last); ++i)
        for (let g = 0; g < all; ++g) out[x * all + g] += data[i * all + g] / (255 * (last - first + 1));
    }
  }
}

/** The same from the segments themselves, for columns finer than the pyramid. */
export function exactShares(lane: Lane, groupOf: Uint8Array, groups: number, from: number, perColumn: number, columns: number, out: Float32Array): void {
  out.fill(0);
  const to = from + columns * perColumn, all = groups + WAITS.length;
  for (let i = Math.max(0, before(lane.from, from)); i < lane.from.length && lane.from[i] < to; ++i) {
    const end = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end, upTo = Math.min(end, to), took = end - lane.from[i];
    const start = Math.max(lane.from[i], from), g = groupOf[lane.what[i]];
    let x = Math.floor((start - from) / perColumn), at = start;
    while (at < upTo && x < columns) {
      const edge = Math.min(upTo, from + (x + 1) * perColumn);
      if (edge > at) {
        const share = (edge - at) / perColumn;
        out[x * all + g] += share;
        for (let cause = 0; cause < WAITS.length; ++cause) out[x * all + groups + cause] += (share * lane.waits[cause][i]) / took;
      }
      at = edge;
      ++x;
    }
  }
}

export function segmentAt(lane: Lane, time: number): number {
  return time > lane.end ? -1 : before(lane.from, time);
}
