// The page: decodes its recording and joins the parts.
import { decode, type Recording } from "./data/recording";
import * as words from "./data/words";
import { LanePanel } from "./lanes/panel";
import { DockView } from "./scene/view";
import { Samples } from "./scene/samples";
import { DARK, LIGHT, type Theme } from "./ui/colours";
import { momentsOf } from "./ui/events";
import * as gestures from "./ui/gestures";
import { head } from "./ui/head";
import { help } from "./ui/help";
import { hint } from "./ui/hint";
import { keys } from "./ui/keys";
import * as link from "./ui/link";
import { MissPanel } from "./ui/miss";
import { png, save } from "./ui/picture";
import { Plots } from "./ui/plots";
import { SPEEDS, State } from "./ui/state";

function the<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

const OPTIONS = ["rays", "ghost", "path"] as const;

/** Pixels at the left of lanes and plots, for their names. */
function gutter(): number {
  return innerWidth < 700 ? 92 : 168;
}

class Page {
  private theme: Theme;
  readonly state: State;
  private readonly moments;
  private readonly dock: DockView | null;
  private readonly lanes: LanePanel;
  private readonly plots: Plots;
  private readonly miss: MissPanel;
  private left = gutter();
  private last = 0;
  private hashAt = 0;
  private lastMiss = -1; // the run whose miss was chosen last
  private focused: HTMLElement | null = null; // what had the focus before a panel took it
  /** ms of script by frame (scripts/documents/page_frames.py). */
  readonly frames: number[] = [];

  constructor(readonly recording: Recording) {
    const { header } = recording;
    this.theme = matchMedia("(prefers-color-scheme: dark)").matches ? DARK : LIGHT;
    document.documentElement.dataset.theme = this.theme.dark ? "dark" : "light";
    this.state = new State(header.from_s, header.to_s);
    this.moments = momentsOf(recording);
    this.lanes = new LanePanel(the("lanes"), recording, this.state, this.moments, this.theme);
    this.lanes.left = this.left;
    this.plots = new Plots(the("plots"), recording, this.state, this.theme, this.left);
    this.miss = new MissPanel(the("miss"), recording, this.state, (time) => this.goTo(time));
    this.dock = this.makeDock();
    const misses = this.lanes.misses.run.length;
    head(the("title"), the("facts"), recording, misses);
    the<HTMLButtonElement>("previous").disabled = the<HTMLButtonElement>("next").disabled = misses === 0;
    this.connect();
    this.follow(location.hash);
    this.resize();
    requestAnimationFrame((now) => this.frame(now));
  }

  private makeDock(): DockView | null {
    const host = the("dock");
    try {
      const dock = new DockView(host, this.recording, new Samples(this.recording), this.state, this.theme);
      the("wait").hidden = true;
      return dock;
    } catch (error) {
      the("wait").textContent = "The dock is not drawn: this browser has no WebGL 2. Lanes and plots work without it.";
      the("shown").hidden = true;
      console.info(error);
      return null;
    }
  }

