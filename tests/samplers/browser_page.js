// What the page of browser_device.cpp does: uploads textures, and runs a fragment shader at many places.
const gl = document.createElement('canvas').getContext('webgl2');
const kRow = 256, kTableRow = 1024;
const kPlaces = 13, kDirections = 14, kTable = 15;  // texture units
const textures = new Map();

const extensions = {};
function start() {
  if (!gl) return 'no WebGL2';
  for (const name of ['EXT_color_buffer_float', 'EXT_texture_compression_bptc', 'EXT_texture_compression_rgtc', 'EXT_texture_norm16',
                      'WEBGL_compressed_texture_s3tc', 'WEBGL_compressed_texture_astc'])
    extensions[name] = gl.getExtension(name);
  if (!extensions.EXT_color_buffer_float) return 'no float render targets';
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  return '';
}

function rendererName() {
  const debug = gl.getExtension('WEBGL_debug_renderer_info');
  return gl.getParameter(debug ? debug.UNMASKED_RENDERER_WEBGL : gl.RENDERER) + ', ' + gl.getParameter(gl.VERSION);
}

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}
function base64Of(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode.apply(null, bytes.subarray(i, i + 32768));
  return btoa(text);
}

// How WebGL2 takes a VkFormat: [internal] by blocks, [internal, format, type, array] by texels; undefined: not at all.
function formatOf(vkFormat) {
  const s3tc = extensions.WEBGL_compressed_texture_s3tc, rgtc = extensions.EXT_texture_compression_rgtc,
        bptc = extensions.EXT_texture_compression_bptc, astc = extensions.WEBGL_compressed_texture_astc,
        norm16 = extensions.EXT_texture_norm16;
  const table = {
    131: s3tc && [s3tc.COMPRESSED_RGB_S3TC_DXT1_EXT],
    137: s3tc && [s3tc.COMPRESSED_RGBA_S3TC_DXT5_EXT],
    139: rgtc && [rgtc.COMPRESSED_RED_RGTC1_EXT],
    140: rgtc && [rgtc.COMPRESSED_SIGNED_RED_RGTC1_EXT],
    141: rgtc && [rgtc.COMPRESSED_RED_GREEN_RGTC2_EXT],
    142: rgtc && [rgtc.COMPRESSED_SIGNED_RED_GREEN_RGTC2_EXT],
    143: bptc && [bptc.COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_EXT],
    144: bptc && [bptc.COMPRESSED_RGB_BPTC_SIGNED_FLOAT_EXT],
    145: bptc && [bptc.COMPRESSED_RGBA_BPTC_UNORM_EXT],
    157: astc && [astc.COMPRESSED_RGBA_ASTC_4x4_KHR],
    123: [gl.RGB9_E5, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, Uint32Array],
    122: [gl.R11F_G11F_B10F, gl.RGB, gl.UNSIGNED_INT_10F_11F_11F_REV, Uint32Array],
    97: [gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, Uint16Array],
    90: [gl.RGB16F, gl.RGB, gl.HALF_FLOAT, Uint16Array],
    70: norm16 && [norm16.R16_EXT, gl.RED, gl.UNSIGNED_SHORT, Uint16Array],
    77: norm16 && [norm16.RG16_EXT, gl.RG, gl.UNSIGNED_SHORT, Uint16Array],
    91: norm16 && [norm16.RGBA16_EXT, gl.RGBA, gl.UNSIGNED_SHORT, Uint16Array],
    37: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, Uint8Array],
    43: [gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, Uint8Array],
  };
  return table[vkFormat] || undefined;
}

function uploadLevel(format, target, level, width, height, layers, bytes) {
  const isArray = target === gl.TEXTURE_2D_ARRAY;
  if (format.length === 1) {
    if (isArray) gl.compressedTexImage3D(target, level, format[0], width, height, layers, 0, bytes);
    else gl.compressedTexImage2D(target, level, format[0], width, height, 0, bytes);
    return;
  }
  const texels = new format[3](bytes.buffer, bytes.byteOffset, bytes.byteLength / format[3].BYTES_PER_ELEMENT);
  if (isArray) gl.texImage3D(target, level, format[0], width, height, layers, 0, format[1], format[2], texels);
  else gl.texImage2D(target, level, format[0], width, height, 0, format[1], format[2], texels);
}

