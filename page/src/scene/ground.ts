// What does not move: quay, water, lanes, rails, places; and the ship, which may move.
import * as THREE from "three";
import type { Layout } from "../data/recording";
import type { Theme } from "../ui/colours";
import type { Samples } from "./samples";
import { box, boxOf, edges, paint } from "./shapes";

const FAR = 700; // m of quay and water beyond the outermost object

/** Flat things are drawn over the ground and under all upright ones, in this order, whatever the resolution of the depth. */
function onGround(colour: string): THREE.MeshBasicMaterial {
  return new THREE.MeshBasicMaterial({ color: colour, side: THREE.DoubleSide, depthTest: false, depthWrite: false });
}

function ribbon(points: [number, number][], width: number, material: THREE.Material): THREE.Mesh {
  const at: number[] = [], index: number[] = [];
  points.forEach(([x, y], i) => {
    const a = points[Math.max(0, i - 1)], b = points[Math.min(points.length - 1, i + 1)];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const nx = (-(b[1] - a[1]) / length) * (width / 2), ny = ((b[0] - a[0]) / length) * (width / 2);
    at.push(x + nx, y + ny, 0, x - nx, y - ny, 0);
    if (i + 1 < points.length) index.push(2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 1, 2 * i + 3, 2 * i + 2);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(at, 3));
  geometry.setIndex(index);
  return new THREE.Mesh(geometry, material);
}

function curve([x, y, heading, length, curvature]: Layout["lanes"][number]): [number, number][] {
  const steps = Math.abs(curvature) > 1e-9 ? 24 : 1;
  return Array.from({ length: steps + 1 }, (_, i): [number, number] => {
    const d = (length * i) / steps, h = heading + curvature * d;
    return Math.abs(curvature) > 1e-9
      ? [x + (Math.sin(h) - Math.sin(heading)) / curvature, y - (Math.cos(h) - Math.cos(heading)) / curvature]
      : [x + d * Math.cos(heading), y + d * Math.sin(heading)];
  });
}

export class Ground extends THREE.Group {
  readonly ship = new THREE.Group();
  readonly quay: THREE.MeshBasicMaterial;
  readonly water: THREE.MeshBasicMaterial;
  private readonly middle: THREE.Vector3;
  private readonly movers: THREE.Mesh[] = [];
  readonly extent: [number, number]; // along the quay

  constructor(private readonly layout: Layout, theme: Theme) {
    super();
    const { ship, lanes, crane } = layout;
    this.extent = [Math.min(-40, ...lanes.map((s) => s[0] - 20)), Math.max(60, ...lanes.map((s) => s[0] + 20))];
    const [x0, x1] = [this.extent[0] - FAR, this.extent[1] + FAR]; // the fog ends them
    const edge = ship[2] - 1, land = Math.min(layout.warehouse[1], ...lanes.map((s) => s[1])) - FAR;
    this.quay = new THREE.MeshBasicMaterial({ color: theme.ground });
    this.water = new THREE.MeshBasicMaterial({ color: theme.water });
    const flat = (ya: number, yb: number, z: number, material: THREE.Material): void => {
      const mesh = new THREE.Mesh(new THREE.PlaneGeometry(x1 - x0, yb - ya), material);
      mesh.position.set((x0 + x1) / 2, (ya + yb) / 2, z);
      mesh.renderOrder = -2;
      this.add(mesh);
    };
    flat(land, edge, 0, this.quay);
    flat(edge, ship[3] + FAR, -2.5, this.water);
    const wall = box(x1 - x0, 0.6, 2.6, paint("#8d8d86"), true);
    wall.position.set((x0 + x1) / 2, edge, -2.61);
    this.add(wall);
    const markings = onGround("#f4f4ee"), asphalt = onGround("#8f9290");
    for (const lane of lanes) this.lay(ribbon(curve(lane), layout.agv.width + 1.6, asphalt));
    for (const lane of lanes) this.lay(ribbon(curve(lane), 0.25, markings));
    for (const y of crane.portal.rails) this.lay(ribbon([[x0, y], [x1, y]], 0.35, onGround("#5f6266")));
    const [wx, wy, radius] = layout.warehouse;
    const circle = new THREE.Mesh(new THREE.CircleGeometry(radius + 1, 32), onGround("#e3cf8f"));
    circle.position.set(wx, wy, 0);
    this.lay(circle);
    const grey = paint("#9aa2aa");
    for (const b of layout.boxes) {
      const mesh = boxOf(b, grey);
      mesh.add(edges(mesh, "#000000", 0.3));
      this.add(mesh);
    }
    for (const [r, height] of layout.movers) {
      const mesh = new THREE.Mesh(new THREE.CylinderGeometry(r, r, height, 12).rotateX(Math.PI / 2).translate(0, 0, height / 2), new THREE.MeshBasicMaterial({ color: "#b0487a" }));
      this.movers.push(mesh);
      this.add(mesh);
    }
    this.middle = new THREE.Vector3((ship[0] + ship[1]) / 2, (ship[2] + ship[3]) / 2, 0);
    const hull = boxOf(ship, paint("#7e6a5c"));
    hull.position.sub(this.middle);
    hull.add(edges(hull, "#000000", 0.4));
    this.ship.add(hull);
    this.add(this.ship);
    this.ship.position.copy(this.middle);
  }

  private flat = -1;
  private lay(mesh: THREE.Mesh): void {
    mesh.renderOrder = this.flat += 1e-3;
    this.add(mesh);
  }

  /** A place on the ship in calm water, as the ship's own. */
  onShip(x: number, y: number, z: number): THREE.Vector3 {
    return new THREE.Vector3(x, y, z).sub(this.middle);
  }

  update(samples: Samples): void {
    this.movers.forEach((mesh, i) => mesh.position.set(samples.at(`mover${i}_x_m`), samples.at(`mover${i}_y_m`), 0));
    if (!this.layout.ship_moves) return;
    this.ship.position.set(samples.at("ship_x_m"), samples.at("ship_y_m"), samples.at("ship_z_m")).add(this.middle);
    const x = samples.at("ship_up_x"), y = samples.at("ship_up_y");
    this.ship.rotation.set(Math.asin(-y), Math.atan2(x, Math.sqrt(Math.max(1e-9, 1 - x * x - y * y))), 0, "YXZ");
  }

  dress(theme: Theme): void {
    this.quay.color.set(theme.ground);
    this.water.color.set(theme.water);
  }
}
