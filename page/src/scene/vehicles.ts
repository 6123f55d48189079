// The vehicles: body, wheels that steer, what their range sensor sees, and the vehicles of the ideal run.
import * as THREE from "three";
import type { Layout } from "../data/recording";
import { OKABE_ITO } from "../ui/colours";
import { pose, RAYS, raysOf, solidsAt } from "./rays";
import type { Samples } from "./samples";
import { box, edges, paint, Track } from "./shapes";

class Vehicle {
  readonly body = new THREE.Group();
  readonly ghost: THREE.LineSegments;
  readonly rays: THREE.LineSegments;
  readonly hull: THREE.Mesh;
  private readonly axles: [THREE.Object3D, string][] = [];
  private readonly at = new Float32Array(RAYS * 6);
  private readonly hits = new Uint8Array(RAYS);

  constructor(layout: Layout, private readonly number: number) {
    const { length, width, deck } = layout.agv;
    this.hull = box(length, width, deck - 0.6, paint("#5d8f78"), true);
    this.hull.position.z = 0.6;
    this.hull.add(edges(this.hull, "#000000"));
    this.body.add(this.hull);
    const nose = box(0.5, width * 0.8, 0.5, paint(OKABE_ITO.yellow), true);
    nose.position.set(length / 2 - 0.2, 0, 0.9);
    this.body.add(nose);
    for (const [u, of] of [[0.3, "front"], [-0.3, "rear"]] as const) {
      const axle = new THREE.Group();
      for (const v of [-1, 1]) {
        const wheel = box(1.3, 0.5, 1.1, paint("#2b2e31"), true);
        wheel.position.y = v * (width / 2 - 0.3);
        axle.add(wheel);
      }
      axle.position.x = u * length;
      this.axles.push([axle, `agv${number}_${of}_rad`]);
      this.body.add(axle);
    }
    this.ghost = edges(box(length, width, deck, paint("#ffffff"), true), OKABE_ITO.sky, 0.9);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.at, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(RAYS * 6), 3));
    this.rays = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.55 }));
    this.rays.frustumCulled = false;
  }

  update(samples: Samples): void {
    const [x, y, heading] = pose(samples, this.number);
    this.body.position.set(x, y, 0);
    this.body.rotation.z = heading;
    for (const [axle, name] of this.axles) axle.rotation.z = samples.at(name);
    this.ghost.position.set(x + samples.at(`agv${this.number}_ghost_x_m`), y + samples.at(`agv${this.number}_ghost_y_m`), 0);
    this.ghost.rotation.z = heading;
  }

  see(layout: Layout, samples: Samples, solids: ReturnType<typeof solidsAt>): void {
    raysOf(layout, samples, this.number, solids, this.at, this.hits);
    const colours = this.rays.geometry.getAttribute("color") as THREE.BufferAttribute;
    const hit = new THREE.Color(OKABE_ITO.vermillion), free = new THREE.Color(OKABE_ITO.sky);
    for (let k = 0; k < RAYS; ++k) {
      const colour = this.hits[k] ? hit : free;
      colours.setXYZ(2 * k, colour.r, colour.g, colour.b);
      colours.setXYZ(2 * k + 1, colour.r, colour.g, colour.b);
    }
    colours.needsUpdate = true;
    this.rays.geometry.getAttribute("position").needsUpdate = true;
  }
}

export class Fleet extends THREE.Group {
  readonly vehicles: Vehicle[] = [];
  private readonly tracks: Track[] = [];

  constructor(private readonly layout: Layout, samples: Samples) {
    super();
    for (let i = 0; i < layout.agv.count; ++i) {
      const vehicle = new Vehicle(layout, i);
      this.vehicles.push(vehicle);
      this.add(vehicle.body, vehicle.ghost, vehicle.rays);
      const x = samples.column(`agv${i}_planned_x_m`), y = samples.column(`agv${i}_planned_y_m`);
      if (!x || !y) continue;
      const track = new Track(x, y, 0.15, new THREE.LineBasicMaterial({ color: OKABE_ITO.purple }));
      this.tracks.push(track);
      this.add(track);
    }
  }

  update(samples: Samples, options: { rays: boolean; ghost: boolean; path: boolean }, ahead: [number, number]): void {
    const hasGhost = samples.column("agv0_ghost_x_m") !== undefined;
    for (const vehicle of this.vehicles) {
      vehicle.update(samples);
      vehicle.rays.visible = options.rays;
      vehicle.ghost.visible = options.ghost && hasGhost;
    }
    if (options.rays) {
      const solids = solidsAt(this.layout, samples);
      for (const vehicle of this.vehicles) vehicle.see(this.layout, samples, solids);
    }
    for (const track of this.tracks) {
      track.visible = options.path;
      track.stretch(...ahead);
    }
  }
}
