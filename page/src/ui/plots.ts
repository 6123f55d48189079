// Load error and sway over the lanes' time axis, by uPlot.
import uPlot from "uplot";
import type { Recording } from "../data/recording";
import { baseOf, label, marks, stepFor } from "../lanes/axis";
import { OKABE_ITO, type Theme } from "./colours";
import type { Part } from "./picture";
import type { State } from "./state";

interface Plot {
  name: string;
  says: string[]; // its caption
  series: { name: string; colour: string; dash?: number[]; values: Float64Array }[];
  plot: uPlot;
  host: HTMLElement;
}

const HEIGHT = 74;

/** The range of an axis: it has 0 in it and is at least 0.1 high, so that noise stays small. */
function roomFor(low: number | null, high: number | null): [number, number] {
  const a = Math.min(0, low ?? 0), b = Math.max(0, high ?? 0), room = Math.max(0.1, b - a) * 0.08;
  return [a < 0 ? a - room : 0, Math.max(b + room, a + 0.1)];
}

export class Plots {
  private readonly plots: Plot[] = [];
  private dirty = false;

  constructor(private readonly host: HTMLElement, private readonly recording: Recording, private readonly state: State, private theme: Theme, private left: number) {
    const column = (name: string): Float64Array | undefined => recording.signals.get(name);
    const error = column("load_error_m");
    if (error) {
      const [unit, per] = error.some((v) => v >= 1) ? (["m", 1] as const) : (["mm", 1e3] as const);
      this.add(`load error, ${unit}`, [{ name: "load error, largest", colour: "load", values: error.map((v) => v * per) }]);
    }
    const degrees = (name: string): Float64Array => (column(name) ?? new Float64Array(recording.time.length)).map((v) => (v * 180) / Math.PI);
    this.add("sway, degrees", [
      { name: "along the jib", colour: "alpha", values: degrees("sway_alpha_rad") },
      { name: "across", colour: "beta", dash: [5, 3], values: degrees("sway_beta_rad") },
    ]);
  }

  private colour(name: string): string {
    return { load: OKABE_ITO.vermillion, alpha: this.theme.groups[4], beta: OKABE_ITO.orange }[name] ?? this.theme.ink;
  }

  private add(name: string, series: Plot["series"]): void {
    const host = document.createElement("figure");
    host.className = "plot";
    const caption = document.createElement("figcaption");
    const says = [name, ...(series.length > 1 ? series.map((one) => `${one.dash ? "┄" : "—"} ${one.name}`) : [])];
    caption.append(...says.map((text) => Object.assign(document.createElement("div"), { textContent: text })));
    host.append(caption);
    this.host.append(host);
    const plot = this.make(host, series);
    this.plots.push({ name, says, series, plot, host });
  }

  private make(host: HTMLElement, series: Plot["series"]): uPlot {
    const axis = { stroke: () => this.theme.soft, grid: { stroke: () => (this.theme.dark ? "rgba(255,255,255,.09)" : "rgba(0,0,0,.08)"), width: 1 }, ticks: { show: false }, font: "11px system-ui, sans-serif" };
    const options: uPlot.Options = {
      width: Math.max(60, this.host.clientWidth), height: HEIGHT, padding: [8, 10, 4, 0],
      legend: { show: false }, cursor: { show: false }, select: { show: false, left: 0, top: 0, width: 0, height: 0 },
      scales: { x: { time: false, range: () => [this.state.from, this.state.to] }, y: { range: (_, low, high) => roomFor(low, high) } },
      axes: [
        { ...axis, size: 4, values: (_, splits) => splits.map(() => ""), splits: (u) => marks(this.state.from, this.state.to, stepFor(this.state.to - this.state.from, (u.width - this.left - 10) / 95)) },
        { ...axis, size: this.left, space: 17 }, // two labels at least
      ],
      series: [{}, ...series.map((one) => ({ stroke: () => this.colour(one.colour), width: 1.5, dash: one.dash, points: { show: false } }))],
    };
    return new uPlot(options, [this.recording.time, ...series.map((one) => one.values)] as unknown as uPlot.AlignedData, host);
  }

  dress(theme: Theme): void {
    this.theme = theme;
    for (const { plot } of this.plots) plot.redraw(false, true);
  }

  resize(left: number): void {
    const resized = left !== this.left;
    this.left = left;
    for (const one of this.plots) {
      if (resized) {
        one.plot.destroy();
        one.plot = this.make(one.host, one.series);
      } else {
        one.plot.setSize({ width: Math.max(60, this.host.clientWidth), height: HEIGHT });
      }
    }
  }

  invalidate(): void {
    this.dirty = true;
  }

  draw(): void {
    if (!this.dirty) return;
    this.dirty = false;
    for (const { plot } of this.plots) plot.setScale("x", { min: this.state.from, max: this.state.to });
  }

  explain(time: number, y: number): string[] | null {
    const plot = this.plots.find(({ host }) => {
      const rect = host.getBoundingClientRect();
      return y >= rect.top && y < rect.bottom;
    });
    if (!plot) return null;
    const times = this.recording.time;
    let i = Math.round(((time - times[0]) / (times[times.length - 1] - times[0])) * (times.length - 1));
    i = Math.max(0, Math.min(times.length - 1, i));
    const step = stepFor(this.state.to - this.state.from, 8);
    return [plot.name, `at ${label(times[i], Math.max(1e-3, step), baseOf(times[i], 1))}`, ...plot.series.map((one) => `${one.name}: ${one.values[i].toFixed(3)}`)];
  }

  get pictures(): Part[] {
    return this.plots.map(({ plot, says }) => ({ canvas: plot.ctx.canvas, says }));
  }
}
