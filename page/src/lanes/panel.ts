// The lanes: events, DSPs, deadlines and buses over one time axis.
import { during, jobsByKind, met, missesOf, type Jobs } from "../data/jobs";
import { Pyramid, segmentAt } from "../data/lanes";
import { before, WAITS, type Lane, type Recording } from "../data/recording";
import * as words from "../data/words";
import { GROUPS, groupsOf, OKABE_ITO, type Theme } from "../ui/colours";
import type { Moment } from "../ui/events";
import type { State } from "../ui/state";
import { baseOf, label, marks, stepFor } from "./axis";
import { momentsRow } from "./moments";
import { fullScale, LanePainter, masterColours, type Place } from "./paint";

export interface Row {
  name: string;
  short?: string; // where there is no room for the name
  cut?: boolean; // the name was too long
  height: number; // CSS px
  paint(context: CanvasRenderingContext2D, place: Place, dots: number): void;
  explain(time: number, reach: number): string[] | null;
  choose?(time: number, reach: number): number; // run of a miss there, or -1
}

const GAP = 2, AXIS = 22;

export class LanePanel {
  readonly canvas = document.createElement("canvas");
  readonly jobs: Jobs[];
  readonly misses: { at: Float64Array; run: Int32Array };
  readonly lanes: Lane[];
  private readonly rows: Row[] = [];
  private readonly painter: LanePainter;
  private readonly pyramids = new Map<Lane, Pyramid>();
  private readonly groupOf: Uint8Array;
  private theme: Theme;
  left = 150;
  private dirty = true;

  constructor(private readonly host: HTMLElement, private readonly recording: Recording, private readonly state: State, private readonly moments: Moment[], theme: Theme) {
    this.theme = theme;
    this.groupOf = groupsOf(recording.header.kinds);
    this.painter = new LanePainter(this.groupOf, theme);
    this.lanes = recording.lanes;
    this.jobs = jobsByKind(recording);
    this.misses = missesOf(this.jobs);
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    const missed = this.misses.run.length;
    this.canvas.setAttribute("aria-label", `What each DSP did, deadlines, buses and events over time. ${missed ? `${missed} missed deadlines: the keys n and p go from one to the next, and tell why it was missed` : "No deadline was missed"}`);
    host.append(this.canvas);
    this.makeRows();
  }

  private makeRows(): void {
    const { header, runs, buses } = this.recording;
    this.rows.push(momentsRow(this.moments, this.state, () => this.theme));
    const high = this.lanes.length > 8 ? 19 : this.lanes.length > 4 ? 25 : 33;
    for (const lane of this.lanes) this.rows.push(this.dspRow(lane, high));
    for (const jobs of this.jobs) {
      this.rows.push({
        name: jobs.name.replaceAll("_", " "), height: 12,
        paint: (context, place, dots) => this.painter.deadlines(context, place, this.state, jobs, runs, dots),
        explain: (time, reach) => this.explainDeadline(jobs, time, reach),
        choose: (time, reach) => this.missNear(jobs, time, reach),
      });
    }
    for (const bus of buses) {
      this.rows.push({
        name: `bus ${bus.name} to ${fullScale(bus)} %`, short: `${bus.name} to ${fullScale(bus)} %`, height: 20,
        paint: (context, place) => this.painter.bus(context, place, this.state, bus, header.bus_slice_s, header.from_s, masterColours(bus, this.theme), fullScale(bus)),
        explain: (time) => {
          const i = Math.floor((time - header.from_s) / header.bus_slice_s);
          if (!(i >= 0 && i < bus.refused.length)) return null;
          const share = (n: number): string => `${(n / 10).toFixed(1)} %`;
          const all = bus.masters.reduce((sum, master) => sum + master.held[i], 0);
          return [`bus ${bus.name}: in use ${share(all)} of ${words.time(header.bus_slice_s)}`, ...bus.masters.filter((m) => m.held[i] > 0).map((m) => `${m.name}: ${share(m.held[i])}`),
            ...(bus.refused[i] ? [`${bus.refused[i]} attempts had to be repeated`] : [])];
        },
      });
    }
  }

