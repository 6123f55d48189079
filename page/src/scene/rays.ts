// The vehicles' range rays against what stands on the dock: the geometry of the sensor, without its noise.
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
}

export function pose(samples: Samples, agv: number): [number, number, number] {
  return [samples.at(`agv${agv}_x_m`), samples.at(`agv${agv}_y_m`), samples.angle(`agv${agv}_heading_rad`)];
}

export function legsOf(layout: Layout, travel: number): [number, number][] {
  const { portal } = layout.crane;
  return portal.leg > 0 ? [1, -1].flatMap((u) => portal.rails.map((y): [number, number] => [travel + u * portal.along, y])) : [];
}

export function solidsAt(layout: Layout, samples: Samples): Solid[] {
  const flat = (b: number[]): Solid => ({ x: (b[0] + b[1]) / 2, y: (b[2] + b[3]) / 2, yaw: 0, halfX: (b[1] - b[0]) / 2, halfY: (b[3] - b[2]) / 2 });
  const all = [flat(layout.ship), ...layout.boxes.filter((b) => b[4] < HEIGHT).map(flat)];
  layout.movers.forEach(([radius, height], i) => {
    if (height > HEIGHT) all.push({ x: samples.at(`mover${i}_x_m`), y: samples.at(`mover${i}_y_m`), yaw: 0, halfX: radius, halfY: null });
  });
  const half = layout.crane.portal.leg / 2;
  for (const [x, y] of legsOf(layout, samples.at("s_m"))) all.push({ x, y, yaw: 0, halfX: half, halfY: half });
  for (let i = 0; i < layout.agv.count; ++i) {
    const [x, y, yaw] = pose(samples, i);
    all.push({ x, y, yaw, halfX: layout.agv.length / 2, halfY: layout.agv.width / 2 });
  }
  return all;
}

/** How far a ray goes. `without`: the place of the vehicle's own body in `solids`. */
export function reach(x: number, y: number, direction: number, solids: Solid[], without: number): number {
  let best = FARTHEST;
  for (let i = 0; i < solids.length; ++i) {
    if (i === without) continue;
    const solid = solids[i];
    const c = Math.cos(solid.yaw), s = Math.sin(solid.yaw);
    const px = c * (x - solid.x) + s * (y - solid.y), py = -s * (x - solid.x) + c * (y - solid.y);
    const dx = Math.cos(direction - solid.yaw), dy = Math.sin(direction - solid.yaw);
    if (solid.halfY === null) {
      const b = px * dx + py * dy, root = b * b - px * px - py * py + solid.halfX * solid.halfX;
      if (root >= 0 && -b + Math.sqrt(root) >= 0) best = Math.min(best, Math.max(0, -b - Math.sqrt(root)));
      continue;
    }
    let near = 0, end = best;
    for (const [p, d, h] of [[px, dx, solid.halfX], [py, dy, solid.halfY]]) {
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
  for (let k = 0; k < RAYS; ++k) {
    const direction = heading + ((3 * k + 1 - 89.5) * Math.PI) / 180;
    const far = reach(fx, fy, direction, solids, own);
    at.set([fx, fy, HEIGHT, fx + far * Math.cos(direction), fy + far * Math.sin(direction), HEIGHT], 6 * k);
    hits[k] = far < FARTHEST ? 1 : 0;
  }
}
