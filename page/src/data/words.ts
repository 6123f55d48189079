// What things are called in words.
import { WAITS, type Header, type Runs } from "./recording";
import { ASLEEP, AWAKE, FAILED, OFF } from "./lanes";

/** Text without characters that control a terminal, a line, or the direction of the text beside it. */
export function plain(text: string): string {
  return text.replace(/[\u0000-\u001f\u007f-\u009f\u2028\u2029]/g, " ").replace(/[\u200e\u200f\u061c\u202a-\u202e\u2066-\u2069]/g, "");
}

/** A time with the unit that suits it. */
export function time(seconds: number): string {
  const size = Math.abs(seconds);
  if (size === 0) return "0";
  if (size < 1e-6) return `${(seconds * 1e9).toFixed(0)} ns`;
  if (size < 1e-3) return `${(seconds * 1e6).toFixed(2)} µs`;
  if (size < 1) return `${(seconds * 1e3).toFixed(size < 0.1 ? 3 : 1)} ms`;
  return `${seconds.toFixed(3)} s`;
}

/** An instant, as fine as a step of `step` s needs it. */
export function instant(seconds: number, step = 1e-3): string {
  return `${seconds.toFixed(Math.min(9, Math.max(0, Math.ceil(-Math.log10(step)))))} s`;
}

/** A length with the unit that suits it, as the report on the terminal has it. */
export function length(metres: number): string {
  const size = Math.abs(metres), digits = (value: number, count: number): number => Number(value.toPrecision(count));
  if (size === 0) return "0 m";
  return size < 1e-3 ? `${digits(metres * 1e6, 3)} µm` : size < 1 ? `${digits(metres * 1e3, 3)} mm` : `${digits(metres, 4)} m`;
}

/** The length of a run: all digits that it has, to the microsecond. */
export function duration(seconds: number): string {
  return `${Number(seconds.toFixed(6))} s`;
}

const STOPS: Record<string, string> = {
  interrupted: "interrupted", under_way: "under way", job_done: "the job is done", no_dsp_left: "no DSP was left", drives_stopped: "the drives have stopped",
  plant_fault: "the plant faulted",
};

/** Why a run ended before its time. */
export function stop(reason: string): string {
  return STOPS[reason] ?? reason.replaceAll("_", " ");
}

export function robot(number: number): string {
  return number === 0 ? "crane" : `AGV ${number - 1}`;
}

const TASKS: [RegExp, string][] = [
  [/^pid$/, "the crane's servo: encoders in, torques out"],
  [/^torque_compensation$/, "torques that the motion needs, for PID to add"],
  [/^trajectory_planning/, "the next point of the path"],
  [/^inverse_kinematics/, "from a point to joints or wheels"],
  [/^obstacle_avoidance$/, "looks for what is in the vehicle's way"],
  [/^identify$/, "reads the bay scanner: where the container is"],
  [/^grab_path$/, "plans the route to the container"],
  [/^home/, "the way home"],
  [/^error$/, "decides what to do about an error"],
  [/^recompute$/, "runs again what a dead DSP left"],
  [/^user\./, "a task of the user's own"],
];

export function task(kind: string): string {
  return TASKS.find(([of]) => of.test(kind))?.[1] ?? "";
}

export const STATES: Record<number, string> = {
  [OFF]: "there is no board, or it boots",
  [FAILED]: "is dead: it runs nothing until it is reset",
  [ASLEEP]: "sleeps: the list has nothing for it, until the host rings",
  [AWAKE]: "runs its executive: looks into the list, claims or hands over a block",
};

/** What a stretch of a lane, or a run, waited for: a line, or none. */
export function waits(of: Float32Array[], index: number): string[] {
  const parts = WAITS.map((name, cause) => ({ name, took: of[cause][index] })).filter(({ took }) => took > 0);
  return parts.length ? [`of this it waited ${parts.map(({ name, took }) => `${time(took)} for ${name}`).join(", ")}`] : [];
}

export function job(header: Header, runs: Runs, run: number): string {
  const kind = header.kinds[runs.kind[run]];
  const of = /\.(crane|agv)$/.test(kind) || runs.robot[run] > 0 ? ` of ${robot(runs.robot[run])}` : "";
  return `${kind}${of}, job ${runs.number[run]}`;
}