  private dspRow(lane: Lane, height: number): Row {
    const { header, runs } = this.recording;
    return {
      name: `DSP ${lane.slot}`, height,
      paint: (context, place, dots) => {
        this.painter.lane(context, place, this.state, lane, this.pyramid(lane));
        this.painter.names(context, place, this.state, lane, runs, header.kinds, dots);
      },
      explain: (time, reach) => {
        const i = segmentAt(lane, time);
        if (i < 0) return time > lane.end ? [`DSP ${lane.slot}`, "what it did from here on was not recorded"] : null;
        const first = segmentAt(lane, time - reach), last = segmentAt(lane, time + reach);
        if (last - first > 6) return [`DSP ${lane.slot}, ${words.time(2 * reach)} under the pointer`, ...this.shares(lane, time - reach, time + reach)];
        const run = lane.run[i];
        if (run >= 0) return words.runLines(header, runs, run);
        const until = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end;
        return [`DSP ${lane.slot} ${words.STATES[lane.what[i]]}`, `for ${words.time(until - lane.from[i])}, until ${words.instant(until, 1e-6)}`, ...words.waits(lane.waits, i)];
      },
      choose: (time) => {
        const i = segmentAt(lane, time);
        return i >= 0 && lane.run[i] >= 0 && runs.missed[lane.run[i]] ? lane.run[i] : -1;
      },
    };
  }

  private shares(lane: Lane, from: number, to: number): string[] {
    const sums = new Float64Array(GROUPS.length), waited = new Float64Array(WAITS.length);
    for (let i = Math.max(0, segmentAt(lane, from)); i < lane.from.length && lane.from[i] < to; ++i) {
      const upTo = Math.min(to, i + 1 < lane.from.length ? lane.from[i + 1] : lane.end);
      const inside = Math.max(0, upTo - Math.max(from, lane.from[i])), end = i + 1 < lane.from.length ? lane.from[i + 1] : lane.end;
      sums[this.groupOf[lane.what[i]]] += inside;
      if (inside > 0) waited.forEach((_, cause) => (waited[cause] += (inside / (end - lane.from[i])) * lane.waits[cause][i]));
    }
    const share = (time: number): string => `${((100 * time) / (to - from)).toFixed(1)} %`;
    const order = [...sums.keys()].filter((g) => sums[g] > 0).sort((a, b) => sums[b] - sums[a]);
    const waits = WAITS.map((name, cause) => (waited[cause] > 0 ? [`${share(waited[cause])} for ${name}`] : [])).flat();
    return [...order.slice(0, 6).map((g) => `${share(sums[g])} ${GROUPS[g].name}`), ...(waits.length ? [`waiting: ${waits.join(", ")}`] : [])];
  }

  private pyramid(lane: Lane): Pyramid {
    let pyramid = this.pyramids.get(lane);
    if (!pyramid) this.pyramids.set(lane, (pyramid = new Pyramid(lane, this.groupOf, GROUPS.length, this.recording.header.from_s)));
    return pyramid;
  }

  private missNear(jobs: Jobs, time: number, reach: number): number {
    const place = before(jobs.at, time + reach * 3);
    let best = -1, away = reach * 3;
    for (let m = before(jobs.missed, place); m >= 0 && jobs.at[jobs.missed[m]] >= time - reach * 3; --m) {
      const far = Math.abs(jobs.at[jobs.missed[m]] - time);
      if (far <= away) (best = jobs.run[jobs.missed[m]]), (away = far);
    }
    return best;
  }

