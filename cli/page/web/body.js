// SPDX-License-Identifier: MIT
// body.js: a chart that is touched: its state in the runtime, its copy on the graphics card.

const kSteps = 45; // reach of the kernel; a step is a 45th of the tool's size, so the grid's fineness is not felt
const kGeodesic = 2;

class Body {
  constructor(painter, asset, k, middle, embedded) {
    const chart = asset.charts[k];
    Object.assign(this, { painter, chart, number: k, parts: {}, picture: null });
    this.handle = dgm.touch_body(asset.handle, k, kSteps);
    if (!this.handle) throw new RuntimeError();
    this.origin = minus(chart.offset, middle); // the page's frame = local + origin
    dgm.touch_arrays(this.handle);
    const a = answers(8);
    [this.count, this.step] = a;
    this.places = a.slice(2, 5), this.normals = a.slice(5, 8);
    this.rest = this.copy();
    this.base = this.rest;
    this.uv = this.uvs();
    this.layers = layersOf(chart, embedded), this.known = {};
    if (painter.gl) this.load(this.uv);
  }
  close() {
    dgm.touch_body_free(this.handle);
    if (!this.array) return;
    const gl = this.painter.gl;
    for (const buffer of [...this.buffers, ...Object.values(this.parts).map((part) => part.buffer), this.layer || null]) gl.deleteBuffer(buffer);
    gl.deleteVertexArray(this.array);
    if (this.picture) gl.deleteTexture(this.picture.texture);
  }
  arrays() { return [...this.places, ...this.normals].map((at) => floats(at, this.count)); }
  copy(arrays = this.places) { return arrays.map((at) => floats(at, this.count).slice()); }
  // How far a sample moved at most.
  farthest([x, y, z]) {
    const [u, v, w] = this.places.map((at) => floats(at, this.count));
    let most = 0;
    for (let s = 0; s < this.count; ++s) most = Math.max(most, (u[s] - x[s]) ** 2 + (v[s] - y[s]) ** 2 + (w[s] - z[s]) ** 2);
    return Math.sqrt(most);
  }
  place(sample) { return this.places.map((at) => floats(at, this.count)[sample]); }
  // Places in the picture: along columns, then along rows.
  uvs() {
    const { rows, cols, border } = this.chart, out = new Float32Array(2 * this.count), grid = rows * cols;
    for (let s = 0; s < grid; ++s) out[2 * s] = s % cols / (cols - 1), out[2 * s + 1] = Math.floor(s / cols) / (rows - 1);
    const layer = this.chart.layers.border_uv;
    if (border && layer) {
      const uv = floats(layer.data, 2 * border);
      for (let b = 0; b < border; ++b) out[2 * (grid + b)] = uv[2 * b + 1], out[2 * (grid + b) + 1] = uv[2 * b];
    }
    return out;
  }
  load(uvs) {
    const { painter } = this, gl = painter.gl;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    this.buffers = this.arrays().map((array, k) => painter.attribute(k, 1, array, gl.DYNAMIC_DRAW));
    this.buffers.push(painter.attribute(6, 2, uvs), ...this.rest.map((array, k) => painter.attribute(7 + k, 1, array)));
    this.level(1);
    dgm.touch_changed(this.handle); // all of it is there
  }
  // A layer's numbers on the grid; null if the chart has none. Border samples have none of their own: 0.
  values(name) {
    if (!this.layers[name]) return null;
    return this.known[name] ||= this.layers[name]();
  }
  // Puts a layer on the graphics card. False if there is none.
  show(name) {
    if (this.shown === name) return true;
    const values = this.values(name), gl = this.painter.gl;
    if (!values) return false;
    const all = new Float32Array(this.count);
    all.set(values);
    gl.bindVertexArray(this.array);
    if (this.layer) gl.deleteBuffer(this.layer);
    this.layer = this.painter.attribute(10, 1, all);
    this.shown = name;
    return true;
  }
  // Triangles of blocks of `stride` quads.
  level(stride) {
    const name = "level" + stride;
    if (!this.parts[name]) {
      const at = dgm.touch_indices(this.handle, stride);
      if (!at) throw new RuntimeError();
      this.parts[name] = this.painter.indices(new Uint32Array(memory(), at, answers(1)[0]));
    }
    return this.parts[name];
  }
  lines(name) {
    const made = { grid: () => this.gridLines(), triangles: () => this.edges(), seams: () => this.borderLines(true), borders: () => this.borderLines(false) };
    return this.parts[name] ||= this.painter.indices(Uint32Array.from(made[name]()));
  }
  // Every edge of the triangles, diagonals too; inner ones twice, which nobody sees.
  edges() {
    const at = dgm.touch_indices(this.handle, 1), index = new Uint32Array(memory(), at, answers(1)[0]), out = new Uint32Array(2 * index.length);
    for (let t = 0; t < index.length; t += 3) out.set([index[t], index[t + 1], index[t + 1], index[t + 2], index[t + 2], index[t]], 2 * t);
    return out;
  }
  gridLines() {
    const { rows, cols, layers } = this.chart, out = [];
    const mask = layers.mask ? new Uint8Array(memory(), layers.mask.data, rows * cols) : null;
    const there = (s) => !mask || mask[s];
    const down = Math.max(1, Math.round((rows - 1) / 32)), across = Math.max(1, Math.round((cols - 1) / 32));
    for (let i = 0; i < rows; ++i)
      for (let j = 0; j < cols; ++j) {
        const s = i * cols + j;
        if (!there(s)) continue;
        if (i % down === 0 && j + 1 < cols && there(s + 1)) out.push(s, s + 1);
        if (j % across === 0 && i + 1 < rows && there(s + cols)) out.push(s, s + cols);
      }
    return out;
  }
  // Edges of the chart's border: those that are sewn, or those that are open.
  borderLines(sewn) {
    const { rows, cols, free } = this.chart, grid = rows * cols, out = [], last = (rows - 1) * cols;
    const add = (a, b) => {
      const both = dgm.touch_class(this.handle, a) !== -1 && dgm.touch_class(this.handle, b) !== -1;
      if (both === sewn) out.push(a, b);
    };
    if (!free) {
      for (let j = 0; j + 1 < cols; ++j) add(j, j + 1), add(last + j, last + j + 1);
      for (let i = 0; i + 1 < rows; ++i) add(i * cols, (i + 1) * cols), add((i + 1) * cols - 1, (i + 2) * cols - 1);
      return out;
    }
    const seen = new Map(), at = dgm.touch_indices(this.handle, 1), index = new Uint32Array(memory(), at, answers(1)[0]);
    for (let t = 0; t < index.length; t += 3)
      for (let k = 0; k < 3; ++k) {
        const a = index[t + k], b = index[t + (k + 1) % 3];
        if (a < grid || b < grid) continue;
        const key = Math.min(a, b) * this.count + Math.max(a, b);
        seen.set(key, seen.has(key) ? null : [a, b]);
      }
    for (const edge of seen.values()) if (edge) add(...edge);
    return out;
  }
  // The first triangle on a ray of the page's frame, with the place of the hit in the shape before the stroke.
  pick(ray) {
    return this.pickLocal(minus(ray.origin, this.origin), ray.direction);
  }
  pickLocal(o, d) {
    if (!dgm.touch_pick(this.handle, ...o, ...d)) return null;
    const a = answers(18);
    return { body: this, sample: a[0], row: a[1], column: a[2], triangle: a[3], corners: a.slice(4, 7), front: a[7] === 1,
      weights: a.slice(8, 11), distance: a[11], point: a.slice(12, 15), normal: a.slice(15, 18) };
  }
  before(hit) {
    const corner = (c) => this.base.map((array) => array[c]), [p, q, r] = hit.corners.map(corner);
    const point = plus(plus(scaled(p, hit.weights[0]), q, hit.weights[1]), r, hit.weights[2]);
    const normal = unit(cross(minus(q, p), minus(r, p)));
    return { point, normal: dot(normal, hit.normal) < 0 ? scaled(normal, -1) : normal };
  }
  normalAt(sample) { return this.normals.map((at) => floats(at, this.count)[sample]); }
  // Uploads what moved. Bytes.
  upload() {
    const count = dgm.touch_changed(this.handle), { painter } = this, gl = painter.gl;
    if (!count) return 0;
    const ranges = answers(3 * count), arrays = this.arrays(), { rows, cols } = this.chart;
    let bytes = 0;
    for (let k = 0; k < count; ++k) {
      const [first, columns, down] = ranges.slice(3 * k, 3 * k + 3);
      const end = first >= rows * cols ? first + columns : first + (down - 1) * cols + columns;
      arrays.forEach((array, a) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[a]);
        gl.bufferSubData(gl.ARRAY_BUFFER, 4 * first, array, first, end - first);
        bytes += 4 * (end - first);
      });
    }
    painter.uploaded += bytes;
    return bytes;
  }
  // Copies of seam samples whose bits differ: 0, or the seams are torn.
  torn() {
    const arrays = this.arrays(), bits = arrays.map((array) => new Uint32Array(array.buffer, array.byteOffset, array.length));
    let count = 0;
    for (let s = 0; s < this.count; ++s) {
      if (dgm.touch_class(this.handle, s) === -1) continue;
      const copies = dgm.touch_copies(this.handle, s), first = new Float64Array(memory(), dgm.touch_answers(), 1)[0];
      if (copies && bits.some((column) => column[s] !== column[first])) ++count;
    }
    return count;
  }
}
