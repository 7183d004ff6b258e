// Shared by the pages of all engines: options of the address, the message, and a handle for tests.

/** Options of the address: babylon.html?cooked=cooked/&eye=0,1,4&target=0,1,0&fov=50&exposure=2&antialias=0 */
const query = new URLSearchParams(location.search);
const numbers = (name, otherwise) => query.get(name)?.split(",").map(Number) ?? otherwise;

export const options = {
  /** Cooked folder, or a .glb that `lightcook cook --gltf` wrote. */
  cooked: new URL(query.get("cooked") ?? "cooked/", document.baseURI).href,
  /** Folder with Draco's decoder. */
  draco: new URL("draco/", document.baseURI).href,
  eye: numbers("eye", [2.75, 2.75, 13]),
  target: numbers("target", [2.75, 2.75, 2.75]),
  /** From the lower to the upper edge of the picture [degrees]. */
  fov: numbers("fov", [34])[0],
  /** Factor of the light; undefined: as the scene's key says. */
  exposure: numbers("exposure", [])[0],
  antialias: query.get("antialias") !== "0",
};

export const canvas = document.getElementById("canvas");

/**
 * Starts a page. Shows the message of what fails.
 * @param {() => Promise<() => void>} load loads the scene and returns a function that draws it once
 */
export function start(load) {
  let draw = () => {};
  const status = document.getElementById("loading");
  const ready = load().then(
    (drawScene) => {
      draw = drawScene;
      status.hidden = true;
    },
    (fault) => {
      status.classList.add("failed");
      document.getElementById("loading-text").textContent = fault.message;
    });
  window.lightcook = {
    ready,
    picture() {
      draw();
      return canvas.toDataURL();
    },
  };
}
