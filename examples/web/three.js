// A cooked scene in three.js.
import { DoubleSide, PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { CookedScene, lightMapMaterial } from "lightcook-loaders/three";
import { canvas, options, start } from "./page.js";

start(async () => {
  const renderer = new WebGLRenderer({ canvas, antialias: options.antialias });
  const camera = new PerspectiveCamera(options.fov, 1, 0.05, 1000), controls = new OrbitControls(camera, canvas), world = new Scene();
  camera.position.set(...options.eye);
  controls.target.set(...options.target);
  controls.update();

  const cooked = await CookedScene.open(options.cooked, { gl: renderer.getContext(), draco: options.draco });
  for (const lightMap of cooked.assets("light-map")) {
    const material = lightMapMaterial(cooked, await cooked.lightMap(lightMap), { exposure: options.exposure ?? cooked.exposure(), srgb: true });
    const both = material.clone();
    both.uniforms = material.uniforms;
    both.side = DoubleSide;
    for (const asset of cooked.assets("mesh").filter((mesh) => mesh.light_map === lightMap.name)) {
      const group = await cooked.mesh(asset);
      group.traverse((object) => {
        if (object.isMesh) object.material = object.material.side === DoubleSide ? both : material;
      });
      world.add(group);
    }
  }

  const draw = () => {
    renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
    camera.aspect = canvas.clientWidth / canvas.clientHeight;
    camera.updateProjectionMatrix();
    renderer.render(world, camera);
  };
  controls.addEventListener("change", draw);
  addEventListener("resize", draw);
  draw();
  return draw;
});
