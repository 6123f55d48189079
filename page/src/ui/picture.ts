// The page as one PNG: the dock, the lanes, the plots, under the title.
import type { Theme } from "./colours";

/** A canvas, and the lines that stand beside it on the page. */
export interface Part {
  canvas: HTMLCanvasElement;
  says: string[];
}

export async function png(title: string, instant: string, dock: HTMLCanvasElement | null, below: Part[], theme: Theme): Promise<Blob> {
  const dots = Math.min(2, devicePixelRatio), width = Math.max(...below.map(({ canvas }) => canvas.width), 320);
  const head = Math.round(34 * dots), dockHeight = dock ? Math.round((width * dock.height) / dock.width) : 0;
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = head + dockHeight + below.reduce((sum, { canvas }) => sum + canvas.height, 0);
  const context = canvas.getContext("2d")!;
  context.fillStyle = theme.panel;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = theme.ink;
  context.font = `600 ${15 * dots}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  context.fillText(`${title} — ${instant}`, 10 * dots, head / 2);
  if (dock) context.drawImage(dock, 0, head, width, dockHeight);
  let y = head + dockHeight;
  const line = 14 * dots;
  context.font = `${11.5 * dots}px system-ui, sans-serif`;
  for (const { canvas: one, says } of below) {
    context.drawImage(one, 0, y);
    says.forEach((text, i) => context.fillText(text, 8 * dots, y + one.height / 2 + (i - (says.length - 1) / 2) * line));
    y += one.height;
  }
  return new Promise((done, failed) => canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error("the browser makes no picture"))), "image/png"));
}

export function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
