export { CookedFolder, fetchBytes, jsonOf, openFolder } from "./cooked.js";
export { lightMapsOfNodes, manifestOfGltf } from "./gltf.js";
export { glTexture } from "./gl_texture.js";
export { imagesOf, mipSize, readKtx2, sampleable } from "./ktx2.js";
export { LAYOUTS, clustersOfBlocks, flatUniforms, isFetched, lightMapDecode } from "./light_map.js";
export { PIXEL_FORMATS, decodeImage, isSupported } from "./pixel_formats.js";
export { LIGHT_MAP_VARYINGS, surfaceGlsl, surfaceUniforms, vertexGlsl } from "./shading.js";
export { derivedLight, dominantLight, environmentMap, specularTables } from "./specular.js";
