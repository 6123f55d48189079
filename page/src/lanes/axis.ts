// The time axis: round steps, as fine as the shown stretch of time needs.

const STEPS = [1, 2, 5];

export function stepFor(width: number, marks: number): number {
  const least = width / Math.max(1, marks);
  const power = 10 ** Math.floor(Math.log10(least));
  if (least > 10 && least < 120) return [15, 20, 30, 60, 120].find((step) => step >= least) ?? 120;
  return (STEPS.find((step) => step * power >= least) ?? 10) * power;
}

/** Marks between two instants. */
export function marks(from: number, to: number, step: number): number[] {
  const all: number[] = [];
  for (let n = Math.ceil(from / step - 1e-9); n * step <= to * (1 + 1e-12); ++n) all.push(n * step);
  return all;
}

/** The text of a mark. With fine steps it is the distance from a round instant (`baseOf`): +12.5 µs. */
export function label(mark: number, step: number, base: number): string {
  if (step >= 1e-3 || base === 0) return `${mark.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)))} s`;
  const [unit, scale] = step >= 1e-6 ? (["µs", 1e6] as const) : (["ns", 1e9] as const);
  const digits = Math.max(0, -Math.floor(Math.log10(step * scale) + 1e-9));
  return `+${((mark - base) * scale).toFixed(digits)} ${unit}`;
}

/** The round instant that fine marks are counted from. */
export function baseOf(from: number, step: number): number {
  return step >= 1e-3 ? 0 : Math.floor(from / (step * 1000) + 1e-9) * step * 1000;
}
