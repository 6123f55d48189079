// The dock in 3-D.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { before, type Recording } from "../data/recording";
import * as words from "../data/words";
import { OKABE_ITO, type Theme } from "../ui/colours";
import type { State } from "../ui/state";
import { Containers } from "./containers";
import { Crane } from "./crane";
import { Ground } from "./ground";
import { Pace } from "./pace";
import type { Samples } from "./samples";
import { box, edges, paint, Track } from "./shapes";
import { Fleet } from "./vehicles";

const AHEAD = 20, BEHIND = 4; // s of path that are drawn
const LAST = 1; // drawn over what has been drawn

function drawsInSoftware(gl: WebGL2RenderingContext): boolean {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return /swiftshader|llvmpipe|software/i.test(info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "");
}

/** With smooth edges, where they cost nothing. Throws where there is no WebGL 2. */
function rendererFor(): { renderer: THREE.WebGLRenderer; software: boolean } {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { antialias: false, alpha: false, powerPreference: "high-performance" });
  if (!context) throw new Error("there is no WebGL 2");
  const software = drawsInSoftware(context);
  if (software) return { renderer: new THREE.WebGLRenderer({ canvas, context }), software };
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return { renderer: new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" }), software };
}

export class DockView {
  readonly canvas: HTMLCanvasElement;
  readonly software: boolean;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(42, 1, 1, 900);
  private readonly controls: OrbitControls;
  private readonly ground: Ground;
  private readonly crane: Crane;
  private readonly fleet: Fleet;
  private readonly containers: Containers;
  private readonly ghost = new THREE.Group();
  private readonly tracks: { planned?: Track; ideal?: Track } = {};
  private readonly pace = new Pace();
  private readonly home: { eye: THREE.Vector3; target: THREE.Vector3 };
  private dirty = true;
  private moving = false;

