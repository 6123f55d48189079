// What happened at instants: as the scenario asked, failures, errors that were dealt with, and what the dock tells.
import type { Recording } from "../data/recording";
import { dockEvent, isBad } from "../data/words";

export interface Moment {
  at: number;
  what: string;
  bad: boolean;
  scripted: boolean;
}

const DULL = new Set(["near_contact", "free_again", "joint_stuck", "joint_slipped"]);

export function momentsOf(recording: Recording): Moment[] {
  const { report, header } = recording;
  const all: Moment[] = [];
  for (const { time_s, what } of report.timed_events ?? []) all.push({ at: time_s, what, bad: false, scripted: true });
  for (const { time_s, dsp, kind, message } of report.failures ?? []) {
    if (kind === "plant") continue; // the dock tells it itself
    all.push({ at: time_s, what: `${dsp === null || dsp === undefined ? "" : `DSP ${dsp}: `}${kind}: ${message}`, bad: true, scripted: false });
  }
  for (const [at, kind, object, details] of header.dock_events) if (!DULL.has(kind)) all.push({ at, what: dockEvent(kind, object, details), bad: isBad(kind), scripted: false });
  return all.filter((moment) => moment.at >= header.from_s).sort((a, b) => a.at - b.at);
}