  private explainDeadline(jobs: Jobs, time: number, reach: number): string[] | null {
    const { header, runs } = this.recording;
    const miss = this.missNear(jobs, time, reach);
    if (miss >= 0) return [...words.runLines(header, runs, miss), "click: why"];
    const first = before(jobs.at, time - 2 * reach) + 1, last = before(jobs.at, time + 2 * reach);
    if (last - first >= 2) return [jobs.name, this.outcomes(jobs, first, last)];
    // The dot of a job's end, else a deadline, else the line to the next deadline.
    const places = during(jobs, runs, time - 2 * reach, time + 2 * reach);
    const nearest = (at: (place: number) => number): number | undefined => {
      const away = (place: number): number => Math.abs(at(place) - time);
      return places.filter((place) => away(place) <= 2 * reach).sort((a, b) => away(a) - away(b))[0];
    };
    const place = nearest((place) => (runs.missed[jobs.run[place]] ? NaN : runs.ended[jobs.run[place]])) ?? nearest((place) => jobs.at[place]) ?? places.find((place) => jobs.at[place] >= time);
    return place === undefined ? null : words.runLines(header, runs, jobs.run[place]);
  }

  /** What became of jobs none of which missed its deadline. */
  private outcomes(jobs: Jobs, first: number, last: number): string {
    const { runs } = this.recording, counts = new Map<string, number>();
    for (let i = first; i <= last; ++i) {
      const run = jobs.run[i], what = met(runs, run) ? "met" : Number.isNaN(runs.deadline[run]) ? "without a deadline" : runs.outcomes[runs.outcome[run]];
      counts.set(what, (counts.get(what) ?? 0) + 1);
    }
    const all = last - first + 1;
    if (counts.get("met") === all) return `${all} deadlines under the pointer, all met`;
    return `${all} jobs under the pointer: ${[...counts].map(([what, count]) => `${count} ${what}`).join(", ")}`;
  }

  dress(theme: Theme): void {
    this.theme = theme;
    this.painter.dress(theme);
    this.dirty = true;
  }

  invalidate(): void {
    this.dirty = true;
  }

  get height(): number {
    return AXIS + this.rows.reduce((sum, row) => sum + row.height + GAP, 0) + 4;
  }

  get width(): number {
    return Math.max(10, this.host.clientWidth - this.left - 10);
  }

  timeAt(clientX: number): number {
    const x = clientX - this.canvas.getBoundingClientRect().left - this.left;
    return this.state.from + (x / this.width) * (this.state.to - this.state.from);
  }

  private rowAt(clientY: number): Row | null {
    let y = clientY - this.canvas.getBoundingClientRect().top - AXIS;
    for (const row of this.rows) {
      if (y >= 0 && y < row.height + GAP) return row;
      y -= row.height + GAP;
    }
    return null;
  }

  placeOf(name: string, time: number): [number, number] {
    const rect = this.canvas.getBoundingClientRect();
    let y = rect.top + AXIS;
    for (const row of this.rows) {
      if (row.name === name) return [rect.left + this.left + ((time - this.state.from) / (this.state.to - this.state.from)) * this.width, y + row.height / 2];
      y += row.height + GAP;
    }
    throw new Error(`there is no row ${name}`);
  }

  /** Seconds that half a finger's or pointer's width covers. */
  private reach(coarse: boolean): number {
    return ((coarse ? 10 : 2) / this.width) * (this.state.to - this.state.from);
  }

  /** It is over the lanes, not beside them. */
  covers(clientX: number): boolean {
    const x = clientX - this.canvas.getBoundingClientRect().left - this.left;
    return x >= 0 && x <= this.width;
  }

  explain(clientX: number, clientY: number, coarse = false): string[] | null {
    const row = this.rowAt(clientY);
    if (this.covers(clientX)) return row?.explain(this.timeAt(clientX), this.reach(coarse)) ?? null;
    return row?.cut ? [row.name] : null;
  }

  missAt(clientX: number, clientY: number, coarse = false): number {
    return this.covers(clientX) ? (this.rowAt(clientY)?.choose?.(this.timeAt(clientX), this.reach(coarse)) ?? -1) : -1;
  }

