// Wheel, drag, pinch, click and hover on the lanes and plots.

export interface Target {
  timeAt(x: number): number;
  secondsPerPixel(): number;
  zoom(factor: number, around: number): void;
  pan(by: number): void;
  click(x: number, y: number, coarse: boolean): void;
  whole(): void;
  hover(x: number, y: number, coarse: boolean): void;
  leave(): void;
}

const STILL = 5; // px that a click may move

export function listen(element: HTMLElement, target: Target): void {
  const down = new Map<number, PointerEvent>();
  let moved = 0, spread = 0;
  element.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.shiftKey && Math.abs(event.deltaX) <= Math.abs(event.deltaY) && event.altKey) return;
    event.preventDefault();
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) target.pan((event.deltaX || event.deltaY) * target.secondsPerPixel());
    else target.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.0018))), target.timeAt(event.clientX));
  }, { passive: false });
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    down.set(event.pointerId, event);
    moved = 0;
    spread = apart(down);
    element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return target.hover(event.clientX, event.clientY, event.pointerType === "touch");
    moved += Math.abs(event.clientX - before.clientX) + Math.abs(event.clientY - before.clientY);
    down.set(event.pointerId, event);
    if (down.size === 1) {
      if (moved > STILL) target.pan(-(event.clientX - before.clientX) * target.secondsPerPixel());
      return;
    }
    const now = apart(down);
    if (spread > 8 && now > 8) target.zoom(spread / now, target.timeAt(middle(down)));
    spread = now;
  });
  const up = (event: PointerEvent): void => {
    const one = down.size === 1 && down.has(event.pointerId);
    down.delete(event.pointerId);
    spread = apart(down);
    if (one && event.type === "pointerup" && moved <= STILL) {
      target.click(event.clientX, event.clientY, event.pointerType === "touch");
      if (event.pointerType === "touch") target.hover(event.clientX, event.clientY, true);
    }
  };
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("pointerleave", (event) => {
    if (event.pointerType !== "touch") target.leave(); // what a finger has asked for stays
  });
  element.addEventListener("dblclick", () => target.whole());
}

function apart(down: Map<number, PointerEvent>): number {
  const [a, b] = [...down.values()];
  return a && b ? Math.abs(a.clientX - b.clientX) : 0;
}

function middle(down: Map<number, PointerEvent>): number {
  const [a, b] = [...down.values()];
  return (a.clientX + b.clientX) / 2;
}
