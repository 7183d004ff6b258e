// Charts of a light map: triangles that share vertices, by position and light-map UV.
import { BufferAttribute, BufferGeometry, Matrix3, Matrix4, Ray, Vector3 } from "three";

/**
 * @typedef {object} Charts
 * @property {number} count
 * @property {Float64Array} texels area of each chart [texels]
 * @property {Float64Array} middle u and v of a place inside each chart: the middle of its largest triangle
 * @property {BufferGeometry} seams borders of all charts, as line segments in world space
 */

/** Vertices of meshes by number; those with the same position and light-map UV have one number.
 * @typedef {{ numbers: Int32Array[], places: Vector3[] }} Welded numbers of the vertices of each mesh, and the place of each number in world space */

/** @param {import("three").Mesh[]} meshes @returns {Welded} */
function weld(meshes) {
  /** @type {Map<string, number>} */
  const known = new Map();
  /** @type {Vector3[]} */
  const places = [], place = new Vector3();
  const numbers = meshes.map((mesh) => {
    const position = mesh.geometry.getAttribute("position"), uv = mesh.geometry.getAttribute("uv1");
    return Int32Array.from({ length: position.count }, (_, i) => {
      place.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
      const key = [place.x, place.y, place.z].map((x) => x.toPrecision(5)).join() + "," + Math.round(uv.getX(i) * 65536) + "," + Math.round(uv.getY(i) * 65536);
      let number = known.get(key);
      if (number === undefined) {
        known.set(key, (number = places.length));
        places.push(place.clone());
      }
      return number;
    });
  });
  return { numbers, places };
}

/** Joins vertices that share a triangle (union-find). Returns the chart of a vertex, numbered in the order in which it is asked for, and the
 * borders: ends of the edges of one triangle, as pairs of places. @param {import("three").Mesh[]} meshes @param {Welded} welded */
function joinTriangles(meshes, { numbers, places }) {
  const parent = places.map((_, i) => i), count = places.length;
  const root = (/** @type {number} */ i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  /** Number of triangles on an edge of welded vertices. @type {Map<number, number>} */
  const edges = new Map();
  meshes.forEach((mesh, m) => {
    const index = /** @type {BufferAttribute} */ (mesh.geometry.index);
    for (let i = 0; i + 2 < index.count; i += 3) {
      const corner = [0, 1, 2].map((k) => numbers[m][index.getX(i + k)]);
      for (let k = 0; k < 3; ++k) {
        const a = corner[k], b = corner[(k + 1) % 3], key = Math.min(a, b) * count + Math.max(a, b);
        edges.set(key, (edges.get(key) ?? 0) + 1);
        parent[root(a)] = root(b);
      }
    }
  });
  /** @type {Map<number, number>} */
  const charts = new Map();
  const chartOf = (/** @type {number} */ vertex) => {
    const top = root(vertex);
    let chart = charts.get(top);
    if (chart === undefined) charts.set(top, (chart = charts.size));
    return chart;
  };
  const borders = [...edges].filter(([, triangles]) => triangles === 1).flatMap(([key]) => [places[Math.floor(key / count)], places[key % count]]);
  return { charts, chartOf, borders };
}

/**
 * Finds the charts of meshes that lie on one light map, and gives their geometries the attribute `chartId`.
 * @param {import("three").Mesh[]} meshes with indices and uv1 @param {number} width of the light map [texels] @param {number} height [texels]
 * @returns {Charts}
 */
export function findCharts(meshes, width, height) {
  const welded = weld(meshes), { charts, chartOf, borders } = joinTriangles(meshes, welded);
  /** By chart. @type {number[]} */
  const areas = [], /** @type {number[]} */ largest = [], /** @type {number[]} */ middle = [];
  meshes.forEach((mesh, m) => {
    const ids = Float32Array.from(welded.numbers[m], chartOf), uv = mesh.geometry.getAttribute("uv1");
    mesh.geometry.setAttribute("chartId", new BufferAttribute(ids, 1));
    const index = /** @type {BufferAttribute} */ (mesh.geometry.index);
    for (let i = 0; i + 2 < index.count; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => index.getX(i + k));
      const area = Math.abs((uv.getX(b) - uv.getX(a)) * (uv.getY(c) - uv.getY(a)) - (uv.getX(c) - uv.getX(a)) * (uv.getY(b) - uv.getY(a))) / 2;
      areas[ids[a]] = (areas[ids[a]] ?? 0) + area * width * height;
      if (area <= (largest[ids[a]] ?? -1)) continue;
      largest[ids[a]] = area;
      middle[2 * ids[a]] = (uv.getX(a) + uv.getX(b) + uv.getX(c)) / 3;
      middle[2 * ids[a] + 1] = (uv.getY(a) + uv.getY(b) + uv.getY(c)) / 3;
    }
  });
  const seams = new BufferGeometry().setFromPoints(borders);
  return { count: charts.size, texels: Float64Array.from(areas, (area) => area ?? 0), middle: Float64Array.from(middle, (place) => place ?? 0), seams };
}

