// The scene on the canvas: loads it, draws it, and computes the values of single places with the same shader code.
import {
  Box3, BufferAttribute, BufferGeometry, DoubleSide, FloatType, FrontSide, GLSL3, InstancedBufferAttribute, InstancedBufferGeometry,
  LineBasicMaterial, LineSegments, Mesh, OrthographicCamera, PlaneGeometry, Raycaster, Scene, ShaderMaterial, Vector2, Vector3,
  WebGLRenderTarget, WebGLRenderer,
} from "three";
import {
  CookedScene, LAYOUTS, clustersOfBlocks, derivedLight, dominantLight, environmentMap, fetchBytes, makeTexture, readKtx2, specularTables,
} from "../loaders/index.js";
import { FRAGMENT_MAIN, POINTS_HEAD, POINTS_MAIN, POINTS_VERTEX, ROWS, VERTEX, shadingGlsl, sharedUniforms } from "./shading.js";
import { findCharts, findSurface, surfaceAt } from "./charts.js";

/**
 * @typedef {object} ViewedLightMap an entry of `light_maps` in viewer/scene.json
 * @property {string} name
 * @property {string | null} reference
 * @property {string} [reference_missing]
 * @property {number} reference_scale
 * @property {number} reference_layers coefficients in `reference`; the others are 0
 * @property {string | null} mesh
 * @property {{ nits: number, black: number } | null} display
 * @property {{ normal_map_tilt: number, m: number[], f0: number[] } | null} shading
 */
/** @typedef {{ schema: number, scene: string, light_maps: ViewedLightMap[], candidates: ViewedCandidate[] }} ViewedScene viewer/scene.json */
/**
 * @typedef {object} ShownMap a light map in the scene
 * @property {ViewedLightMap} data
 * @property {import("../loaders/core/cooked.js").CookedAsset} asset
 * @property {import("../loaders/core/light_map.js").LightMapDecode} decode
 * @property {boolean} hasReference
 * @property {boolean} hasMesh
 * @property {Mesh[]} meshes with the attributes uv1, of the light map, and bakeUv, of its bake
 * @property {{ width: number, height: number }} bake size [texels]
 * @property {import("./charts.js").Charts} charts
 * @property {ShaderMaterial} points
 * @property {Uint8Array | null} clusters of blocks of 4 x 4 texels
 */
/**
 * @typedef {object} ViewedCandidate an entry of `candidates` in viewer/scene.json: the scene under another layout
 * @property {string} layout
 * @property {string} folder
 * @property {number} bytes_gpu of its light maps
 * @property {number | null} visible 99th percentile of visible errors
 */
/**
 * @typedef {object} LayoutSet the light maps of the scene as one cook has them
 * @property {CookedScene} cooked
 * @property {Scene} scene
 * @property {Scene} lines borders of charts
 * @property {ShownMap[]} maps in the order of viewer/scene.json
 */
/** @typedef {{ uv: [number, number], bakeUv: [number, number], cluster: number, normal: number[], view: number[] }} Point normal and view: in the axes of the light map */
/**
 * @typedef {object} Values
 * @property {number[][]} reference nine coefficients, RGB
 * @property {number[][]} cooked nine coefficients, RGB
 * @property {number} coverage of the float bake
 * @property {number[]} referenceLight exit radiance as shaded
 * @property {number[]} cookedLight
 * @property {number} error Delta E ITP of the two
 * @property {number[]} referenceShown as on the screen, before the rounding to 8 bits
 * @property {number[]} cookedShown
 */

const NO_DISPLAY = { nits: 203, black: 0.5 };

/**
 * Returns the roughness m, from 0 to 1, at a coordinate of the tables: sqrt((a + b m) (c + d m)) grows with m.
 * @param {[number, number, number, number]} factors a, b, c, d @param {number} coordinate
 */
const roughnessAt = ([a, b, c, d], coordinate) => {
  let low = 0, high = 1;
  for (let i = 0; i < 40; ++i) {
    const middle = (low + high) / 2;
    if ((a + b * middle) * (c + d * middle) < coordinate * coordinate) low = middle;
    else high = middle;
  }
  return high;
};

