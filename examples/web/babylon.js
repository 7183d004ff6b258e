// A cooked scene in Babylon.js.
import { ArcRotateCamera } from "@babylonjs/core/Cameras/arcRotateCamera.js";
import { Engine } from "@babylonjs/core/Engines/engine.js";
import { Color4 } from "@babylonjs/core/Maths/math.color.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { Scene } from "@babylonjs/core/scene.js";
import { CookedScene, lightMapMaterial } from "lightcook-loaders/babylon";
import { canvas, options, start } from "./page.js";

start(async () => {
  const engine = new Engine(canvas, options.antialias), scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  scene.clearColor = new Color4(0, 0, 0, 1);
  const camera = new ArcRotateCamera("camera", 0, 0, 1, Vector3.FromArray(options.target), scene);
  camera.setPosition(Vector3.FromArray(options.eye));
  camera.fov = (options.fov * Math.PI) / 180;
  camera.minZ = 0.05;
  camera.maxZ = 1000;
  camera.attachControl();

  const cooked = await CookedScene.open(options.cooked, { scene, draco: options.draco });
  for (const lightMap of cooked.assets("light-map")) {
    const material = lightMapMaterial(cooked, await cooked.lightMap(lightMap), { exposure: options.exposure ?? cooked.exposure(), srgb: true });
    for (const asset of cooked.assets("mesh").filter((mesh) => mesh.light_map === lightMap.name)) await cooked.mesh(asset, material);
  }

  await scene.whenReadyAsync();
  engine.runRenderLoop(() => scene.render());
  addEventListener("resize", () => engine.resize());
  return () => scene.render();
});
