// SPDX-License-Identifier: MIT
// source.js: the mesh that a map was made of, drawn beside the surface under the same camera; and numbers that a page
// carries for its samples.

// Bytes of numbers, all lowest ones first, to signed differences.
const differences = (bytes, at, count, width) => {
  const out = new Int32Array(count);
  for (let k = 0; k < count; ++k) {
    let code = 0;
    for (let b = 0; b < width; ++b) code |= bytes[at + b * count + k] << 8 * b;
    out[k] = signedOf(code);
  }
  return out;
};
// Numbers from 256 even steps.
const spread = (codes, { low, high }) => Float32Array.from(codes, (c) => low + c / 255 * (high - low));

class Source {
  constructor(painter, { element, bytes }, middle, scales) {
    const { vertices, faces, low, step, values } = element.dataset, n = Number(vertices), t = Number(faces), from = low.split(",").map(Number);
    const places = differences(bytes, 0, 3 * n, 2), steps = differences(bytes, 6 * n, 3 * t, 4), codes = bytes.subarray(6 * n + 12 * t);
    const columns = Array.from({ length: 6 }, () => new Float32Array(n)), index = new Uint32Array(3 * t);
    for (let c = 0; c < 3; ++c)
      for (let v = 0, code = 0; v < n; ++v) columns[c][v] = from[c] + Number(step) * (code = code + places[3 * v + c] & 65535) - middle[c];
    for (let k = 0, before = 0; k < 3 * t; ++k) index[k] = before = before + steps[k] >>> 0;
    Source.normals(columns, index);
    this.gl = painter.gl, this.layer = codes.length === n ? values : "";
    this.array = this.gl.createVertexArray();
    this.gl.bindVertexArray(this.array);
    this.buffers = columns.map((column, k) => painter.attribute(k, 1, column));
    if (this.layer) this.buffers.push(painter.attribute(10, 1, spread(codes, scales[values])));
    this.part = painter.indices(index);
  }
  // The means of those of the triangles around, by area. Vertices are split where the mesh has an edge.
  static normals(columns, index) {
    for (let t = 0; t < index.length; t += 3) {
      const [p, q, r] = [0, 1, 2].map((k) => [0, 1, 2].map((c) => columns[c][index[t + k]])), n = cross(minus(q, p), minus(r, p));
      for (let k = 0; k < 3; ++k) for (let c = 0; c < 3; ++c) columns[3 + c][index[t + k]] += n[c];
    }
  }
  close() {
    for (const buffer of [...this.buffers, this.part.buffer]) this.gl.deleteBuffer(buffer);
    this.gl.deleteVertexArray(this.array);
  }
}

// Left of the surface. It is drawn where the surface will be, and copied; pressing does not draw it again.
class Beside {
  constructor(scene) { Object.assign(this, { scene, canvas: $("beside"), source: null, drawn: "", size: "" }); }
  put(source) {
    if (this.source) this.source.close();
    this.source = source, this.drawn = "";
    $("beside-row").hidden = !source;
    this.show();
  }
  get shown() { return this.source !== null && $("both").checked; }
  show() {
    $("stage").classList.toggle("beside", this.shown);
    this.scene.wake();
  }
  draw(background, how) {
    if (!this.shown) return;
    const { scene, canvas } = this, from = scene.canvas, key = [scene.camera.text(), scene.camera.up, how.look, how.range, background].join(), size = [from.width, from.height].join();
    if (key === this.drawn && size === this.size) return;
    Object.assign(this, { drawn: key, size });
    canvas.width = from.width, canvas.height = from.height;
    scene.painter.start(scene.camera, scene.aspect(), background);
    scene.painter.draw(this.source.array, this.source.part, scene.painter.gl.TRIANGLES, how);
    canvas.getContext("2d").drawImage(from, 0, 0);
  }
}

// The numbers of a chart, { name: function }, as layersOf() has them.
const embeddedValues = (map, chart) => {
  const out = {};
  for (const { name, number, codes } of map.values || []) if (number === chart) out[name] = () => spread(codes, map.scales[name]);
  return out;
};
