// SPDX-License-Identifier: MIT
// libdgm/web/package/index.js
// The runtime for scripts: index.d.ts describes every name. It calls the flat functions of ../touch.cpp, so that no struct
// of C is written here. A handle is a number; 0 is none, and every method asks for it first. Names that begin with _ are not
// for others.

const footprints = { surface: 0, geodesic: 2, grid: 3 }, modes = { elastic: 0, plastic: 1 }, rules = { smooth: 0, printed: 1 };
const kinds = { touch: 0, poke: 1, grasp: 2 }, ends = { printed: 0, compact: 1 };
const statuses = ["clear", "contact", "restored", "open"], domains = ["square", "free"];
const arrays = { 1: Uint8Array, 2: Uint16Array, 3: Uint32Array, 4: Int16Array, 5: Uint16Array, 6: Float32Array };
const none = 0xffffffff, mostTicks = 1000, mostTools = 4;

export class DgmError extends Error {
  constructor(code, message, offset = null) {
    super(code + ": " + message + (offset === null ? "" : " (byte " + offset + ")"));
    Object.assign(this, { name: "DgmError", code, offset });
  }
}

const choice = (table, name, what) => {
  if (!Object.hasOwn(table, name)) throw new DgmError("BAD_ARGUMENT", what + " is one of " + Object.keys(table).join(", "));
  return table[name];
};
const vector = (v, what) => {
  if (v === undefined || v.length !== 3 || ![...v].every(Number.isFinite)) throw new DgmError("BAD_ARGUMENT", what + " is three finite numbers");
  return v;
};

class Handle {
  constructor(runtime, pointer, free) { Object.assign(this, { _runtime: runtime, _pointer: pointer, _free: free }); }
  /** The number, while there is one. */
  get _live() {
    if (!this._pointer) throw new DgmError("BAD_ARGUMENT", "it is closed");
    return this._pointer;
  }
  close() {
    if (this._pointer) this._free(this._pointer);
    this._pointer = 0;
  }
}

export class Runtime {
  constructor(exports) {
    this._c = exports;
    exports._initialize();
  }
  _answers(count) { return Array.from(new Float64Array(this._c.memory.buffer, this._c.touch_answers(), count)); }
  _floats(at, count) { return new Float32Array(this._c.memory.buffer, at, count); }
  _text(at) {
    const bytes = new Uint8Array(this._c.memory.buffer, at >>> 0);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }
  _failed() {
    const offset = this._c.touch_error_offset();
    return new DgmError(this._text(this._c.touch_error_name()), this._text(this._c.touch_error_message()), offset < 0 ? null : offset);
  }
  _check(code) { if (code !== 0) throw this._failed(); }
  get bytes() { return this._c.memory.buffer.byteLength; }

  open(data, { verify = true } = {}) {
    const bytes = ArrayBuffer.isView(data) ? new Uint8Array(data.buffer, data.byteOffset, data.byteLength) : new Uint8Array(data);
    const memory = this._c.touch_memory(bytes.length) >>> 0;
    if (!memory) throw new DgmError("OUT_OF_MEMORY", "no memory is left");
    new Uint8Array(this._c.memory.buffer, memory, bytes.length).set(bytes);
    const pointer = this._c.touch_open(memory, bytes.length);
    const error = pointer && !(verify && this._c.touch_verify(pointer)) ? null : this._failed();
    const asset = new Asset(this, pointer, (p) => { this._c.touch_close(p), this._c.touch_forget(memory); });
    if (!error) return asset;
    if (pointer) asset.close(); else this._c.touch_forget(memory);
    throw error;
  }
  kernel({ reach, sigma, end = "compact" }) {
    const pointer = this._c.touch_table(reach, sigma, choice(ends, end, "end"));
    if (!pointer) throw this._failed();
    return Object.assign(new Handle(this, pointer, this._c.touch_table_free), { reach });
  }
}

export const load = async (source = new URL("dgm.wasm", import.meta.url)) => {
  const given = source instanceof URL || typeof source === "string" ? await fetch(source) : await source;
  const bytes = typeof Response !== "undefined" && given instanceof Response ? await given.arrayBuffer() : given;
  const made = await WebAssembly.instantiate(bytes, {});
  return new Runtime((made.instance ?? made).exports);
};