export class View {
  /** @param {HTMLCanvasElement} canvas @param {WebGLRenderer} [renderer] of an earlier view on that canvas */
  constructor(canvas, renderer) {
    try {
      this.renderer = renderer ?? new WebGLRenderer({ canvas, antialias: true });
    } catch {
      throw new Error("This browser has no WebGL2, which the page draws with.");
    }
    this.canvas = canvas;
    /** By layout; "": the scene as it was cooked. @type {Map<string, LayoutSet>} */
    this.sets = new Map();
    /** Layout that is shown as cooked. */
    this.layout = "";
    /** What is shown beside it, and on which share of the canvas from the left. @type {{ set: LayoutSet, share: number } | null} */
    this.beside = null;
    /** @type {ViewedLightMap[]} */
    this.lightMaps = [];
    /** @type {ViewedCandidate[]} */
    this.candidates = [];
    /** What all layouts share, by light map. @type {Map<string, { dominant: import("../loaders/core/specular.js").ShaderPart | null, reference: any, left: number | null }>} */
    this.shared = new Map();
    this.box = new Box3();
    this.has = { reference: false, directions: false, tables: false, dominant: false, materials: false, clusters: false, light: false, mesh: false };
    this.roughness = [0.0625, 1];
    /** @type {{ name: string, part: import("../loaders/core/specular.js").ShaderPart }[]} */
    this.environments = [];
    this.frames = 0;
  }

  /** The light maps that are shown as cooked, or those of the scene until they are loaded. @returns {LayoutSet} */
  get shown() {
    return this.setFor(this.layout);
  }
  /** @param {string} layout @returns {LayoutSet} that of the scene until the layout's is loaded */
  setFor(layout) {
    return /** @type {LayoutSet} */ (this.sets.get(layout) ?? this.sets.get(""));
  }
  get maps() {
    return this.sets.size > 0 ? this.shown.maps : [];
  }
  /** Working colour space of the scene. */
  get workingSpace() {
    return /** @type {CookedScene} */ (this.cooked).manifest.color.working;
  }
  gl() {
    return /** @type {WebGL2RenderingContext} */ (this.renderer.getContext());
  }

