// The legend, and the keys.
import { WAITS, type Recording } from "../data/recording";
import { GROUPS, groupsOf, OKABE_ITO, WAIT_COLOURS, type Theme } from "./colours";

const KEYS: [string, string][] = [
  ["space", "play, stop"], ["← →", "a step of the view back or on"], ["Home End", "the begin and the end of the run"], ["+ −", "show less, more time"], ["0", "the whole run"],
  ["[ ]", "slower, faster"], ["n p", "the next miss, the one before"], ["e", "the next event"], ["r g l", "rays, ideal run, planned path"],
  ["h", "the first view of the dock"], ["d", "dark or light"], ["s", "save as PNG"], ["? Esc", "open and close this"],
];

function swatch(draw: (context: CanvasRenderingContext2D) => void): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = 52;
  canvas.height = 30;
  draw(canvas.getContext("2d")!);
  return canvas;
}

export function help(host: HTMLElement, recording: Recording, theme: Theme, close: () => void): void {
  host.replaceChildren();
  const button = document.createElement("button");
  button.className = "close";
  button.textContent = "×";
  button.setAttribute("aria-label", "Close");
  button.addEventListener("click", close);
  const legend = document.createElement("div");
  legend.className = "legend";
  const row = (draw: (context: CanvasRenderingContext2D) => void, text: string): void => {
    const words = document.createElement("span");
    words.textContent = text;
    legend.append(swatch(draw), words);
  };
  const kinds = recording.header.kinds, groupOf = groupsOf(kinds), present = new Set<number>();
  for (const lane of recording.lanes) for (const what of lane.what) present.add(groupOf[what]);
  GROUPS.forEach((group, g) => {
    if (!present.has(g)) return;
    row((context) => {
      context.fillStyle = theme.groups[g];
      context.fillRect(0, 0, 52, 30);
      if (g !== 1) return;
      context.strokeStyle = "#000000";
      context.lineWidth = 3;
      for (let x = -30; x < 60; x += 13) context.beginPath(), context.moveTo(x, 30), context.lineTo(x + 30, 0), context.stroke();
    }, g > 3 && group.of ? `${group.name}${group.name === "identify, paths" ? "" : " (a task)"}` : `${group.name}${group.of ? `: ${group.of}` : ""}`);
  });
  WAITS.forEach((name, cause) =>
    row((context) => {
      context.fillStyle = theme.groups[2];
      context.fillRect(0, 0, 52, 30);
      context.fillStyle = WAIT_COLOURS[cause];
      context.fillRect(0, 21, 52, 9);
    }, `at a lane's foot: the DSP waited for ${name}; full is 5 % of the time`));
  const shape = (colour: string, path: (context: CanvasRenderingContext2D) => void) => (context: CanvasRenderingContext2D): void => {
    context.fillStyle = context.strokeStyle = colour;
    context.lineWidth = 4;
    context.beginPath();
    path(context);
    context.fill();
  };
  row(shape(OKABE_ITO.sky, (c) => c.arc(26, 15, 9, 0, 7)), "a deadline that was met: the job's end");
  row(shape(OKABE_ITO.vermillion, (c) => (c.moveTo(26, 2), c.lineTo(40, 28), c.lineTo(12, 28))), "a deadline that was missed");
  row((context) => {
    context.strokeStyle = theme.ink;
    context.lineWidth = 4;
    context.beginPath();
    context.arc(26, 15, 9, 0, 7);
    context.stroke();
  }, "the end of another job: it had no deadline, or was not finished when the run ended");
  row(shape(OKABE_ITO.orange, (c) => (c.moveTo(14, 4), c.lineTo(38, 4), c.lineTo(26, 27))), "an event of the scenario");
  row(shape(OKABE_ITO.vermillion, (c) => c.rect(14, 4, 22, 22)), "a failure");
  row(shape(theme.soft, (c) => c.arc(26, 15, 6, 0, 7)), "an event of the dock");
  const line = (colour: string) => (context: CanvasRenderingContext2D): void => {
    context.fillStyle = colour;
    context.fillRect(2, 12, 48, 6);
  };
  row(line(OKABE_ITO.sky), "the ideal run: its load, its vehicles, and dashed its path ahead");
  row(line(OKABE_ITO.purple), "the path that trajectory planning has made");
  row(line(OKABE_ITO.vermillion), "a range ray that meets something");
  const keys = document.createElement("div");
  keys.className = "keys";
  for (const [key, text] of KEYS) {
    const names = document.createElement("span"), says = document.createElement("span");
    key.split(" ").forEach((one, i) => {
      const cap = document.createElement("kbd");
      cap.textContent = one;
      names.append(...(i ? [" ", cap] : [cap]));
    });
    says.textContent = text;
    keys.append(names, says);
  }
  const heading = (text: string, level = "h3"): HTMLElement => Object.assign(document.createElement(level), { textContent: text });
  const words = (text: string): HTMLElement => Object.assign(document.createElement("p"), { textContent: text });
  host.append(button, heading("Legend", "h2"), legend,
    words("Where stretches are too short to be drawn, a column of a lane is filled by the shares of its time. Hover explains; a click on a miss tells why."),
    heading("Keys"), keys,
    words("In the dock: drag turns, right drag or two fingers move, wheel or pinch come nearer; with the keyboard arrows, + and −. On the lanes: wheel or pinch zoom, drag moves, click goes there, double click shows all."),
    words("Drawn with three.js and uPlot (MIT); their licences are in this file's source and in page/dist/licences.txt."));
}