export function verdict(runs: Runs, run: number): string {
  const spare = runs.deadline[run] - runs.ended[run], outcome = runs.outcomes[runs.outcome[run]];
  if (runs.missed[run]) return outcome === "late" ? `MISSED: late by ${time(-spare)}` : `MISSED: ${outcome}`;
  if (Number.isNaN(runs.deadline[run])) return `${outcome}; it has no deadline`;
  return outcome === "on time" ? `in time, ${time(spare)} to spare` : outcome;
}

/** A run of a job in lines; the first is its title. */
export function runLines(header: Header, runs: Runs, run: number): string[] {
  const lines = [job(header, runs, run), task(header.kinds[runs.kind[run]])];
  if (runs.slot[run] >= 0) {
    lines.push(`DSP ${runs.slot[run]} claimed it at ${instant(runs.claimed[run], 1e-7)}`);
    lines.push(`and ran it for ${time(runs.ended[run] - runs.claimed[run])} (${runs.ends[runs.end[run]]})`);
    lines.push(...waits(runs.waits, run));
    const since = runs.claimed[run] - runs.released[run];
    lines.push(since >= 0 ? `released ${time(since)} before the claim` : `claimed ${time(-since)} before its tick`);
  } else {
    lines.push(`released at ${instant(runs.released[run], 1e-6)}; no DSP ever ran it`);
  }
  lines.push(verdict(runs, run));
  return lines.filter((line) => line !== "");
}

/** The parts of a miss's chain (docs/report.md, Why late). */
export const PARTS: Record<string, string> = {
  host_late: "the host's refresh that put it up began late",
  not_due: "it was in the list and not due yet",
  host_refresh: "the host's refresh was at work",
  host_lock: "the refresh waited for the list, which a DSP held",
  doorbell: "every free DSP was asleep, to be rung and woken",
  claim: "a DSP was free: the instructions of its claim",
  claim_bus_a: "the claim waited for bus A",
  claim_bus_b: "the claim waited for bus B",
  lock: "the claim waited for the list, which somebody else held",
  blocked: "every DSP ran a block that was claimed before this one could be",
  behind_list: "blocks before it in the list kept every DSP busy",
  no_dsp: "no DSP was there",
  own_dsp_out: "the one DSP that may run it was not there",
  lost_run: "runs that came to nothing",
  watchdog: "until the watchdog noticed that its DSP had failed",
  previous_out: "the block of an earlier tick was still out",
  stopped_by_error: "an error had stopped the servo, or was not decided yet",
  left_out: "the experiment left this tick out",
  not_run: "it has no run of its own: less a usual run",
  slack: "less the slack that it had",
};

export function part(name: string): string {
  if (name.startsWith("execution.")) return `its run against the usual one: ${name.slice(10).replaceAll("_", " ")}`;
  return PARTS[name] ?? name.replaceAll("_", " ");
}

const DOCK: Record<string, string> = {
  near_contact: "the load is near something to land on", free_again: "the load hangs free again", touch: "the load touches",
  hard_landing: "hard landing", landed: "all four corners are down", lifted: "all four corners are off", locked: "the twist locks close",
  opened: "the twist locks open", refused: "the twist locks turned back", set_on_agv: "the container is on the vehicle",
  agv_dry: "a vehicle's set-points ran dry", agv_overflow: "a vehicle's buffer ran over", agv_arrived: "a vehicle has arrived at the warehouse",
  delivered: "a container is delivered", joint_limit: "a joint ran into its end stop", drive_stopped: "a drive got no torque code and brakes",
  drive_resumed: "a drive takes codes again", drive_tripped: "a drive tripped", drive_warm: "a drive is warm", fault: "the sway passed 40 degrees",
  joint_stuck: "a joint sticks", joint_slipped: "a joint broke away", collision: "a vehicle ran into something", missed: "a landing is to be tried again",
};

export function dockEvent(kind: string, object: string, details: string): string {
  return `${DOCK[kind] ?? kind}${object ? ` (${object})` : ""}${details ? `: ${details}` : ""}`;
}

/** Dock events that are bad news. */
export function isBad(kind: string): boolean {
  return /hard|fault|limit|refused|dry|stopped|collision|missed|tripped|overflow/.test(kind);
}
