// Why a job missed its deadline: its chain of causes, the blocks in its way, its runs.
import { due } from "../data/jobs";
import type { Miss, Recording } from "../data/recording";
import * as words from "../data/words";
import type { State } from "./state";

function element(tag: string, text = "", className = ""): HTMLElement {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

const PS = 1e-12;

export class MissPanel {
  private readonly chains = new Map<string, Miss>();

  constructor(private readonly host: HTMLElement, private readonly recording: Recording, private readonly state: State, private readonly goTo: (time: number) => void) {
    for (const miss of recording.report.misses ?? []) this.chains.set(`${miss.kind}:${miss.robot}:${miss.number}`, miss);
  }

  /** What a link calls the job. */
  id(run: number): string {
    const { header, runs } = this.recording;
    return `${header.kinds[runs.kind[run]]}:${runs.robot[run]}:${runs.number[run]}`;
  }

  /** The last run of the job of that name; -1: there is none. */
  find(id: string): number {
    const { header, runs } = this.recording, [kind, robot, number] = [id.slice(0, id.indexOf(":")), ...id.slice(id.indexOf(":") + 1).split(":").map(Number)] as [string, number, number];
    const k = header.kinds.indexOf(kind);
    for (let i = runs.count - 1; i >= 0; --i) if (runs.kind[i] === k && runs.robot[i] === robot && runs.number[i] === number) return i;
    return -1;
  }

  /** Of an instant whose miss is told: its deadline, of a job without one its end. */
  instant(run: number): number {
    return due(this.recording.runs, run);
  }

  show(): void {
    const { miss } = this.state;
    this.host.hidden = miss < 0;
    document.body.classList.toggle("aside", miss >= 0);
    this.host.replaceChildren();
    if (miss < 0) return;
    const { header, runs, report } = this.recording;
    const close = element("button", "×", "close");
    close.setAttribute("aria-label", "Close");
    close.addEventListener("click", () => this.state.choose(-1));
    this.host.append(close, element("h2", words.job(header, runs, miss)), element("p", words.verdict(runs, miss), runs.missed[miss] ? "bad" : ""));
    const chain = this.chains.get(this.id(miss));
    if (chain) this.chain(chain);
    else if (runs.missed[miss])
      this.host.append(element("p", `Its chain of causes was not kept: the report tells the first ${report.misses.length}, and ${report.misses_left_out} more are left out (report.misses_max).`));
    const list = element("ul");
    for (const line of words.runLines(header, runs, miss).slice(1, -1)) list.append(element("li", line));
    this.host.append(list);
  }

  private chain(chain: Miss): void {
    const late = chain.lateness_ps;
    this.host.append(element("h3", late === null || late <= 0 ? "Where its time went" : `Why it was ${words.time(late * PS)} late`));
    const parts = Object.entries(chain.parts_ps).sort((a, b) => Math.abs(b[1]) - Math.abs(a[1]));
    const most = Math.max(1, ...parts.map(([, ps]) => Math.abs(ps)));
    const table = element("div", "", "chain"), small = element("div", "", "chain");
    for (const [name, ps] of parts) {
      const row = element("div", "", ps < 0 ? "part less" : "part");
      row.append(element("span", `${ps < 0 ? "−" : "+"}${words.time(Math.abs(ps) * PS)}`, "amount"));
      const bar = element("span", "", "bar");
      bar.style.width = `${Math.max(1, (100 * Math.abs(ps)) / most)}%`;
      const cell = element("span", "", "track");
      cell.append(bar);
      row.append(cell, element("span", words.part(name), "says"));
      (Math.abs(ps) < most / 100 ? small : table).append(row);
    }
    const sum = late !== null && late > 0 ? element("div", "", "part sum") : null;
    if (sum && late !== null) {
      sum.append(element("span", `=${words.time(late * PS)}`, "amount"), element("span", "", "track"), element("span", "late; the parts add up to the picosecond", "says"));
    }
    if (small.childElementCount > 2) {
      const more = document.createElement("details");
      more.append(element("summary", `${small.childElementCount} parts of less than a hundredth of the largest`), small);
      table.append(more);
    } else {
      table.append(...small.childNodes);
    }
    if (sum) table.append(sum);
    this.host.append(table);
    if (chain.unavoidable_ps !== null && chain.unavoidable_ps !== undefined) this.jump("It could not be avoided any more from", chain.unavoidable_ps);
    if (chain.previous !== undefined && chain.previous !== null) this.host.append(element("p", `The job still out was number ${chain.previous}.`));
    if (chain.behind?.length) {
      this.host.append(element("h3", "In its way"));
      const list = element("ul", "", "behind");
      for (const one of chain.behind.slice(0, 40)) {
        const item = element("li");
        const button = element("button", `${one.kind} ${one.number}`, "link");
        button.addEventListener("click", () => this.goTo(one.claimed_ps * PS));
        item.append(button, ` on DSP ${one.dsp}: ${words.time(one.share_ps * PS)}${one.overtook ? ", it was before it in the list" : ", it was claimed before"}`);
        list.append(item);
      }
      if (chain.behind.length > 40) list.append(element("li", `and ${chain.behind.length - 40} more`));
      this.host.append(list);
    }
    this.jump("Released at", chain.release_ps);
    if (chain.deadline_ps !== null) this.jump("Deadline at", chain.deadline_ps);
  }

  private jump(says: string, ps: number): void {
    const line = element("p", `${says} `);
    const button = element("button", words.instant(ps * PS, 1e-6), "link");
    button.addEventListener("click", () => this.goTo(ps * PS));
    line.append(button);
    this.host.append(line);
  }
}
