// SPDX-License-Identifier: MIT
// module.js: the runtime's module, with views that stay right when its memory grows.

const inflated = async (bytes) =>
  new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
const bytesOf = (element) => Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));

// Undoes sign_last() of grid_codes.h.
const signedOf = (code) => code >>> 1 ^ -(code & 1);
// Undoes grid_codes.h in place: "OFFSET,ROWS,COLS ...".
const decodeGrids = (bytes, grids) => {
  for (const grid of grids.split(" ").filter(Boolean)) {
    const [offset, rows, cols] = grid.split(",").map(Number), row = 3 * cols, count = rows * row;
    const codes = bytes.slice(offset, offset + 2 * count), q = new Uint16Array(count);
    for (let k = 0; k < count; ++k) {
      const code = codes[k] | codes[count + k] << 8, rest = signedOf(code), left = k % row >= 3;
      q[k] = rest + (left ? q[k - 3] : 0) + (k >= row ? q[k - row] - (left ? q[k - row - 3] : 0) : 0);
    }
    for (let k = 0; k < count; ++k) bytes[offset + 2 * k] = q[k] & 255, bytes[offset + 2 * k + 1] = q[k] >> 8;
  }
  return bytes;
};

let dgm; // the module's functions
const memory = () => dgm.memory.buffer;
const answers = (count) => Array.from(new Float64Array(memory(), dgm.touch_answers(), count));
const floats = (at, count) => new Float32Array(memory(), at, count);
const text = (at) => {
  const bytes = new Uint8Array(memory(), at);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
};
// What the runtime says went wrong. Names of codes stand in dgm.h; the first words are for people.
const meanings = {
  NOT_DGM: "This is no .dgm file.", BAD_VERSION: "The file is of a newer version.", TRUNCATED: "The file is cut short: copy or bake it again.",
  HASH_MISMATCH: "The file was damaged after it was written: copy or bake it again.", BAD_INDEX: "The file is damaged: copy or bake it again.",
  OUT_OF_MEMORY: "The map is too large for this page.",
};
class RuntimeError extends Error {
  constructor() {
    const name = text(dgm.touch_error_name()), offset = dgm.touch_error_offset();
    const place = offset >= 0 ? " (byte " + offset + ")" : "";
    super((meanings[name] || "The runtime refuses this map.") + "\n" + name + ": " + text(dgm.touch_error_message()) + place);
    this.code = name;
  }
}
const check = (code) => { if (code) throw new RuntimeError(); };

const startModule = async (bytes) => {
  dgm = (await WebAssembly.instantiate(bytes, {})).instance.exports;
  dgm._initialize();
};

// A file in the module's memory. Every byte is checked before anything is believed.
class Asset {
  constructor(bytes) {
    this.data = dgm.touch_memory(bytes.length);
    if (!this.data) throw new Error(meanings.OUT_OF_MEMORY);
    new Uint8Array(memory(), this.data, bytes.length).set(bytes);
    this.handle = dgm.touch_open(this.data, bytes.length);
    try {
      if (!this.handle) throw new RuntimeError();
      check(dgm.touch_verify(this.handle));
      this.charts = Array.from({ length: dgm.touch_charts(this.handle) }, (_, k) => this.chart(k));
    } catch (error) {
      this.close();
      throw error;
    }
  }
  close() {
    if (this.handle) dgm.touch_close(this.handle);
    dgm.touch_forget(this.data);
    this.handle = 0;
  }
  chart(k) {
    check(dgm.touch_chart(this.handle, k));
    const a = answers(17), layers = {};
    const out = { rows: a[0], cols: a[1], free: a[2] === 1, border: a[3], box: a.slice(5, 11), offset: a.slice(11, 14), method: text(dgm.touch_text()), layers };
    for (let l = 0; l < a[4]; ++l) {
      check(dgm.touch_layer(this.handle, k, l));
      const v = answers(10);
      layers[text(dgm.touch_text())] = { type: v[0], shape: v.slice(2, 2 + v[1]), data: v[6], bytes: v[7] };
    }
    return out;
  }
}
