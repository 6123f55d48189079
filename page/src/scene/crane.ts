// The crane: a gantry with a trolley, or a slewing jib, on its portal; ropes and spreader.
import * as THREE from "three";
import type { Layout } from "../data/recording";
import { legsOf } from "./rays";
import type { Samples } from "./samples";
import { Beam, box, edges, paint } from "./shapes";

export class Crane extends THREE.Group {
  readonly load = new THREE.Group();
  readonly spreader: THREE.Mesh;
  private readonly beams: { beam: Beam; place: (s: Samples) => [number, number, number, number, number, number] }[] = [];
  private readonly legs: THREE.Mesh[] = [];
  private readonly ropes: THREE.BufferAttribute;
  private readonly moving: ((s: Samples) => void)[] = [];

  constructor(private readonly layout: Layout, rope: string) {
    super();
    const gantry = layout.crane.machine === "gantry";
    const steel = paint(gantry ? "#4a7fb5" : "#d8a02c"), dark = paint("#6c7378");
    const { portal } = layout.crane;
    for (const [x, y] of legsOf(layout, 0)) {
      const leg = box(portal.leg, portal.leg, portal.height, steel, true);
      leg.position.set(x, y, 0);
      this.legs.push(leg);
      this.add(leg);
    }
    if (gantry) this.gantry(steel, dark);
    else this.jib(steel, dark);

    const [length, width] = layout.size;
    this.spreader = box(length, Math.min(1.2, width), 0.5, paint("#e8c33c"), true);
    this.spreader.add(edges(this.spreader, "#000000"));
    this.load.add(this.spreader);
    for (const u of [-1, 1]) {
      const end = box(0.5, width, 0.4, paint("#e8c33c"), true);
      end.position.x = u * (length / 2 - 0.25);
      this.load.add(end);
    }
    this.add(this.load);

    const geometry = new THREE.BufferGeometry();
    this.ropes = new THREE.BufferAttribute(new Float32Array(4 * 6), 3);
    geometry.setAttribute("position", this.ropes);
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: rope }));
    lines.frustumCulled = false;
    this.add(lines);
  }

  private beam(thick: number, material: THREE.Material, place: (s: Samples) => [number, number, number, number, number, number]): void {
    const beam = new Beam(thick, material);
    this.add(beam);
    this.beams.push({ beam, place });
  }

  private gantry(steel: THREE.Material, dark: THREE.Material): void {
    const { portal, pivot, reach } = this.layout.crane;
    const [waterside, landside] = portal.rails, [back, out] = reach;
    for (const u of [portal.along, -portal.along]) {
      this.beam(0.9, steel, (s) => [s.at("s_m") + u, waterside, portal.height, s.at("s_m") + u, waterside, pivot + 2]);
      this.beam(0.9, steel, (s) => [s.at("s_m") + u, landside, portal.height, s.at("s_m") + u, landside, pivot + 2]);
      this.beam(0.8, steel, (s) => [s.at("s_m") + u, waterside, 15, s.at("s_m") + u, landside, 15]);
    }
    for (const y of [waterside, landside]) {
      this.beam(0.9, steel, (s) => [s.at("s_m") - portal.along, y, pivot + 2, s.at("s_m") + portal.along, y, pivot + 2]);
      for (const x of [-2, 2]) this.beam(0.6, steel, (s) => [s.at("s_m") + x, y, pivot + 2, s.at("s_m") + x, waterside - 2, pivot + 20]);
    }
    for (const x of [-2, 2]) {
      this.beam(0.8, steel, (s) => [s.at("s_m") + x, back - 1, pivot + 1.5, s.at("s_m") + x, out + 1, pivot + 1.5]);
      for (const y of [out - 2, out / 2, back + 2]) this.beam(0.25, dark, (s) => [s.at("s_m") + x, waterside - 2, pivot + 20, s.at("s_m") + x, y, pivot + 2]);
    }
    const trolley = box(5.2, 4, 1.4, paint("#d05a3c"));
    this.add(trolley);
    this.moving.push((s) => trolley.position.set(s.at("s_m"), s.at("tip_y_m"), s.at("tip_z_m") + 0.9));
  }

  private jib(steel: THREE.Material, dark: THREE.Material): void {
    const { portal, pivot, a0, counterweight } = this.layout.crane;
    const [waterside, landside] = portal.rails;
    const table = box(2 * portal.along + portal.leg, waterside - landside + portal.leg, 15 - portal.height, steel, true);
    table.add(edges(table, "#000000", 0.3));
    this.add(table);
    const house = box(counterweight + 4, 3.6, 4, paint("#c98a1e"), true);
    house.add(edges(house, "#000000", 0.3));
    this.add(house);
    this.moving.push((s) => {
      table.position.set(s.at("s_m"), (waterside + landside) / 2, portal.height);
      const psi = s.at("psi_rad");
      house.rotation.z = psi;
      house.position.set(s.at("s_m") + Math.cos(psi) * (1 - counterweight / 2), Math.sin(psi) * (1 - counterweight / 2), 15);
    });
    const local = (s: Samples, u: number, v: number, z: number): [number, number, number] => {
      const psi = s.at("psi_rad");
      return [s.at("s_m") + u * Math.cos(psi) - v * Math.sin(psi), u * Math.sin(psi) + v * Math.cos(psi), z];
    };
    const tip = (s: Samples, v: number): [number, number, number] => {
      const psi = s.at("psi_rad");
      return [s.at("tip_x_m") - v * Math.sin(psi), s.at("tip_y_m") + v * Math.cos(psi), s.at("tip_z_m")];
    };
    for (const v of [-1.2, 1.2]) {
      this.beam(0.5, steel, (s) => [...local(s, a0, v, pivot), ...tip(s, 0.35 * v)]);
      this.beam(0.5, steel, (s) => [...local(s, a0, v, pivot), ...local(s, 0, v, 19)]);
    }
    for (const share of [0.25, 0.5, 0.75]) {
      this.beam(0.25, steel, (s) => {
        const foot = (v: number): [number, number, number] => {
          const a = local(s, a0, v, pivot), b = tip(s, 0.35 * v);
          return [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share, a[2] + (b[2] - a[2]) * share];
        };
        return [...foot(-1.2), ...foot(1.2)];
      });
    }
    this.beam(0.6, steel, (s) => [...local(s, -1, 0, 19), ...local(s, -1, 0, 31)]);
    this.beam(0.15, dark, (s) => [...local(s, -1, 0, 31), ...tip(s, 0)]);
    this.beam(0.15, dark, (s) => [...local(s, -1, 0, 31), ...local(s, -counterweight, 0, 19)]);
  }

  private static readonly up = new THREE.Vector3();
  private static readonly z = new THREE.Vector3(0, 0, 1);
  private static readonly turn = new THREE.Quaternion();
  private static readonly corner = new THREE.Vector3();

  update(samples: Samples): void {
    const travel = samples.at("s_m");
    legsOf(this.layout, travel).forEach(([x, y], i) => this.legs[i].position.set(x, y, 0));
    for (const move of this.moving) move(samples);
    for (const { beam, place } of this.beams) beam.between(...place(samples));
    const { load } = this;
    load.position.set(samples.at("payload_x_m"), samples.at("payload_y_m"), samples.at("payload_z_m"));
    const x = samples.at("payload_up_x"), y = samples.at("payload_up_y");
    Crane.up.set(x, y, Math.sqrt(Math.max(0, 1 - x * x - y * y)));
    load.quaternion.setFromUnitVectors(Crane.z, Crane.up).multiply(Crane.turn.setFromAxisAngle(Crane.z, samples.angle("payload_yaw_rad")));
    load.updateMatrix();
    const [fx, fy] = this.layout.crane.falls;
    [[1, 1], [1, -1], [-1, -1], [-1, 1]].forEach(([u, v], i) => {
      const at = Crane.corner.set(u * fx, v * fy * 0.6, 0.5).applyMatrix4(load.matrix);
      const array = this.ropes.array as Float32Array;
      array.set([samples.at("tip_x_m") + 0.3 * (at.x - load.position.x), samples.at("tip_y_m") + 0.3 * (at.y - load.position.y), samples.at("tip_z_m"), at.x, at.y, at.z], 6 * i);
    });
    this.ropes.needsUpdate = true;
  }
}
