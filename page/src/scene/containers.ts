// The containers: on the ship, carried, on a vehicle, set down, or gone.
import * as THREE from "three";
import type { ContainerStep, Layout } from "../data/recording";
import { box, edges, paint } from "./shapes";
import type { Ground } from "./ground";

const COLOURS = ["#c4583c", "#4078a8", "#549460", "#c8a03c", "#826096", "#5a96a0", "#aa6e5a", "#6e7882"];

interface Carriers {
  ground: Ground;
  load: THREE.Object3D;
  vehicles: THREE.Object3D[];
}

export class Containers extends THREE.Group {
  readonly meshes: THREE.Mesh[] = [];
  private readonly steps: number[] = [];

  constructor(private readonly layout: Layout, private readonly stories: ContainerStep[][], private readonly carriers: Carriers) {
    super();
    const [length, width, height] = layout.size;
    layout.containers.forEach((_, i) => {
      const mesh = box(length, width, height, paint(COLOURS[i % COLOURS.length]), true);
      mesh.add(edges(mesh, "#000000"));
      this.meshes.push(mesh);
      this.steps.push(-2);
    });
  }

  update(now: number): void {
    this.meshes.forEach((_, i) => {
      const story = this.stories[i] ?? [];
      let step = -1;
      while (step + 1 < story.length && story[step + 1][0] <= now) ++step;
      if (this.steps[i] === step) return;
      this.steps[i] = step;
      this.put(i, step < 0 ? null : story[step]);
    });
  }

  private put(i: number, step: ContainerStep | null): void {
    const mesh = this.meshes[i], { ground, load, vehicles } = this.carriers, height = this.layout.size[2];
    mesh.removeFromParent();
    mesh.rotation.set(0, 0, 0);
    if (!step) {
      const [x, y, z, yaw] = this.layout.containers[i];
      mesh.position.copy(ground.onShip(x, y, z));
      mesh.rotation.z = yaw;
      ground.ship.add(mesh);
    } else if (step[1] === "carried") {
      mesh.position.set(0, 0, step[2][0] - height);
      mesh.rotation.z = step[2][1];
      load.add(mesh);
    } else if (step[1] === "agv") {
      const [agv, x, y, yaw] = step[2];
      mesh.position.set(x, y, this.layout.agv.deck);
      mesh.rotation.z = yaw;
      vehicles[agv]?.add(mesh);
    } else if (step[1] !== "gone") {
      mesh.position.set(step[2][0], step[2][1], step[2][2]);
      mesh.rotation.z = step[2][3];
      this.add(mesh);
    }
  }

  where(i: number): string {
    const story = this.stories[i] ?? [], step = this.steps[i];
    if (step < 0 || !story[step]) return "on the ship";
    const [, where, place] = story[step];
    return { ship: "on the ship", carried: "at the crane's rope", agv: `on AGV ${place?.[0]}`, set: "set down", gone: "delivered" }[where];
  }
}