  /** Loads everything. @param {import("./source.js").SceneSource} source @param {(share: number) => void} onProgress */
  async load(source, onProgress) {
    let arrived = 0, expected = 1 << 16;
    const onBytes = (/** @type {number} */ bytes) => {
      arrived += bytes;
      onProgress(Math.min(arrived / expected, 1));
    };
    const { data } = source;
    this.source = source;
    this.lightMaps = data.light_maps;
    this.candidates = data.candidates;
    this.cooked = await this.open(source.folder, onBytes);
    const { manifest } = this.cooked;
    for (const asset of manifest.assets)
      if (asset.kind !== "rsrm") expected += (asset.bytes_disk ?? 0) + asset.textures.reduce((sum, texture) => sum + texture.bytes_disk, 0);
    for (const map of data.light_maps) {
      const asset = manifest.assets.find(({ name }) => name === map.name);
      if (map.reference && asset) expected += asset.width * asset.height * 8 * map.reference_layers;
    }
    this.uniforms = sharedUniforms(this.workingSpace);
    this.eye = { value: new Vector3() };
    const lut = this.cooked.assets("lut")[0];
    this.tables = lut ? specularTables(lut, await this.cooked.textures(lut)) : null;
    if (lut) {
      const { factors, minimum, maximum } = lut.constants.roughness;
      this.roughness = [roughnessAt(factors, minimum), roughnessAt(factors, maximum)];
    }
    for (const asset of this.cooked.assets("cubemap"))
      this.environments.push({ name: asset.name, part: environmentMap(asset, await this.cooked.textures(asset)) });
    this.environment = this.environments.length > 0 ? { glsl: this.environments[0].part.glsl, uniforms: cloneUniforms(this.environments[0].part.uniforms) } : null;
    this.sets.set("", await this.setOf(this.cooked, onBytes));
    if (this.maps.length === 0) throw new Error("The cooked scene has no light map to show.");
    this.has.clusters ||= this.candidates.some(({ layout }) => !!LAYOUTS[layout]?.code);
    this.has.light ||= this.candidates.some(({ layout }) => !!LAYOUTS[layout]?.hasLight);
    this.has.tables = this.tables !== null && this.maps.some(({ decode }) => decode.hasDirections);
    this.uniforms.bumpFrequency.value = 60 / Math.max(this.box.getSize(new Vector3()).length(), 1e-6);
    this.raycaster = new Raycaster();
    onProgress(1);
  }
  /** Loads the light maps of a candidate, if they are not there yet. @param {string} layout @param {(share: number) => void} onProgress */
  async loadCandidate(layout, onProgress) {
    const candidate = this.candidates.find((each) => each.layout === layout);
    if (!candidate || this.sets.has(layout)) return;
    let arrived = 0;
    const onBytes = (/** @type {number} */ bytes) => onProgress(Math.min((arrived += bytes) / Math.max(candidate.bytes_gpu, 1), 1));
    this.sets.set(layout, await this.setOf(await this.open(candidate.folder, onBytes), onBytes));
  }
  /** @param {string} folder @param {(bytes: number) => void} onBytes */
  open(folder, onBytes) {
    return CookedScene.open(folder, { gl: this.gl(), draco: new URL("assets/draco/", document.baseURI).href, onBytes, fetch: this.source?.fetch });
  }
  /** Frees what lies in GPU memory. */
  dispose() {
    const textures = new Set();
    for (const { scene, lines, maps } of this.sets.values()) {
      for (const object of /** @type {any[]} */ ([...scene.children, ...lines.children])) {
        for (const { value } of Object.values(object.material.uniforms ?? {})) if (value?.isTexture) textures.add(value);
        object.geometry.dispose();
        object.material.dispose();
      }
      for (const { points } of maps) points.dispose();
    }
    for (const texture of textures) texture.dispose();
  }
  /** @param {CookedScene} cooked @param {(bytes: number) => void} onBytes @returns {Promise<LayoutSet>} */
  async setOf(cooked, onBytes) {
    const set = { cooked, scene: new Scene(), lines: new Scene(), maps: [] };
    for (const map of this.lightMaps) await this.addLightMap(set, map, onBytes);
    return set;
  }
  /** Loads what a light map has whatever its layout: its dominant light and its float bake. @param {ViewedLightMap} data @param {(bytes: number) => void} onBytes */
  async sharedOf(data, onBytes) {
    const known = this.shared.get(data.name), cooked = /** @type {CookedScene} */ (this.cooked);
    if (known) return known;
    const asset = cooked.manifest.assets.find(({ name, kind, light_map }) => kind === "dominant" && (light_map ?? name) === (light_map ? data.name : `${data.name}_dominant`));
    const isDerived = cooked.manifest.assets.some(({ name, kind, dominant }) => kind === "light-map" && name === data.name && dominant === "derived");
    const dominant = asset ? dominantLight(asset, await cooked.textures(asset)) : isDerived ? derivedLight() : null;
    const reference = data.reference ? makeTexture(await readKtx2(await fetchBytes(data.reference, onBytes), data.reference), this.gl(), data.reference) : null;
    const made = { dominant, reference, left: this.box.isEmpty() ? null : this.box.max.x };
    this.shared.set(data.name, made);
    return made;
  }