  private connect(): void {
    const { state } = this;
    const click = (id: string, what: () => void): void => the(id).addEventListener("click", what);
    click("play", () => state.play(!state.playing));
    click("nearer", () => state.zoom(0.5, this.focus()));
    click("farther", () => state.zoom(2, this.focus()));
    click("whole", () => state.whole());
    click("previous", () => this.nextMiss(-1));
    click("next", () => this.nextMiss(1));
    click("picture", () => void this.picture());
    click("theme", () => this.dress(this.theme.dark ? LIGHT : DARK));
    click("keys", () => this.help(the("help").hidden));
    click("home", () => this.dock?.goHome());
    for (const option of OPTIONS) {
      const box = the<HTMLInputElement>(option);
      box.addEventListener("change", () => state.set(option, box.checked));
    }
    const speed = the<HTMLSelectElement>("speed");
    for (const one of SPEEDS) speed.append(new Option(one < 1 ? `1/${Math.round(1 / one)}` : String(one), String(one), false, one === 1));
    speed.addEventListener("change", () => state.setSpeed(Number(speed.value)));
    const slider = the<HTMLInputElement>("slider");
    slider.addEventListener("input", () => {
      state.seek(state.begin + (Number(slider.value) / 100_000) * (state.end - state.begin));
      state.follow();
    });
    state.listen((part) => this.changed(part));
    keys(state, {
      miss: (by) => {
        this.nextMiss(by);
        if (state.miss >= 0) this.enter(the("miss"));
      },
      event: () => this.nextEvent(), focus: () => this.focus(), picture: () => void this.picture(), home: () => this.dock?.goHome(),
      theme: () => this.dress(this.theme.dark ? LIGHT : DARK), help: () => this.help(the("help").hidden),
      escape: () => (the("help").hidden ? state.choose(-1) : this.help(false)),
    });
    addEventListener("resize", () => this.resize());
    new ResizeObserver(() => this.resize()).observe(the("dock"));
    addEventListener("hashchange", (event) => this.follow(new URL(event.newURL).hash)); // the page may have written another one since
    for (const event of ["keydown", "pointerdown", "wheel"]) addEventListener(event, () => this.note(""), { capture: true, passive: true });
    this.connectTime();
    this.connectDock();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => this.dress(event.matches ? DARK : LIGHT));
  }

  private connectTime(): void {
    const { state, lanes, plots } = this;
    gestures.listen(the("time"), {
      timeAt: (x) => lanes.timeAt(x),
      secondsPerPixel: () => (state.to - state.from) / lanes.width,
      zoom: (factor, around) => state.zoom(factor, around),
      pan: (by) => state.pan(by),
      whole: () => state.whole(),
      click: (x, y, coarse) => {
        const time = lanes.timeAt(x), run = lanes.missAt(x, y, coarse);
        if (lanes.covers(x)) state.seek(time);
        if (run < 0) return;
        state.choose(run);
        this.enter(the("miss"));
      },
      hover: (x, y, coarse) => hint(the("hint"), lanes.explain(x, y, coarse) ?? plots.explain(lanes.timeAt(x), y), x, y),
      leave: () => hint(the("hint"), null, 0, 0),
    });
  }

  private connectDock(): void {
    const { dock } = this;
    if (!dock) return;
    dock.canvas.addEventListener("pointermove", (event) => hint(the("hint"), event.buttons === 0 ? dock.explain(event.clientX, event.clientY) : null, event.clientX, event.clientY));
    dock.canvas.addEventListener("pointerleave", () => hint(the("hint"), null, 0, 0));
    dock.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      the("wait").textContent = "The browser has taken WebGL away; the dock comes back with it.";
      the("wait").hidden = false;
    });
    dock.canvas.addEventListener("webglcontextrestored", () => {
      the("wait").hidden = true;
      dock.invalidate();
    });
  }

  /** What zooming keeps in its place: the instant where it is in view. */
  private focus(): number {
    const { now, from, to } = this.state;
    return now >= from && now <= to ? now : (from + to) / 2;
  }

  goTo(time: number): void {
    this.state.seek(time);
    this.state.follow();
  }

  private nextMiss(by: number): void {
    const { run, at } = this.lanes.misses, { state } = this;
    if (!run.length) return;
    // Several may have one deadline: where one of them was shown last, the others come next.
    const here = state.miss < 0 && this.lastMiss >= 0 && this.miss.instant(this.lastMiss) === state.now ? this.lastMiss : state.miss;
    let place = run.indexOf(here);
    if (place >= 0) place += by;
    else {
      place = at.findIndex((time) => time > state.now);
      if (by < 0) place = (place < 0 ? at.length : place) - 1;
    }
    if (place < 0 || place >= run.length) return;
    this.choose(run[place], true);
  }

  private choose(run: number, near: boolean): void {
    const { runs } = this.recording, { state } = this;
    const due = this.miss.instant(run);
    const width = Math.max(runs.ended[run], due) - Math.min(runs.released[run], runs.claimed[run]);
    if (near) state.show(Math.min(runs.released[run], runs.claimed[run]) - width, Math.max(runs.ended[run], due) + width);
    state.seek(due);
    state.choose(run);
  }

  private nextEvent(): void {
    const next = this.moments.find((moment) => moment.at > this.state.now + 1e-9);
    if (next) this.goTo(next.at);
  }

  /** A link tells all of what is shown: what it leaves out is the begin of the run, all of its time, no miss. */
  private follow(hash: string): void {
    const { state } = this, place = link.read(hash), run = place.miss === undefined ? -1 : this.miss.find(place.miss);
    const stretch = place.from !== undefined && place.to !== undefined && place.to > place.from;
    if (stretch) state.show(place.from!, place.to!);
    else state.whole();
    state.seek(state.begin);
    if (run >= 0) this.choose(run, !stretch);
    else if (state.miss >= 0) state.choose(-1);
    this.note(place.miss !== undefined && run < 0 ? `The link names the job ${words.plain(place.miss)}; this page has none of that name.` : "");
    if (place.t !== undefined) this.goTo(place.t);
  }

  /** A message that stays until the reader does something. */
  private note(text: string): void {
    const note = the("note");
    note.textContent = text;
    note.hidden = text === "";
  }

  private help(open: boolean): void {
    const host = the("help");
    if (!open) this.leave(host);
    host.hidden = !open;
    the("keys").setAttribute("aria-expanded", String(open));
    if (!open) return;
    help(host, this.recording, this.theme, () => this.help(false));
    this.enter(host);
  }

  /** The focus goes into a panel, which is read there; and back when it closes. */
  private enter(panel: HTMLElement): void {
    const on = document.activeElement;
    if (on instanceof HTMLElement && on !== document.body && !on.closest("aside")) this.focused = on;
    panel.focus({ preventScroll: true });
  }

  private leave(panel: HTMLElement): void {
    if (panel.contains(document.activeElement)) (this.focused ?? this.lanes.canvas).focus({ preventScroll: true });
  }

  private dress(theme: Theme): void {
    this.theme = theme;
    document.documentElement.dataset.theme = theme.dark ? "dark" : "light";
    this.dock?.dress(theme);
    this.lanes.dress(theme);
    this.plots.dress(theme);
    if (!the("help").hidden) this.help(true);
  }

  private changed(part: string): void {
    const { state } = this;
    if (part === "now" || part === "options") this.dock?.invalidate();
    if (part === "view") this.plots.invalidate();
    if (part === "view" || part === "miss") this.lanes.invalidate();
    if (part === "miss") {
      const within = the("miss").contains(document.activeElement);
      if (state.miss >= 0) this.lastMiss = state.miss;
      else this.leave(the("miss"));
      this.miss.show();
      if (within && state.miss >= 0) this.enter(the("miss")); // what had the focus has gone
      this.resize();
    }
    if (part === "playing") {
      the("play").textContent = state.playing ? "❚❚" : "▶";
      the("play").setAttribute("aria-label", state.playing ? "Stop" : "Play");
    }
    if (part === "speed") the<HTMLSelectElement>("speed").value = String(state.speed);
    if (part === "options") for (const option of OPTIONS) the<HTMLInputElement>(option).checked = state.options[option];
    this.showNow();
    this.hashAt = 0;
  }

  private showNow(): void {
    const { state } = this, width = state.to - state.from;
    the<HTMLInputElement>("slider").value = String(Math.round((100_000 * (state.now - state.begin)) / Math.max(1e-12, state.end - state.begin)));
    const step = Math.min(1e-2, width / 1000);
    the("clock").textContent = `${words.instant(state.now, step)} of ${words.duration(state.end)}`;
    the("slider").setAttribute("aria-valuetext", the("clock").textContent!);
    const cursor = the("cursor"), x = this.left + ((state.now - state.from) / width) * this.lanes.width;
    cursor.hidden = state.now < state.from || state.now > state.to;
    cursor.style.transform = `translateX(${x - 1}px)`;
  }

  private resize(): void {
    const left = gutter();
    if (left !== this.left) this.lanes.left = this.left = left;
    this.plots.resize(left);
    this.lanes.invalidate();
    this.plots.invalidate();
    this.dock?.resize();
    the("cursor").style.height = `${the("lanes").scrollHeight + the("plots").scrollHeight}px`;
    this.showNow();
  }

  private async picture(): Promise<void> {
    const blob = await png(words.plain(this.recording.header.title), words.instant(this.state.now, 1e-6), this.dock?.picture() ?? null, [{ canvas: this.lanes.canvas, says: [] }, ...this.plots.pictures], this.theme);
    save(blob, `cmrc-${this.state.now.toFixed(3)}s.png`);
  }

  private frame(now: number): void {
    const began = performance.now();
    if (this.last > 0) this.state.advance(Math.min(0.25, (now - this.last) / 1000));
    this.last = now;
    const drew = this.dock?.draw(now) ?? false;
    const lanes = this.lanes.draw();
    this.plots.draw();
    if (lanes) the("cursor").style.height = `${the("lanes").scrollHeight + the("plots").scrollHeight}px`;
    if (drew || lanes || this.state.playing) {
      this.frames.push(performance.now() - began);
      if (this.frames.length > 600) this.frames.splice(0, 300);
    }
    // The address tells the place once it has come to rest.
    if (!this.state.playing && now - this.hashAt > 300) {
      if (this.hashAt === 0) this.hashAt = now;
      else this.writeHash();
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  private writeHash(): void {
    const hash = link.written(this.state, this.state.miss >= 0 ? this.miss.id(this.state.miss) : null);
    this.hashAt = Infinity;
    if (hash === location.hash) return;
    try {
      history.replaceState(null, "", hash);
    } catch {
      // A browser may forbid it to a page from a file.
    }
  }
}

async function start(): Promise<void> {
  const wait = the("wait");
  try {
    const holder = the("recording");
    const recording = await decode(holder.textContent ?? "");
    holder.remove();
    (window as unknown as { page: Page }).page = new Page(recording);
    document.documentElement.dataset.ready = "yes";
  } catch (error) {
    wait.hidden = false;
    wait.textContent = `The page cannot be shown: ${error instanceof Error ? error.message : String(error)}`;
    throw error;
  }
}

void start();