  draw(): boolean {
    if (!this.dirty) return false;
    this.dirty = false;
    const dots = Math.min(2, devicePixelRatio), width = Math.round(this.host.clientWidth * dots), height = Math.round(this.height * dots);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.canvas.style.height = `${this.height}px`;
    }
    // Dots are put into it by the script: it is kept where the script is.
    const context = this.canvas.getContext("2d", { willReadFrequently: true })!;
    context.fillStyle = this.theme.panel;
    context.fillRect(0, 0, width, height);
    const place: Place = { left: Math.round(this.left * dots), width: Math.round(this.width * dots), top: 0, height: AXIS * dots };
    this.paintAxis(context, place, height, dots);
    let top = AXIS;
    for (const row of this.rows) {
      place.top = Math.round(top * dots);
      place.height = Math.round(row.height * dots);
      row.paint(context, place, dots);
      context.fillStyle = this.theme.ink;
      context.font = `${11.5 * dots}px system-ui, sans-serif`;
      context.textBaseline = "middle";
      context.textAlign = "right";
      const name = this.nameOf(context, row, (this.left - 12) * dots);
      row.cut = name !== row.name;
      context.fillText(name, (this.left - 8) * dots, place.top + place.height / 2 + dots * 0.5);
      context.textAlign = "left";
      top += row.height + GAP;
    }
    this.paintChosen(context, place, dots);
    return true;
  }

  /** What distinguishes names is often at their ends: one that is too long loses its middle. */
  private nameOf(context: CanvasRenderingContext2D, row: Row, room: number): string {
    const fits = (text: string): boolean => context.measureText(text).width <= room;
    if (fits(row.name)) return row.name;
    if (row.short) return row.short;
    let left = row.name.length - 1;
    const shown = (): string => `${row.name.slice(0, Math.ceil(left / 2))}…${row.name.slice(row.name.length - Math.floor(left / 2))}`;
    while (left > 2 && !fits(shown())) --left;
    return shown();
  }

  private paintAxis(context: CanvasRenderingContext2D, place: Place, height: number, dots: number): void {
    const { from, to } = this.state, step = stepFor(to - from, place.width / (95 * dots)), base = baseOf(from, step);
    context.font = `${11 * dots}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    for (const mark of marks(from, to, step)) {
      const x = place.left + ((mark - from) / (to - from)) * place.width;
      context.fillStyle = this.theme.dark ? "rgba(255,255,255,.09)" : "rgba(0,0,0,.08)";
      context.fillRect(Math.round(x), AXIS * dots, 1, height - AXIS * dots);
      context.fillStyle = this.theme.soft;
      const text = label(mark, step, base), wide = context.measureText(text).width;
      if (x + wide / 2 < place.left + place.width + 8 * dots && x - wide / 2 > place.left - 30 * dots) context.fillText(text, x - wide / 2, (AXIS / 2) * dots);
    }
    if (base > 0) {
      context.textAlign = "right";
      context.fillText(`${base.toFixed(6).replace(/0+$/, "").replace(/\.$/, "")} s`, (this.left - 8) * dots, (AXIS / 2) * dots);
      context.textAlign = "left";
    }
  }

  /** From release to deadline of the miss that was chosen, over all lanes. */
  private paintChosen(context: CanvasRenderingContext2D, place: Place, dots: number): void {
    const { miss, from, to } = this.state, { runs } = this.recording;
    if (miss < 0) return;
    const x = (time: number): number => place.left + ((time - from) / (to - from)) * place.width;
    const due = Number.isNaN(runs.deadline[miss]) ? runs.ended[miss] : runs.deadline[miss];
    const left = Math.max(place.left, x(runs.released[miss])), right = Math.min(place.left + place.width, Math.max(x(due), left + 2));
    if (right < place.left || left > place.left + place.width) return;
    context.fillStyle = this.theme.dark ? "rgba(213,94,0,.22)" : "rgba(213,94,0,.14)";
    context.fillRect(left, AXIS * dots, right - left, context.canvas.height);
    context.fillStyle = OKABE_ITO.vermillion;
    if (x(due) >= place.left && x(due) <= place.left + place.width) context.fillRect(x(due) - dots, AXIS * dots, 2 * dots, context.canvas.height);
  }
}