  /** Loads a light map and its meshes into a set. @param {LayoutSet} set @param {ViewedLightMap} data @param {(bytes: number) => void} onBytes */
  async addLightMap(set, data, onBytes) {
    const { cooked } = set, { assets } = cooked.manifest;
    const asset = assets.find(({ name, kind }) => name === data.name && kind === "light-map");
    if (!asset) throw new Error(`viewer/scene.json: found light map "${data.name}", which cooked.json does not have`);
    const decode = await cooked.lightMap(asset), { dominant, reference, left } = await this.sharedOf(data, onBytes);
    const meshAsset = data.mesh ? assets.find(({ name, kind }) => name === data.mesh && kind === "mesh") : undefined;
    const packing = asset.verify?.unpacked?.packing, bake = packing ? { width: packing.width_before, height: packing.height_before } : asset;
    const meshes = meshAsset ? await this.meshesOf(cooked, meshAsset, packing ? packing.uv_before : "TEXCOORD_1") : [];
    const hasReference = reference !== null, hasMesh = meshes.length > 0, hasClusters = !!decode.layout.code;
    if (!hasMesh) meshes.push(this.sheet(asset, left));
    // Cubemaps are in the world of the mesh.
    const environment = decode.axes.every(([component, sign], i) => component === i && sign === 1) ? (this.environment ?? null) : null;
    const shading = shadingGlsl(cooked.shader, decode, { tables: this.tables ?? null, dominant, environment, referenceLayers: data.reference_layers });
    const uniforms = this.uniformsOf(data, asset, { ...decode.uniforms, ...dominant?.uniforms }, reference);
    const defines = { ...(decode.needsCluster && { LIGHT_MAP_CLUSTER: 1 }), ...(hasClusters && { HAS_CLUSTERS: 1 }), ...(!hasMesh && { NO_MESH: 1 }) };
    const charts = findCharts(meshes, asset.width, asset.height);
    for (const mesh of meshes) {
      mesh.material = this.surfaceMaterial(mesh.material, { uniforms, defines, fragmentShader: shading + FRAGMENT_MAIN });
      this.box.union(new Box3().setFromObject(mesh));
      set.scene.add(mesh);
    }
    set.lines.add(new LineSegments(charts.seams, new LineBasicMaterial({ color: 0x22c8ff })));
    const points = new ShaderMaterial({
      glslVersion: GLSL3,
      uniforms: { ...uniforms, materialAlbedo: { value: [1, 1, 1] }, materialEmission: { value: [0, 0, 0] }, pointCount: { value: 0 } },
      vertexShader: POINTS_VERTEX,
      fragmentShader: POINTS_HEAD + shading + POINTS_MAIN,
      depthTest: false,
      depthWrite: false,
    });
    set.maps.push({ data, asset, decode, hasReference, hasMesh, meshes, bake, charts, points, clusters: clustersOfBlocks(asset) });
    this.has.reference ||= hasReference;
    this.has.directions ||= decode.hasDirections;
    this.has.dominant ||= dominant !== null && decode.hasDirections && this.tables !== null;
    this.has.clusters ||= hasClusters;
    this.has.light ||= !!decode.layout.hasLight;
    this.has.mesh ||= hasMesh;
  }

  /** Returns the uniforms of all materials of a light map. @param {ViewedLightMap} data @param {import("../loaders/core/cooked.js").CookedAsset} asset
   * @param {Record<string, { value: any }>} light of its decode and its dominant light @param {any} reference texture of the float bake, or null */
  uniformsOf(data, asset, light, reference) {
    const display = data.display ?? NO_DISPLAY;
    /** @type {Record<string, { value: any }>} */
    const uniforms = {
      ...light, ...this.uniforms, ...this.tables?.uniforms, ...this.environment?.uniforms,
      eye: /** @type {any} */ (this.eye), display: { value: [display.nits, display.black] }, mapSize: { value: [asset.width, asset.height] },
    };
    if (reference === null) return uniforms;
    return { ...uniforms, referenceMap: { value: reference }, referenceUnit: { value: 1 / data.reference_scale } };
  }

  /** Makes the material that shades a mesh, with the colours and the sides of its glTF material.
   * @param {any} source @param {{ uniforms: Record<string, { value: any }>, defines: Record<string, number>, fragmentShader: string }} shader */
  surfaceMaterial(source, { uniforms, defines, fragmentShader }) {
    /** @type {number[]} */
    const albedo = source.color ? source.color.toArray() : [1, 1, 1];
    /** @type {number[]} */
    const emission = source.emissive ? source.emissive.toArray().map((/** @type {number} */ x) => x * (source.emissiveIntensity ?? 1)) : [0, 0, 0];
    if (albedo.some((x) => x !== 1) || emission.some((x) => x > 0)) this.has.materials = true;
    return new ShaderMaterial({
      glslVersion: GLSL3,
      defines,
      uniforms: { ...uniforms, materialAlbedo: { value: albedo }, materialEmission: { value: emission } },
      vertexShader: VERTEX,
      fragmentShader,
      side: source.side === DoubleSide ? DoubleSide : FrontSide,
    });
  }

