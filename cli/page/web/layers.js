// SPDX-License-Identifier: MIT
// layers.js: what a chart has a number for at each sample, as a list of names and a colour a sample.

// Names for the numbers of known layers; those of other layers are called like their layer.
const kNames = {
  cover: ["cover radius"], contact: ["area of a sample", "mobility"], deformation: ["E: row step squared", "F", "G: column step squared", "stiffness"],
  bump: ["bump: height beyond the grid"], mask: ["mask"], diagonals: ["diagonals"],
};
const kUnshown = ["geometry", "normal", "texture", "seams", "border_faces", "border_uv", "border_geometry", "border_normal", "collision"];

const halfFloat = (bits) => {
  const exponent = bits >> 10 & 31, part = bits & 1023, size = exponent === 0 ? part * 2 ** -24 : exponent === 31 ? (part ? NaN : Infinity) : (1 + part / 1024) * 2 ** (exponent - 15);
  return bits & 0x8000 ? -size : size;
};

// { name: numbers of the grid's samples, row by row } as functions, since most are never looked at.
const layersOf = (chart, embedded) => {
  const out = {}, { rows, cols, layers } = chart;
  for (const [layer, view] of Object.entries(layers)) {
    const [m, n] = view.shape, each = view.shape[2] || 1, type = { 1: Uint8Array, 2: Uint16Array, 3: Uint32Array, 5: Uint16Array, 6: Float32Array }[view.type];
    if (kUnshown.includes(layer) || !type || view.shape.length < 2 || view.shape.length > 3 || m < 2 || n < 2 || each > 8) continue;
    for (let k = 0; k < each; ++k) {
      const name = (kNames[layer] || [])[k] || layer + (each > 1 ? " " + k : "");
      out[name] = () => {
        const all = new type(memory(), view.data, m * n * each), number = (s) => (view.type === 5 ? halfFloat(all[s]) : all[s]);
        // Layers of another size: the texel that is nearest.
        return Float32Array.from({ length: rows * cols }, (_, s) => {
          const i = Math.round(Math.floor(s / cols) / (rows - 1) * (m - 1)), j = Math.round(s % cols / (cols - 1) * (n - 1));
          return number(each * (i * n + j) + k);
        });
      };
    }
  }
  return { ...out, ...embedded };
};