/**
 * @typedef {object} Found
 * @property {import("three").Mesh} mesh
 * @property {number[]} corner vertices of the triangle
 * @property {[number, number]} uv in the light map
 * @property {[number, number]} bakeUv in its bake
 * @property {Vector3} position in world space
 * @property {Vector3} normal unit, in world space
 * @property {number} chart
 * @property {number} cluster
 */

/** Interpolates a triangle's corners. @param {import("three").Mesh} mesh @param {number[]} corner @param {number[]} weight @returns {Found} */
export function surfaceAt(mesh, corner, weight) {
  const { geometry } = mesh, position = new Vector3(), normal = new Vector3(), part = new Vector3();
  corner.forEach((vertex, k) => {
    position.addScaledVector(part.fromBufferAttribute(geometry.getAttribute("position"), vertex), weight[k]);
    normal.addScaledVector(part.fromBufferAttribute(geometry.getAttribute("normal"), vertex), weight[k]);
  });
  const uvOf = (/** @type {string} */ name) => {
    const uv = geometry.getAttribute(name), sum = (/** @type {number} */ k) => corner.reduce((all, vertex, i) => all + weight[i] * uv.getComponent(vertex, k), 0);
    return /** @type {[number, number]} */ ([sum(0), sum(1)]);
  };
  return {
    mesh,
    corner,
    uv: uvOf("uv1"),
    bakeUv: uvOf("bakeUv"),
    position: position.applyMatrix4(mesh.matrixWorld),
    normal: normal.applyNormalMatrix(new Matrix3().getNormalMatrix(mesh.matrixWorld)).normalize(),
    chart: geometry.getAttribute("chartId").getX(corner[0]),
    cluster: geometry.getAttribute("_lightcook_basis")?.getX(corner[0]) ?? 0,
  };
}

/**
 * Returns the surface at, or nearest in the light map to, a place.
 * @param {import("three").Mesh[]} meshes @param {number} u @param {number} v @param {string} [uvs] attribute that the place is of
 * @returns {Found | null} null without triangles
 */
export function findSurface(meshes, u, v, uvs = "uv1") {
  let best = null, least = Infinity;
  for (const mesh of meshes) {
    const uv = mesh.geometry.getAttribute(uvs), index = /** @type {BufferAttribute} */ (mesh.geometry.index);
    for (let i = 0; i + 2 < index.count; i += 3) {
      const corner = [index.getX(i), index.getX(i + 1), index.getX(i + 2)];
      const [ax, bx, cx] = corner.map((k) => uv.getX(k) - u), [ay, by, cy] = corner.map((k) => uv.getY(k) - v);
      const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
      if (area === 0) continue;
      const weight = [(bx * cy - cx * by) / area, (cx * ay - ax * cy) / area, (ax * by - bx * ay) / area].map((w) => Math.max(w, 0));
      const sum = weight[0] + weight[1] + weight[2], x = (weight[0] * ax + weight[1] * bx + weight[2] * cx) / sum,
        y = (weight[0] * ay + weight[1] * by + weight[2] * cy) / sum, distance = x * x + y * y;
      if (distance < least) {
        least = distance;
        best = { mesh, corner, weight: weight.map((w) => w / sum) };
      }
      if (least < 1e-16 && best) return surfaceAt(best.mesh, best.corner, best.weight);
    }
  }
  return best && surfaceAt(best.mesh, best.corner, best.weight);
}

/** Returns the side of a texel on the triangle of a place [scene units]. @param {Found} found @param {number} width of the light map [texels] @param {number} height [texels] */
export function texelSideAt({ mesh, corner }, width, height) {
  const uv = mesh.geometry.getAttribute("uv1"), position = mesh.geometry.getAttribute("position");
  const [a, b, c] = corner.map((vertex) => new Vector3().fromBufferAttribute(position, vertex).applyMatrix4(mesh.matrixWorld));
  const [[ax, ay], [bx, by], [cx, cy]] = corner.map((vertex) => [uv.getX(vertex) * width, uv.getY(vertex) * height]);
  return Math.sqrt(b.sub(a).cross(c.sub(a)).length() / Math.abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)));
}

/** Returns how far a ray goes before it meets a side of a triangle, at most `most` [scene units].
 * @param {import("three").Mesh[]} meshes @param {Vector3} origin @param {Vector3} direction unit @param {number} most */
export function freeDistance(meshes, origin, direction, most) {
  const corners = [new Vector3(), new Vector3(), new Vector3()], hit = new Vector3(), ray = new Ray(), toMesh = new Matrix4();
  let free = most;
  for (const mesh of meshes) {
    const position = mesh.geometry.getAttribute("position"), index = /** @type {BufferAttribute} */ (mesh.geometry.index);
    ray.set(origin, direction).applyMatrix4(toMesh.copy(mesh.matrixWorld).invert());
    for (let i = 0; i + 2 < index.count; i += 3) {
      corners.forEach((corner, k) => corner.fromBufferAttribute(position, index.getX(i + k)));
      if (ray.intersectTriangle(corners[0], corners[1], corners[2], false, hit)) free = Math.min(free, hit.applyMatrix4(mesh.matrixWorld).distanceTo(origin));
    }
  }
  return free;
}
