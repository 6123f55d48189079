// The vehicles' range rays against the objects on the dock: the geometry of the sensor, without its noise.
import type { Layout } from "../data/recording";
import type { Samples } from "./samples";

const HEIGHT = 0.8, FARTHEST = 30; // m above the ground; m

/** A turned rectangle, or a circle of radius `halfX` where halfY is none. */
interface Solid {
  x: number;
  y: number;
  yaw: number;
  halfX: number;
  halfY: number | null;
  cos: number; // of yaw
  sin: number;
}

function solid(x: number, y: number, yaw: number, halfX: number, halfY: number | null): Solid {
  return { x, y, yaw, halfX, halfY, cos: Math.cos(yaw), sin: Math.sin(yaw) };
}

export function pose(samples: Samples, agv: number): [number, number, number] {
  return [samples.at(`agv${agv}_x_m`), samples.at(`agv${agv}_y_m`), samples.angle(`agv${agv}_heading_rad`)];
}

export function legsOf(layout: Layout, travel: number): [number, number][] {
  const { portal } = layout.crane;
  return portal.leg > 0 ? [1, -1].flatMap((u) => portal.rails.map((y): [number, number] => [travel + u * portal.along, y])) : [];
}

export function solidsAt(layout: Layout, samples: Samples): Solid[] {
  const flat = (b: number[]): Solid => solid((b[0] + b[1]) / 2, (b[2] + b[3]) / 2, 0, (b[1] - b[0]) / 2, (b[3] - b[2]) / 2);
  const all = [flat(layout.ship), ...layout.boxes.filter((b) => b[4] < HEIGHT).map(flat)];
  layout.movers.forEach(([radius, height], i) => {
    if (height > HEIGHT) all.push(solid(samples.at(`mover${i}_x_m`), samples.at(`mover${i}_y_m`), 0, radius, null));
  });
  const half = layout.crane.portal.leg / 2;
  for (const [x, y] of legsOf(layout, samples.at("s_m"))) all.push(solid(x, y, 0, half, half));
  for (let i = 0; i < layout.agv.count; ++i) {
    const [x, y, yaw] = pose(samples, i);
    all.push(solid(x, y, yaw, layout.agv.length / 2, layout.agv.width / 2));
  }
  return all;
}

/** How far a ray goes from a point, along (cos, sin) of its direction. */
export function reach(x: number, y: number, dirX: number, dirY: number, solids: Solid[]): number {
  let best = FARTHEST;
  for (const one of solids) {
    const { cos: c, sin: s, halfX, halfY } = one;
    const px = c * (x - one.x) + s * (y - one.y), py = -s * (x - one.x) + c * (y - one.y);
    const dx = c * dirX + s * dirY, dy = -s * dirX + c * dirY;
    if (halfY === null) {
      const b = px * dx + py * dy, root = b * b - px * px - py * py + halfX * halfX;
      if (root >= 0 && -b + Math.sqrt(root) >= 0) best = Math.min(best, Math.max(0, -b - Math.sqrt(root)));
      continue;
    }
    let near = 0, end = best;
    for (let axis = 0; axis < 2; ++axis) {
      const p = axis ? py : px, d = axis ? dy : dx, h = axis ? halfY : halfX;
      if (Math.abs(d) < 1e-12) {
        if (Math.abs(p) > h) end = -1;
        continue;
      }
      const a = (-h - p) / d, b = (h - p) / d;
      near = Math.max(near, Math.min(a, b));
      end = Math.min(end, Math.max(a, b));
    }
    if (near <= end) best = Math.min(best, near);
  }
  return best;
}

export const RAYS = 60; // of the sensor's 180

/** Ends of the rays of one vehicle: x, y, z of both ends of each, and whether it met something. */
export function raysOf(layout: Layout, samples: Samples, agv: number, solids: Solid[], at: Float32Array, hits: Uint8Array): void {
  const [x, y, heading] = pose(samples, agv);
  const fx = x + (layout.agv.length / 2) * Math.cos(heading), fy = y + (layout.agv.length / 2) * Math.sin(heading);
  const own = solids.length - layout.agv.count + agv;
  const near = solids.filter((one, i) => i !== own && Math.hypot(one.x - fx, one.y - fy) < FARTHEST + Math.hypot(one.halfX, one.halfY ?? 0));
  for (let k = 0; k < RAYS; ++k) {
    const direction = heading + ((3 * k + 1 - 89.5) * Math.PI) / 180;
    const cos = Math.cos(direction), sin = Math.sin(direction), far = reach(fx, fy, cos, sin, near);
    at[6 * k] = fx;
    at[6 * k + 1] = fy;
    at[6 * k + 2] = at[6 * k + 5] = HEIGHT;
    at[6 * k + 3] = fx + far * cos;
    at[6 * k + 4] = fy + far * sin;
    hits[k] = far < FARTHEST ? 1 : 0;
  }
}