  /** Throws where there is no WebGL. */
  constructor(private readonly host: HTMLElement, private readonly recording: Recording, private readonly samples: Samples, private readonly state: State, theme: Theme) {
    ({ renderer: this.renderer, software: this.software } = rendererFor());
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The dock in 3-D: drag turns it, arrow keys turn it too");
    host.append(this.canvas);
    const { layout } = recording.header;
    samples.seek(state.now);
    this.ground = new Ground(layout, theme);
    this.crane = new Crane(layout, theme.dark ? "#cfd4d8" : "#2a2d30");
    this.fleet = new Fleet(layout, samples);
    this.containers = new Containers(layout, recording.header.containers, { ground: this.ground, load: this.crane.load, vehicles: this.fleet.vehicles.map((v) => v.body) });
    this.scene.add(this.ground, this.crane, this.fleet, this.containers, this.ghost);
    this.addGhost();
    this.addTracks();
    this.home = this.firstView();
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enableDamping: false, minDistance: 12, maxDistance: 330, minPolarAngle: 0.02, maxPolarAngle: 1.52, screenSpacePanning: false });
    this.controls.addEventListener("change", () => this.keepTarget());
    this.controls.addEventListener("start", () => (this.moving = true));
    this.controls.addEventListener("end", () => (this.moving = false));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.goHome();
    this.dress(theme);
  }

  private addGhost(): void {
    const [length, width, height] = this.recording.header.layout.size;
    const shape = edges(box(length, width, height, paint("#ffffff"), true), OKABE_ITO.sky, 0.95);
    shape.position.z = -height;
    const spreader = edges(box(length, 1.2, 0.5, paint("#ffffff"), true), OKABE_ITO.sky, 0.95);
    this.ghost.add(shape, spreader);
  }

  /** The load's paths, seen through the objects before them. */
  private addTracks(): void {
    const column = (name: string): Float64Array | undefined => this.samples.column(name);
    const planned = ["x", "y", "z"].map((axis) => column(`planned_${axis}_m`));
    if (planned.every((one) => one !== undefined)) {
      const [x, y, z] = planned as Float64Array[];
      this.scene.add((this.tracks.planned = new Track(x, y, z, new THREE.LineBasicMaterial({ color: OKABE_ITO.purple, depthTest: false }))));
    }
    if (this.tracks.planned) this.tracks.planned.renderOrder = LAST;
    const ghost = ["x", "y", "z"].map((axis) => column(`ghost_${axis}_m`));
    if (ghost.every((one) => one !== undefined)) {
      const [x, y, z] = (ghost as Float64Array[]).map((away, i) => away.map((by, row) => by + column(`payload_${"xyz"[i]}_m`)![row]));
      this.tracks.ideal = new Track(x, y, z, new THREE.LineDashedMaterial({ color: OKABE_ITO.sky, dashSize: 0.7, gapSize: 0.7, depthTest: false }));
      this.tracks.ideal.renderOrder = LAST;
      this.tracks.ideal.computeLineDistances();
      this.scene.add(this.tracks.ideal);
    }
  }

  /** The picture holds all vehicles at their first places. */
  private firstView(): { eye: THREE.Vector3; target: THREE.Vector3 } {
    const { layout } = this.recording.header;
    const back = Math.min(-30, ...Array.from({ length: layout.agv.count }, (_, i) => this.samples.column(`agv${i}_x_m`)![0] - 8));
    const far = 98 - 0.5 * (back + 30), turn = -0.5, lift = 0.33;
    const target = new THREE.Vector3(4 + 0.35 * (back + 30), 6, 17);
    const eye = new THREE.Vector3(Math.cos(turn) * Math.cos(lift), Math.sin(turn) * Math.cos(lift), Math.sin(lift)).multiplyScalar(far).add(target);
    return { eye, target };
  }

  goHome(): void {
    this.camera.position.copy(this.home.eye);
    this.controls.target.copy(this.home.target);
    this.controls.update();
    this.dirty = true;
  }

  /** What is looked at stays on the dock. */
  private keepTarget(): void {
    const { target } = this.controls, [x0, x1] = this.ground.extent, from = target.clone();
    target.set(THREE.MathUtils.clamp(target.x, x0, x1), THREE.MathUtils.clamp(target.y, -60, 60), THREE.MathUtils.clamp(target.z, 0, 45));
    this.camera.position.add(target.clone().sub(from));
    this.camera.position.z = Math.max(1.5, this.camera.position.z);
    this.dirty = true;
  }

  /** Turns by angles and comes nearer by a factor. */
  turn(around: number, up: number, nearer = 1): void {
    const at = new THREE.Spherical().setFromVector3(this.fromTarget());
    at.theta += around;
    at.phi = THREE.MathUtils.clamp(at.phi - up, 0.02, 1.52);
    at.radius = THREE.MathUtils.clamp(at.radius * nearer, 12, 330);
    const away = new THREE.Vector3().setFromSpherical(at);
    this.camera.position.set(away.x, -away.z, away.y).add(this.controls.target);
    this.controls.update();
    this.dirty = true;
  }

  private fromTarget(): THREE.Vector3 {
    const away = this.camera.position.clone().sub(this.controls.target);
    return new THREE.Vector3(away.x, away.z, -away.y); // three's spherical coordinates have y upwards
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, () => void> = {
      ArrowLeft: () => this.turn(-0.1, 0), ArrowRight: () => this.turn(0.1, 0), ArrowUp: () => this.turn(0, 0.08), ArrowDown: () => this.turn(0, -0.08),
      "+": () => this.turn(0, 0, 0.87), "=": () => this.turn(0, 0, 0.87), "-": () => this.turn(0, 0, 1.15), Home: () => this.goHome(),
    };
    const turn = turns[event.key];
    if (!turn || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    turn();
  }

  dress(theme: Theme): void {
    this.scene.background = new THREE.Color(theme.sky);
    this.scene.fog = new THREE.Fog(theme.sky, 180, 620);
    this.ground.dress(theme);
    this.dirty = true;
  }

  invalidate(): void {
    this.dirty = true;
  }

  resize(): void {
    const width = Math.max(1, this.host.clientWidth), height = Math.max(1, this.host.clientHeight);
    const ratio = Math.min(2, this.software ? 1 : devicePixelRatio) * this.pace.scale;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.fov = width < height ? 62 : 42;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  get resolution(): number {
    return this.renderer.getPixelRatio();
  }

  private update(): void {
    const { samples, state } = this, { options } = state;
    samples.seek(state.now);
    const times = this.recording.time;
    const ahead: [number, number] = [samples.index, before(times, state.now + AHEAD)];
    const behind: [number, number] = [Math.max(0, before(times, state.now - BEHIND)), ahead[1]];
    this.ground.update(samples);
    this.crane.update(samples);
    this.fleet.update(samples, options, ahead);
    this.containers.update(state.now);
    const { planned, ideal } = this.tracks;
    if (planned) planned.visible = options.path;
    planned?.stretch(...behind);
    if (ideal) ideal.visible = options.ghost;
    ideal?.stretch(...ahead);
    this.ghost.visible = options.ghost && ideal !== undefined;
    this.ghost.position.set(
      samples.at("payload_x_m") + samples.at("ghost_x_m"), samples.at("payload_y_m") + samples.at("ghost_y_m"), samples.at("payload_z_m") + samples.at("ghost_z_m"));
    this.ghost.rotation.z = samples.angle("payload_yaw_rad") + samples.at("ghost_yaw_rad");
  }

  /** Draws, where anything has changed. Returns whether it did. */
  draw(now: number): boolean {
    if (!this.dirty) {
      this.pace.rest();
      return false;
    }
    this.dirty = false;
    if ((this.state.playing || this.moving) && this.pace.frame(now)) this.resize();
    this.update();
    this.renderer.render(this.scene, this.camera);
    this.dirty = false;
    return true;
  }

  get eye(): number[] {
    return this.camera.position.toArray();
  }

  /** What is under the pointer, in words. */
  explain(x: number, y: number): string[] | null {
    const rect = this.canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(((x - rect.left) / rect.width) * 2 - 1, 1 - ((y - rect.top) / rect.height) * 2), this.camera);
    const hit = ray.intersectObjects(this.scene.children, true).find((one) => (one.object as THREE.Mesh).isMesh);
    if (!hit) return null;
    for (let object: THREE.Object3D | null = hit.object; object; object = object.parent) {
      const found = this.wordsFor(object);
      if (found) return found;
    }
    return null;
  }

  private wordsFor(object: THREE.Object3D): string[] | null {
    const { samples } = this, degrees = (name: string): string => `${((samples.at(name) * 180) / Math.PI).toFixed(2)}°`;
    const container = this.containers.meshes.indexOf(object as THREE.Mesh);
    if (container >= 0) return [`container ${container}`, this.containers.where(container)];
    const agv = this.fleet.vehicles.findIndex((vehicle) => vehicle.body === object);
    if (agv >= 0) {
      const lines = [`AGV ${agv}`, `${samples.at(`agv${agv}_speed_m_per_s`).toFixed(2)} m/s, heading ${degrees(`agv${agv}_heading_rad`)}`];
      const gx = samples.at(`agv${agv}_ghost_x_m`), gy = samples.at(`agv${agv}_ghost_y_m`);
      if (samples.column(`agv${agv}_ghost_x_m`)) lines.push(`${words.length(Math.hypot(gx, gy))} from where the ideal run's is`);
      return lines;
    }
    if (object === this.crane.load) {
      const lines = ["load", `rope ${samples.at("l_m").toFixed(2)} m, ${(samples.at("tension_N") / 1e3).toFixed(0)} kN`,
        `sway ${degrees("sway_alpha_rad")} along the jib, ${degrees("sway_beta_rad")} across`];
      if (samples.column("load_error_m")) lines.push(`${words.length(samples.at("load_error_m"))} from the ideal run's load`);
      return lines;
    }
    if (object === this.crane) return ["crane", `travel ${samples.at("s_m").toFixed(2)} m`, `load at height ${samples.at("payload_z_m").toFixed(2)} m`];
    if (object === this.ground.ship) return ["ship", this.recording.header.layout.ship_moves ? "it moves with the waves" : "it lies still in this run"];
    return null;
  }

  /** The picture as it is, for an export. */
  picture(): HTMLCanvasElement {
    this.update();
    this.renderer.render(this.scene, this.camera);
    return this.canvas;
  }
}
