// The row of events: a mark at each instant at which something happened, and what it was.
import { before } from "../data/recording";
import * as words from "../data/words";
import { OKABE_ITO, type Theme } from "../ui/colours";
import type { Moment } from "../ui/events";
import type { State } from "../ui/state";
import type { Place } from "./paint";
import type { Row } from "./panel";

/** The text, or as much of its beginning as there is room for. */
function shortened(context: CanvasRenderingContext2D, text: string, room: number): string {
  if (context.measureText(text).width <= room) return text;
  let short = text;
  while (short.length > 2 && context.measureText(`${short}…`).width > room) short = short.slice(0, -1);
  return `${short}…`;
}

/** `theme`: the one that is shown. */
export function momentsRow(moments: Moment[], state: State, theme: () => Theme): Row {
  const instants = Float64Array.from(moments, (moment) => moment.at);
  const byOrder = [0, 1, 2].map((order) => { // what is drawn first comes first
    const own = moments.filter((moment) => (moment.scripted ? 2 : moment.bad ? 1 : 0) === order);
    return { own, at: Float64Array.from(own, (moment) => moment.at) };
  });

  function paint(context: CanvasRenderingContext2D, place: Place, dots: number): void {
    const { from, to } = state, scale = place.width / (to - from), middle = place.top + place.height / 2, size = 5 * dots;
    const x = (moment: Moment): number => place.left + (moment.at - from) * scale;
    const labelled: Moment[] = [];
    byOrder.forEach(({ own, at }, order) => {
      for (let i = before(at, from - 1e-12) + 1; i < at.length && at[i] <= to; ) {
        const moment = own[i];
        if (order) labelled.push(moment);
        context.fillStyle = moment.bad ? OKABE_ITO.vermillion : moment.scripted ? OKABE_ITO.orange : theme().soft;
        context.beginPath();
        if (moment.scripted) context.moveTo(x(moment) - size, middle - size), context.lineTo(x(moment) + size, middle - size), context.lineTo(x(moment), middle + size);
        else if (moment.bad) context.rect(x(moment) - size * 0.8, middle - size * 0.8, size * 1.6, size * 1.6);
        else context.arc(x(moment), middle, size * 0.55, 0, 7);
        context.fill();
        i = Math.max(i, before(at, at[i] + (2 * dots) / scale)) + 1; // one of each kind in two columns
      }
    });
    labelled.sort((a, b) => a.at - b.at);
    context.font = `${10.5 * dots}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    context.fillStyle = theme().ink;
    labelled.forEach((moment, i) => {
      const next = i + 1 < labelled.length ? x(labelled[i + 1]) - size : place.left + place.width;
      const room = Math.min(340 * dots, next - x(moment) - 2.5 * size);
      if (room > 30 * dots) context.fillText(shortened(context, moment.what, room), x(moment) + 1.6 * size, middle);
    });
  }

  function explain(time: number, reach: number): string[] | null {
    const first = before(instants, time - 2 * reach - 1e-12) + 1, upTo = before(instants, time + 2 * reach);
    const lines = moments.slice(first, Math.min(upTo + 1, first + 8)).map((moment) => `${words.instant(moment.at, 1e-4)}: ${moment.what}`);
    return lines.length ? [...lines, ...(upTo - first >= 8 ? [`and ${upTo - first - 7} more`] : [])] : null;
  }

  return { name: "events", height: 18, paint, explain };
}