  /** Meshes with light-map UVs, in world space. @param {CookedScene} cooked @param {import("../loaders/core/cooked.js").CookedAsset} asset @param {string} bakeUvs vertex attribute with the UVs of the bake */
  async meshesOf(cooked, asset, bakeUvs) {
    const group = await cooked.mesh(asset);
    group.updateMatrixWorld(true);
    /** @type {Mesh[]} */
    const meshes = [];
    group.traverse((/** @type {any} */ object) => {
      if (!object.isMesh || !object.geometry.getAttribute("uv1")) return;
      /** @type {BufferGeometry} */
      const geometry = object.geometry;
      if (!geometry.index) geometry.setIndex([...Array(geometry.getAttribute("position").count).keys()]);
      if (!geometry.getAttribute("normal")) geometry.computeVertexNormals();
      // three.js names the first four sets of UVs so, and others as the file does in lower case.
      const name = { TEXCOORD_0: "uv", TEXCOORD_1: "uv1", TEXCOORD_2: "uv2", TEXCOORD_3: "uv3" }[bakeUvs] ?? bakeUvs.toLowerCase();
      const bakeUv = geometry.getAttribute(name);
      if (!bakeUv) throw new Error(`found no ${bakeUvs} in the mesh "${asset.name}", which has the UVs of its bake: cook the scene again`);
      geometry.setAttribute("bakeUv", bakeUv);
      const mesh = new Mesh(geometry, object.material);
      // The matrix as it is: a rotation below an uneven scale shears, which position, rotation and scale cannot express.
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(object.matrixWorld);
      mesh.updateMatrixWorld(true);
      meshes.push(mesh);
    });
    return meshes;
  }

  /** A light map without a mesh, as a sheet. @param {import("../loaders/core/cooked.js").CookedAsset} asset @param {number | null} left where the scene ends so far; null: nothing is there */
  sheet(asset, left) {
    const geometry = new PlaneGeometry(asset.width / asset.height, 1), uv = geometry.getAttribute("uv");
    geometry.setAttribute("uv1", new BufferAttribute(Float32Array.from({ length: 2 * uv.count }, (_, i) => (i % 2 ? 1 - uv.getY(i >> 1) : uv.getX(i >> 1))), 2));
    geometry.setAttribute("bakeUv", geometry.getAttribute("uv1"));
    const mesh = new Mesh(geometry);
    mesh.material = /** @type {any} */ ({ side: DoubleSide });
    mesh.position.x = left === null ? 0 : left + asset.width / asset.height;
    mesh.updateMatrixWorld(true);
    return mesh;
  }

  /** Takes the settings of the page over. @param {import("./link.js").State} state @param {boolean} blinked true while blink shows the reference */
  apply(state, blinked) {
    const u = this.uniforms;
    if (!u) return;
    const side = { wipe: 0, reference: 1, cooked: 2, error: 3, blink: blinked ? 1 : 2 }[state.mode] ?? 2;
    this.layout = state.layout;
    const set = state.beside ? this.sets.get(state.beside) : undefined;
    this.beside = set ? { set, share: side === 0 ? state.wipe : side === 1 ? 1 : 0 } : null;
    u.shownSide.value = this.beside && side !== 3 ? 2 : this.has.reference ? side : 2;
    u.borderX.value = state.wipe * this.canvas.width;
    u.exposureStops.value = state.stops;
    u.errorEnd.value = state.errorEnd;
    u.showDiffuse.value = state.diffuse || !this.has.tables ? 1 : 0;
    u.glossy.value = !this.has.tables ? 0 : state.glossy === "area" ? 1 : state.glossy === "environment" && this.environments.length > 0 ? 2 : 0;
    u.showDominant.value = state.dominant && this.has.dominant ? 1 : 0;
    u.roughness.value = Math.min(Math.max(state.m, this.roughness[0]), this.roughness[1]);
    u.f0.value = state.f0;
    u.albedoScale.value = state.albedo;
    u.lightMapDim.value = [state.light, state.light, state.light];
    u.useMaterials.value = state.materials && this.has.materials ? 1 : 0;
    u.bumpTilt.value = (state.bump * Math.PI) / 180;
    u.overlay.value = ["none", "charts", "clusters", "texels"].indexOf(state.overlay);
    const chosen = this.environments[state.environment] ?? this.environments[0];
    if (chosen && this.environment) for (const [key, { value }] of Object.entries(chosen.part.uniforms)) this.environment.uniforms[key].value = value;
    this.showSeams = state.seams;
  }