export class Asset extends Handle {
  get charts() {
    return Array.from({ length: this._runtime._c.touch_charts(this._live) }, (_, k) => this.chart(k));
  }
  chart(k) {
    const { _runtime: runtime } = this;
    runtime._check(runtime._c.touch_chart(this._live, k));
    const a = runtime._answers(17), method = runtime._text(runtime._c.touch_text());
    const layers = Array.from({ length: a[4] }, (_, l) => this._layerAt(k, l)[0]);
    return { rows: a[0], cols: a[1], domain: domains[a[2]], borderSamples: a[3], layers, min: a.slice(5, 8), max: a.slice(8, 11), offset: a.slice(11, 14), scale: a.slice(14, 17), method };
  }
  _layerAt(chart, number) {
    const { _runtime: runtime } = this;
    runtime._check(runtime._c.touch_layer(this._live, chart, number));
    const a = runtime._answers(10);
    return [runtime._text(runtime._c.touch_text()), { type: a[0], shape: a.slice(2, 2 + a[1]), data: a[6], bytes: a[7] }];
  }
  layer(chart, name) {
    const number = this.chart(chart).layers.indexOf(name);
    if (number < 0) return null;
    const [, { type, shape, data, bytes }] = this._layerAt(chart, number), Elements = arrays[type];
    return { shape, half: type === 5, data: new Elements(this._runtime._c.memory.buffer, data, bytes / Elements.BYTES_PER_ELEMENT).slice() };
  }
  validate(chart) { this._runtime._check(this._runtime._c.touch_check(this._live, chart)); }
  state(chart, { maxReach = 65 } = {}) {
    const { _runtime: runtime } = this, info = this.chart(chart), pointer = runtime._c.touch_body(this._live, chart, maxReach);
    if (!pointer) throw runtime._failed();
    return Object.assign(new State(runtime, pointer, runtime._c.touch_body_free), info, { _borderUv: info.borderSamples ? this.layer(chart, "border_uv")?.data : null });
  }
}

