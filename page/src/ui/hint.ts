// The hint beside the pointer.

/** Lines at a place on the screen; null: nothing to say. */
export function hint(host: HTMLElement, lines: string[] | null, x: number, y: number): void {
  host.hidden = !lines?.length;
  if (!lines?.length) return;
  host.replaceChildren(...lines.map((line) => Object.assign(document.createElement("div"), { textContent: line })));
  const { width, height } = host.getBoundingClientRect();
  host.style.left = `${Math.max(4, Math.min(innerWidth - width - 4, x + 14))}px`;
  host.style.top = `${y + 18 + height > innerHeight ? Math.max(4, y - height - 12) : y + 18}px`;
}
