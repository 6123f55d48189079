// The head: the run's title, and how it went.
import type { Recording } from "../data/recording";
import * as words from "../data/words";

/** `shown`: how many misses the page can show. */
export function head(title: HTMLElement, facts: HTMLElement, { header, report }: Recording, shown: number): void {
  title.textContent = document.title = words.plain(header.title);
  const misses = Object.values(report.tasks).reduce((sum, task) => sum + task.misses, 0);
  const bold = (text: string): HTMLElement => Object.assign(document.createElement("b"), { textContent: text });
  facts.textContent = "";
  if (report.stop_reason !== "completed")
    facts.append(bold(`ended at ${words.duration(report.simulated_s)} of ${words.duration(Number(report.configuration["run.duration_s"]))}: ${words.stop(report.stop_reason)}`), " · ");
  facts.append(misses ? bold(`${misses} deadline${misses === 1 ? "" : "s"} missed`) : "no deadline missed");
  if (shown !== misses) facts.append(`, ${shown} of them on this page`);
  if (report.errors) {
    const { load_m: load, window_s: [from, to] } = report.errors, longer = from < header.from_s || to > header.to_s + 1e-9;
    facts.append(` · load ${words.length(load.rms)} RMS from the ideal run, ${words.length(load.peak)} at most${longer ? `, from ${words.duration(from)} to ${words.duration(to)}` : ""}`);
  }
  if (header.lanes_until_s !== null) facts.append(` · DSPs recorded until ${words.instant(header.lanes_until_s)}`);
  facts.append(` · hash ${report.hash.slice(0, 12)}`);
  facts.title = facts.textContent ?? "";
}