export class State extends Handle {
  _views(from) {
    this._runtime._c.touch_arrays(this._live);
    const a = this._runtime._answers(8);
    return a.slice(from, from + 3).map((at) => this._runtime._floats(at, a[0]));
  }
  get sampleCount() { return this._runtime._c.touch_arrays(this._live), this._runtime._answers(1)[0]; }
  get meanStep() { return this._runtime._c.touch_arrays(this._live), this._runtime._answers(2)[1]; }
  get activeSamples() { return this._runtime._c.touch_active(this._live); }
  get positions() { return this._views(2); }
  get normals() { return this._views(5); }
  uv() {
    const { rows, cols } = this, grid = rows * cols, out = new Float32Array(2 * this.sampleCount);
    for (let s = 0; s < grid; ++s) out[2 * s] = s % cols / (cols - 1), out[2 * s + 1] = Math.floor(s / cols) / (rows - 1);
    for (let b = 0; b < this.borderSamples; ++b) out[2 * (grid + b)] = this._borderUv[2 * b + 1], out[2 * (grid + b) + 1] = this._borderUv[2 * b];
    return out;
  }
  indices(stride = 1) {
    const at = this._runtime._c.touch_indices(this._live, stride) >>> 0;
    if (!at) throw this._runtime._failed();
    return new Uint32Array(this._runtime._c.memory.buffer, at, this._runtime._answers(1)[0]).slice();
  }
  copies(sample) {
    const count = this._runtime._c.touch_copies(this._live, sample);
    return count ? this._runtime._answers(Math.min(count, 64)) : [sample];
  }
  pick(origin, direction) {
    const { _runtime: runtime } = this;
    if (!runtime._c.touch_pick(this._live, ...vector(origin, "origin"), ...vector(direction, "direction"))) {
      const error = runtime._failed();
      if (error.code === "NOT_FOUND") return null;
      throw error;
    }
    const a = runtime._answers(18), quad = (k) => (a[k] === none ? null : a[k]);
    return { sample: a[0], row: quad(1), column: quad(2), triangle: a[3], corners: a.slice(4, 7), front: a[7] === 1, barycentric: a.slice(8, 11), distance: a[11], point: a.slice(12, 15), normal: a.slice(15, 18) };
  }
  tick(kernel, { dMax, footprint = "surface", mode = "elastic", rule = "smooth", dt = .001, fMax = 1, relaxRate = 0, settleTime = 0, graspDistance = 0, step = 0 }, tools, ticks = 1) {
    const { _runtime: runtime } = this, { _c: c } = runtime;
    if (!(ticks >= 1 && ticks <= mostTicks && Number.isInteger(ticks))) throw new DgmError("BAD_ARGUMENT", "ticks is 1 to " + mostTicks);
    if (tools.length > mostTools) throw new DgmError("LIMIT_EXCEEDED", "no more than " + mostTools + " tools");
    tools.forEach(({ kind = "touch", lifted = false, positions }, k) => {
      if (positions.length !== 3 * ticks) throw new DgmError("BAD_ARGUMENT", "positions has three numbers a tick");
      c.touch_tool(k, choice(kinds, kind, "kind"), lifted ? 1 : 0);
    });
    c.touch_ticking(choice(footprints, footprint, "footprint"), choice(modes, mode, "mode"), choice(rules, rule, "rule"), dt, dMax, fMax, relaxRate, settleTime, graspDistance, step);
    const places = runtime._floats(c.touch_places(), 3 * ticks * tools.length);
    tools.forEach(({ positions }, k) => {
      for (let t = 0; t < ticks; ++t) for (let d = 0; d < 3; ++d) places[3 * (t * tools.length + k) + d] = positions[3 * t + d];
    });
    runtime._check(c.touch_ticks(this._live, kernel._live, ticks, tools.length));
    const a = runtime._answers(3 + 10 * tools.length), felt = runtime._floats(c.touch_forces(), 3 * ticks * tools.length);
    const answer = (k) => {
      const out = a.slice(3 + 10 * k, 13 + 10 * k), forces = new Float32Array(3 * ticks);
      for (let t = 0; t < ticks; ++t) forces.set(felt.subarray(3 * (t * tools.length + k)).subarray(0, 3), 3 * t);
      return { sample: out[0], hit: out[1] === 1, holding: out[2] === 1, contact: out[3] === none ? null : out[3], displacement: out.slice(4, 7), force: out.slice(7, 10), forces };
    };
    return { contacts: a[0], samples: a[1], crossedSeam: a[2] === 1, tools: tools.map((_, k) => answer(k)) };
  }
  changed() {
    const count = this._runtime._c.touch_changed(this._live), a = this._runtime._answers(3 * count);
    return Array.from({ length: count }, (_, k) => ({ first: a[3 * k], columns: a[3 * k + 1], rows: a[3 * k + 2] }));
  }
  release() { this._runtime._c.touch_release(this._live); }
  reset() { this._runtime._c.touch_reset(this._live); }
  relax(dt, rate) { this._runtime._check(this._runtime._c.touch_relax(this._live, dt, rate)); }
  updateNormals() { this._runtime._c.touch_normals(this._live); }
  contact(obstacle, { mode = "elastic" } = {}) {
    const { _c: c } = this._runtime, { kind } = obstacle, m = choice(modes, mode, "mode");
    if (kind === "plane") this._runtime._check(c.touch_obstacle(this._live, 0, m, ...vector(obstacle.point, "point"), ...vector(obstacle.normal, "normal"), 0));
    else if (kind === "sphere") this._runtime._check(c.touch_obstacle(this._live, 1, m, ...vector(obstacle.point, "point"), 0, 0, 0, obstacle.radius));
    else if (kind === "capsule") this._runtime._check(c.touch_obstacle(this._live, 2, m, ...vector(obstacle.point, "point"), ...vector(obstacle.end, "end"), obstacle.radius));
    else if (kind === "surface") this._runtime._check(c.touch_other(this._live, obstacle.state._live, m, ...vector(obstacle.point ?? [0, 0, 0], "point"), obstacle.reach ?? 0));
    else throw new DgmError("BAD_ARGUMENT", "kind is one of plane, sphere, capsule, surface");
    const a = this._runtime._answers(6);
    return { status: statuses[a[0]], samples: a[1], removed: a[2], volumeError: a[3], volumeKept: a[4] === 1, deepest: a[5] };
  }
  volume() { return this._runtime._c.touch_volume(this._live); }
}