// What upload() takes next comes before it, level by level, in pieces that a message can hold.
let pieces = [];
function piece(level, base64) {
  (pieces[level] = pieces[level] || []).push(bytesOf(base64));
  return null;
}
function takeLevels() {
  const levels = pieces.map(each => {
    const bytes = new Uint8Array(each.reduce((sum, part) => sum + part.length, 0));
    let at = 0;
    for (const part of each) {
      bytes.set(part, at);
      at += part.length;
    }
    return bytes;
  });
  pieces = [];
  return levels;
}

function upload(unit, vkFormat, width, height, layers, faces) {
  const format = formatOf(vkFormat), levels = takeLevels();
  if (!format) return false;
  while (gl.getError() !== gl.NO_ERROR) {}
  if (textures.has(unit)) gl.deleteTexture(textures.get(unit));
  const texture = gl.createTexture(), target = faces === 6 ? gl.TEXTURE_CUBE_MAP : gl.TEXTURE_2D_ARRAY;
  textures.set(unit, texture);
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_CUBE_MAP, null);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, null);
  gl.bindTexture(target, texture);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, levels.length > 1 ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
  gl.texParameteri(target, gl.TEXTURE_MAX_LEVEL, levels.length - 1);
  levels.forEach((bytes, level) => {
    const w = Math.max(width >> level, 1), h = Math.max(height >> level, 1), faceBytes = bytes.length / faces;
    for (let face = 0; face < faces; ++face)
      uploadLevel(format, faces === 6 ? gl.TEXTURE_CUBE_MAP_POSITIVE_X + face : target, level, w, h, layers,
                  bytes.slice(face * faceBytes, (face + 1) * faceBytes));
  });
  return gl.getError() === gl.NO_ERROR;
}

// Numbers as a texture of rows; rowLength texels each, the last one filled up.
function numbers(unit, base64, rowLength, internal, format, channels) {
  const floats = new Float32Array(bytesOf(base64).buffer), texels = floats.length / channels;
  const width = Math.min(texels, rowLength), height = Math.ceil(texels / width);
  const padded = new Float32Array(width * height * channels);
  padded.set(floats);
  const texture = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, gl.FLOAT, padded);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  return {texture, width, height};
}

function compiled(type, text) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  return shader;
}

function run(fragment, samplers, places, directions, table) {
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0.0, 1.0); }`));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, fragment));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const at = numbers(kPlaces, places, kRow, gl.RGBA32F, gl.RGBA, 4), towards = numbers(kDirections, directions, kRow, gl.RGBA32F, gl.RGBA, 4),
        values = numbers(kTable, table, kTableRow, gl.R32F, gl.RED, 1);
  for (const [name, unit] of [...samplers, ['lcPlaces', kPlaces], ['lcDirections', kDirections], ['lcTable', kTable]])
    gl.uniform1i(gl.getUniformLocation(program, name), unit);
  const target = gl.createTexture(), framebuffer = gl.createFramebuffer();
  gl.activeTexture(gl.TEXTURE0 + 12);
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, at.width, at.height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, at.width, at.height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const results = new Float32Array(at.width * at.height * 4);
  gl.readPixels(0, 0, at.width, at.height, gl.RGBA, gl.FLOAT, results);
  const error = gl.getError();
  gl.deleteFramebuffer(framebuffer);
  for (const texture of [target, at.texture, towards.texture, values.texture]) gl.deleteTexture(texture);
  gl.deleteProgram(program);
  if (error !== gl.NO_ERROR) throw new Error('WebGL error ' + error);
  return base64Of(new Uint8Array(results.buffer));
}
