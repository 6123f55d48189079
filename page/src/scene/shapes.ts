// Boxes, cylinders and lines whose faces carry their own shade: they need no lights, which software WebGL would pay for.
import * as THREE from "three";

const SHADES: [normal: [number, number, number], shade: number][] = [
  [[0, 0, 1], 1], [[0, 0, -1], 0.45], [[1, 0, 0], 0.78], [[-1, 0, 0], 0.7], [[0, 1, 0], 0.62], [[0, -1, 0], 0.86],
];

function shadeOf(x: number, y: number, z: number): number {
  let sum = 0, weight = 0;
  for (const [normal, shade] of SHADES) {
    const along = Math.max(0, normal[0] * x + normal[1] * y + normal[2] * z) ** 2;
    sum += along * shade;
    weight += along;
  }
  return weight > 0 ? sum / weight : 0.8;
}

/** Gives each vertex the shade of its face, as a grey. */
export function shaded(geometry: THREE.BufferGeometry): THREE.BufferGeometry {
  const normals = geometry.getAttribute("normal");
  const colours = new Float32Array(normals.count * 3);
  for (let i = 0; i < normals.count; ++i) colours.fill(shadeOf(normals.getX(i), normals.getY(i), normals.getZ(i)), 3 * i, 3 * i + 3);
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return geometry;
}

export function paint(colour: string): THREE.MeshBasicMaterial {
  return new THREE.MeshBasicMaterial({ color: colour, vertexColors: true });
}

/** A box; its middle is at the origin, or its underside where `standing`. */
export function box(x: number, y: number, z: number, material: THREE.Material, standing = false): THREE.Mesh {
  const geometry = shaded(new THREE.BoxGeometry(x, y, z));
  if (standing) geometry.translate(0, 0, z / 2);
  return new THREE.Mesh(geometry, material);
}

/** The box of a layout: x from, to; y from, to; z from, to. */
export function boxOf(of: number[], material: THREE.Material): THREE.Mesh {
  const mesh = box(of[1] - of[0], of[3] - of[2], of[5] - of[4], material);
  mesh.position.set((of[0] + of[1]) / 2, (of[2] + of[3]) / 2, (of[4] + of[5]) / 2);
  return mesh;
}

/** A beam with a square section between two points that may move. */
export class Beam extends THREE.Mesh {
  constructor(private readonly thick: number, material: THREE.Material) {
    super(shaded(new THREE.BoxGeometry(1, 1, 1)), material);
    this.matrixAutoUpdate = false;
  }

  private static readonly x = new THREE.Vector3();
  private static readonly y = new THREE.Vector3();
  private static readonly z = new THREE.Vector3();
  between(ax: number, ay: number, az: number, bx: number, by: number, bz: number): this {
    const { x, y, z } = Beam;
    z.set(bx - ax, by - ay, bz - az);
    const length = Math.max(1e-6, z.length());
    x.set(0, 0, 1).cross(z);
    if (x.lengthSq() < 1e-9) x.set(1, 0, 0);
    x.normalize();
    y.crossVectors(z, x).normalize();
    x.multiplyScalar(this.thick);
    y.multiplyScalar(this.thick);
    z.multiplyScalar(length / z.length());
    this.matrix.makeBasis(x, y, z).setPosition((ax + bx) / 2, (ay + by) / 2, (az + bz) / 2);
    this.matrixWorldNeedsUpdate = true;
    return this;
  }
}

export function edges(mesh: THREE.Mesh, colour: string, opacity = 0.45): THREE.LineSegments {
  return new THREE.LineSegments(
    new THREE.EdgesGeometry(mesh.geometry), new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }),
  );
}

/** A polyline of many points, of which a stretch is drawn; jumps of more than `jump` m are left out. */
export class Track extends THREE.LineSegments {
  constructor(x: Float64Array, y: Float64Array, z: Float64Array | number, material: THREE.LineBasicMaterial | THREE.LineDashedMaterial, jump = 1.5) {
    const count = x.length;
    const at = new Float32Array(Math.max(0, count - 1) * 6);
    const height = (i: number): number => (typeof z === "number" ? z : z[i]);
    for (let i = 0; i + 1 < count; ++i) {
      const far = Math.hypot(x[i + 1] - x[i], y[i + 1] - y[i], height(i + 1) - height(i)) > jump;
      const to = far ? i : i + 1;
      at.set([x[i], y[i], height(i), x[to], y[to], height(to)], i * 6);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(at, 3));
    super(geometry, material);
    this.frustumCulled = false;
  }

  stretch(from: number, to: number): void {
    this.geometry.setDrawRange(2 * Math.max(0, from), 2 * Math.max(0, to - from));
  }
}