  /** Fits the drawing to the canvas' size on the page. Returns the aspect. */
  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));  // zoom and another screen change it
    this.renderer.setSize(Math.max(clientWidth, 1), Math.max(clientHeight, 1), false);
    return Math.max(clientWidth, 1) / Math.max(clientHeight, 1);
  }

  /** @param {import("three").PerspectiveCamera} camera @param {string} background CSS colour */
  draw(camera, background) {
    /** @type {{ value: Vector3 }} */ (this.eye).value.copy(camera.position);
    this.renderer.setClearColor(background, 1);
    const share = this.beside ? this.beside.share : 0;
    if (share < 1) this.drawSet(this.shown, camera, share, 1);
    if (this.beside && share > 0) this.drawSet(this.beside.set, camera, 0, share);
    ++this.frames;
  }
  /** Draws light maps on a part of the canvas. @param {LayoutSet} set @param {import("three").PerspectiveCamera} camera @param {number} from in [0, 1], from the left @param {number} to */
  drawSet(set, camera, from, to) {
    const { renderer } = this, { clientWidth, clientHeight } = this.canvas;
    renderer.setScissorTest(from > 0 || to < 1);
    renderer.setScissor(from * clientWidth, 0, (to - from) * clientWidth, clientHeight);
    renderer.autoClear = true;
    renderer.render(set.scene, camera);
    renderer.autoClear = false;
    if (this.showSeams) renderer.render(set.lines, camera);
    renderer.setScissorTest(false);
  }

  /** Returns the surface under a point of the canvas. @param {import("three").PerspectiveCamera} camera @param {number} x in [0, 1] @param {number} y in [0, 1], down */
  pick(camera, x, y) {
    const raycaster = /** @type {Raycaster} */ (this.raycaster);
    raycaster.setFromCamera(new Vector2(2 * x - 1, 1 - 2 * y), camera);
    const [hit] = raycaster.intersectObjects(this.shown.scene.children, false);
    if (!hit || !hit.face) return null;
    const mesh = /** @type {Mesh} */ (hit.object), { a, b, c } = hit.face, corner = [a, b, c];
    const map = this.maps.findIndex(({ meshes }) => meshes.includes(mesh));
    const local = mesh.worldToLocal(hit.point.clone()), position = mesh.geometry.getAttribute("position");
    const weight = barycentric(local, corner.map((k) => new Vector3().fromBufferAttribute(position, k)));
    const surface = surfaceAt(mesh, corner, weight);
    return { map, uv: surface.uv, surface };
  }

  /** Returns a vector of the mesh's world in the axes of a light map, and one of those in that world.
   * @param {import("../loaders/core/light_map.js").Axes} axes @param {number[]} vector */
  toMap(axes, vector) {
    return axes.map(([component, sign]) => sign * vector[component]);
  }
  /** @param {import("../loaders/core/light_map.js").Axes} axes @param {number[]} vector @returns {[number, number, number]} */
  toMesh(axes, vector) {
    /** @type {[number, number, number]} */
    const out = [0, 0, 0];
    axes.forEach(([component, sign], i) => (out[component] = sign * vector[i]));
    return out;
  }

  /** Returns the surface at a place of a light map. @param {ShownMap} map @param {number} u @param {number} v */
  surface(map, u, v) {
    return findSurface(map.meshes, u, v);
  }
  /** Returns the surface at a texel of the bake. @param {ShownMap} map @param {[number, number]} texel integers are centres */
  surfaceOfBake(map, [x, y]) {
    return findSurface(map.meshes, (x + 0.5) / map.bake.width, (y + 0.5) / map.bake.height, "bakeUv");
  }

  /** Returns the UV of the bake at a place of a light map. @param {ShownMap} map @param {[number, number]} uv @param {import("./charts.js").Found | null} [found] the surface there, if it is known @returns {[number, number]} */
  bakeUvAt(map, uv, found) {
    return map.bake === map.asset ? uv : (found ?? this.surface(map, ...uv))?.bakeUv ?? uv;
  }

  /** Cluster of a texel, where the manifest names those of the mesh. @param {ShownMap} map @param {number} x @param {number} y */
  clusterOf(map, x, y) {
    return map.clusters ? map.clusters[Math.floor(y / 4) * Math.ceil(map.asset.width / 4) + Math.floor(x / 4)] : 0;
  }

  /** Computes the values of places of a light map on the GPU. @param {ShownMap} map @param {Point[]} points @returns {Values[]} */
  values(map, points) {
    if (!this.gl().getExtension("EXT_color_buffer_float")) return [];
    const most = 2048;
    if (points.length > most) return [...this.values(map, points.slice(0, most)), ...this.values(map, points.slice(most))];
    const count = points.length, columns = new InstancedBufferGeometry(), plane = new PlaneGeometry();
    columns.index = plane.index;
    columns.setAttribute("position", plane.getAttribute("position"));
    columns.instanceCount = count;
    const setEach = (/** @type {string} */ name, /** @type {number} */ size, /** @type {(point: Point) => number[]} */ valuesOf) =>
      columns.setAttribute(name, new InstancedBufferAttribute(Float32Array.from(points.flatMap(valuesOf)), size));
    setEach("placeOfPoint", 3, ({ uv, cluster }) => [...uv, cluster]);
    setEach("normalOfPoint", 3, ({ normal }) => normal);
    setEach("viewOfPoint", 3, ({ view }) => view);
    setEach("bakeOfPoint", 2, ({ bakeUv }) => bakeUv);
    const target = new WebGLRenderTarget(count, ROWS.count, { type: FloatType, depthBuffer: false });
    map.points.uniforms.pointCount.value = count;
    const quad = new Mesh(columns, map.points), scene = new Scene();
    quad.frustumCulled = false;
    scene.add(quad);
    const { renderer } = this;
    renderer.setRenderTarget(target);
    renderer.render(scene, new OrthographicCamera());
    const out = new Float32Array(4 * count * ROWS.count);
    renderer.readRenderTargetPixels(target, 0, 0, count, ROWS.count, out);
    renderer.setRenderTarget(null);
    target.dispose();
    columns.dispose();
    const at = (/** @type {number} */ row, /** @type {number} */ i) => Array.from(out.subarray(4 * (row * count + i), 4 * (row * count + i) + 3));
    return points.map((_, i) => ({
      reference: Array.from({ length: 9 }, (_, k) => at(ROWS.reference + k, i)),
      cooked: Array.from({ length: 9 }, (_, k) => at(ROWS.cooked + k, i)),
      coverage: out[4 * i + 3],
      referenceLight: at(ROWS.referenceLight, i),
      cookedLight: at(ROWS.cookedLight, i),
      error: at(ROWS.error, i)[0],
      referenceShown: at(ROWS.referenceShown, i),
      cookedShown: at(ROWS.cookedShown, i),
    }));
  }
}

/** @param {Record<string, { value: any }>} uniforms */
function cloneUniforms(uniforms) {
  return Object.fromEntries(Object.entries(uniforms).map(([key, { value }]) => [key, { value }]));
}

/** @param {Vector3} p in the plane of the corners @param {Vector3[]} corners */
function barycentric(p, [a, b, c]) {
  const ab = b.clone().sub(a), ac = c.clone().sub(a), ap = p.clone().sub(a);
  const d00 = ab.dot(ab), d01 = ab.dot(ac), d11 = ac.dot(ac), d20 = ap.dot(ab), d21 = ap.dot(ac), det = d00 * d11 - d01 * d01;
  const v = (d11 * d20 - d01 * d21) / det, w = (d00 * d21 - d01 * d20) / det;
  return [1 - v - w, v, w];
}
