// The signals at any instant: linear between two rows; an angle turns the shorter way.
import { before, type Recording } from "../data/recording";

export class Samples {
  private row = 0;
  private share = 0;

  constructor(readonly recording: Recording) {}

  seek(time: number): void {
    const times = this.recording.time;
    this.row = Math.max(0, Math.min(times.length - 2, before(times, time)));
    const width = times[this.row + 1] - times[this.row];
    this.share = times.length < 2 || !(width > 0) ? 0 : Math.min(1, Math.max(0, (time - times[this.row]) / width));
  }

  /** The row at or before the instant. */
  get index(): number {
    return this.row;
  }

  column(name: string): Float64Array | undefined {
    return this.recording.signals.get(name);
  }

  at(name: string): number {
    const column = this.column(name);
    if (!column) return 0;
    const a = column[this.row], b = column[Math.min(this.row + 1, column.length - 1)];
    return a + (b - a) * this.share;
  }

  angle(name: string): number {
    const column = this.column(name);
    if (!column) return 0;
    const a = column[this.row];
    let by = column[Math.min(this.row + 1, column.length - 1)] - a;
    by -= 2 * Math.PI * Math.round(by / (2 * Math.PI));
    return a + by * this.share;
  }
}
