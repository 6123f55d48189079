// The resolution of the picture: slow WebGL (in software) draws fewer pixels, and keeps its frame rate.

const SLOW = 40, FAST = 22; // ms per frame
const LEAST = 0.35;

export class Pace {
  scale = 1;
  private mean = 0;
  private last = 0;
  private frames = 0;

  /** After each frame of an animation; true: the scale has changed. */
  frame(now: number): boolean {
    const took = now - this.last;
    this.last = now;
    if (took <= 0 || took > 1000) return false; // the first one, or the page was hidden
    this.mean = this.mean === 0 ? took : 0.85 * this.mean + 0.15 * took;
    if (++this.frames < 12) return false;
    const before = this.scale;
    if (this.mean > SLOW) this.scale = Math.max(LEAST, this.scale * Math.max(0.6, Math.sqrt(SLOW / this.mean) * 0.95));
    else if (this.mean < FAST && this.frames > 90) this.scale = Math.min(1, this.scale * 1.2);
    else return false;
    if (this.scale === before) return false;
    this.frames = 0;
    this.mean = 0;
    return true;
  }

  rest(): void {
    this.last = 0;
  }
}
