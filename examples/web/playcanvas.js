// A cooked scene in PlayCanvas.
import { Application, Color, Entity, FILLMODE_FILL_WINDOW, RESOLUTION_AUTO, Vec3, createGraphicsDevice } from "playcanvas";
import { CameraControls } from "playcanvas/scripts/esm/camera-controls.mjs";
import { CookedScene, lightMapMaterial } from "lightcook-loaders/playcanvas";
import { canvas, options, start } from "./page.js";

start(async () => {
  const device = await createGraphicsDevice(canvas, { deviceTypes: ["webgl2"], antialias: options.antialias });
  const app = new Application(canvas, { graphicsDevice: device });
  app.setCanvasFillMode(FILLMODE_FILL_WINDOW);
  app.setCanvasResolution(RESOLUTION_AUTO);
  app.start();
  const camera = new Entity("camera", app);
  camera.addComponent("camera", { fov: options.fov, nearClip: 0.05, farClip: 1000, clearColor: new Color(0, 0, 0, 1) });
  camera.setPosition(...options.eye);
  camera.lookAt(...options.target);
  app.root.addChild(camera);
  camera.addComponent("script");
  camera.script.create(CameraControls, { properties: { focusPoint: new Vec3(...options.target) } });

  const cooked = await CookedScene.open(options.cooked, { device, draco: options.draco });
  for (const lightMap of cooked.assets("light-map")) {
    const material = lightMapMaterial(cooked, await cooked.lightMap(lightMap), { exposure: options.exposure ?? cooked.exposure(), srgb: true });
    for (const asset of cooked.assets("mesh").filter((mesh) => mesh.light_map === lightMap.name)) app.root.addChild(await cooked.mesh(asset, material));
  }

  addEventListener("resize", () => app.resizeCanvas());
  return () => app.render();
});
