// Colours that colour-blind people can tell apart (Okabe and Ito, 2008), and those of the page's two themes.

export const OKABE_ITO = {
  orange: "#E69F00", sky: "#56B4E9", green: "#009E73", yellow: "#F0E442", blue: "#0072B2", vermillion: "#D55E00", purple: "#CC79A7",
};

export interface Theme {
  dark: boolean;
  ink: string;
  soft: string; // lines and small text
  paper: string;
  panel: string;
  groups: string[];
  sky: string;
  ground: string;
  water: string;
}

/** What the lanes distinguish: names and their meanings. */
export const GROUPS = [
  { name: "no board, or booting", of: "" },
  { name: "dead", of: "failed, and not yet reset" },
  { name: "asleep", of: "waits for the doorbell" },
  { name: "executive", of: "wakes up, looks into the list, claims" },
  { name: "PID", of: "pid" },
  { name: "torque compensation", of: "torque_compensation" },
  { name: "trajectory planning", of: "trajectory_planning" },
  { name: "inverse kinematics", of: "inverse_kinematics" },
  { name: "obstacle avoidance", of: "obstacle_avoidance" },
  { name: "identify, paths", of: "identify|grab_path|home" },
  { name: "other tasks", of: "" },
];
export const GROUP_OFF = 0, GROUP_FAILED = 1, GROUP_ASLEEP = 2, GROUP_AWAKE = 3, GROUP_OTHER = 10;

/** Of what a lane waits for (WAITS), at its foot. */
export const WAIT_COLOURS = [OKABE_ITO.blue, OKABE_ITO.orange, OKABE_ITO.purple];

/** By what a lane's segment is (data/lanes.ts), its group. */
export function groupsOf(kinds: string[]): Uint8Array {
  const of = new Uint8Array(4 + kinds.length);
  of.set([GROUP_OFF, GROUP_FAILED, GROUP_ASLEEP, GROUP_AWAKE]);
  kinds.forEach((kind, i) => {
    const group = GROUPS.findIndex((row, g) => g > GROUP_AWAKE && g < GROUP_OTHER && new RegExp(`^(${row.of})`).test(kind));
    of[4 + i] = group < 0 ? GROUP_OTHER : group;
  });
  return of;
}

const tasks = [OKABE_ITO.blue, OKABE_ITO.sky, OKABE_ITO.green, OKABE_ITO.yellow, OKABE_ITO.orange, OKABE_ITO.purple];

export const LIGHT: Theme = {
  dark: false, ink: "#1b1f24", soft: "#5c6670", paper: "#f3f4f1", panel: "#ffffff",
  groups: ["#ffffff", OKABE_ITO.vermillion, "#eceeec", "#bfc4c8", ...tasks, "#3c4043"],
  sky: "#dfe8ee", ground: "#c9c8c0", water: "#9dbdd2",
};
export const DARK: Theme = {
  dark: true, ink: "#e8eaed", soft: "#a2abb4", paper: "#14171a", panel: "#1d2125",
  groups: ["#1d2125", OKABE_ITO.vermillion, "#2a2f34", "#5c646c", "#0a7cc4", ...tasks.slice(1), "#d5d8db"],
  sky: "#20272e", ground: "#4a4d4c", water: "#2b4252",
};

export function rgb(hex: string): [number, number, number] {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}
