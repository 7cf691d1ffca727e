// SPDX-License-Identifier: MIT
// sheet.js: the map itself, flat, in a corner of the view: rows go down, columns to the right. Several charts lie side by
// side. What the pointer finds there is a place of the surface, so every tool works on it.

class Sheet {
  constructor(scene) { this.scene = scene; }
  get shown() { return $("sheet").checked && this.scene.bodies.length > 0; }
  // Where it is, in CSS pixels of the stage from its lower left corner: [left, bottom, side].
  box() {
    const { canvas } = this.scene, side = Math.round(Math.min(240, .36 * canvas.clientWidth, .42 * canvas.clientHeight));
    return [12, 12, side];
  }
  // Lower left corner of a chart's place on the sheet and its side, all in 0 .. 1.
  tile(number) {
    const count = Math.ceil(Math.sqrt(this.scene.bodies.length)), side = 1 / count, gap = count > 1 ? .03 * side : 0;
    return [number % count * side + gap / 2, 1 - (Math.floor(number / count) + 1) * side + gap / 2, side - gap];
  }
  draw(scale, background, each) {
    const { painter, bodies } = this.scene, gl = painter.gl, [left, bottom, side] = this.box().map((x) => Math.round(x * scale));
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(left - 2, bottom - 2, side + 4, side + 4);
    gl.clearColor(...background.map((c) => Math.abs(c - .12)), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.viewport(left, bottom, side, side);
    bodies.forEach((body, k) => {
      const [x, y, size] = this.tile(k);
      gl.uniform4f(painter.uniforms.sheet, 2 * x - 1, 2 * (y + size) - 1, 2 * size, 2 * size);
      each(body);
    });
    gl.uniform4f(painter.uniforms.sheet, 0, 0, 0, 0);
    gl.disable(gl.SCISSOR_TEST);
  }
  // Pixels of the stage, y down, of a place that a ray or the sheet found.
  place(hit) {
    const [left, bottom, side] = this.box(), [x, y, size] = this.tile(hit.body.index), { uv } = hit.body;
    const [u, v] = [0, 1].map((d) => hit.corners.reduce((sum, corner, k) => sum + hit.weights[k] * uv[2 * corner + d], 0));
    return [left + side * (x + size * u), this.scene.canvas.clientHeight - bottom - side * (y + size * (1 - v))];
  }
  // undefined: beside the sheet. null: on it, and no surface there.
  pick(at) {
    if (!this.shown) return undefined;
    const { canvas, bodies } = this.scene, [left, bottom, side] = this.box();
    const x = ((at[0] + 1) / 2 * canvas.clientWidth - left) / side, y = ((at[1] + 1) / 2 * canvas.clientHeight - bottom) / side;
    if (x < 0 || y < 0 || x > 1 || y > 1) return undefined;
    for (let k = 0; k < bodies.length; ++k) {
      const [tx, ty, size] = this.tile(k), u = (x - tx) / size, v = 1 - (y - ty) / size;
      if (u >= 0 && u <= 1 && v >= 0 && v <= 1) return this.find(bodies[k], u, v);
    }
    return null;
  }
  // The triangle over (u, v): u along columns, v along rows.
  find(body, u, v) {
    const { rows, cols, layers } = body.chart, grid = rows * cols, { uv } = body;
    const inside = (corners, more) => {
      const [a, b, c] = corners.map((s) => [uv[2 * s], uv[2 * s + 1]]), whole = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      const share = (p, q) => ((p[0] - u) * (q[1] - v) - (p[1] - v) * (q[0] - u)) / whole, w = [share(b, c), share(c, a), share(a, b)];
      return whole && w.every((x) => x >= -1e-6) ? this.hit(body, corners, w, more) : null;
    };
    const row = Math.min(rows - 2, Math.floor(v * (rows - 1))), column = Math.min(cols - 2, Math.floor(u * (cols - 1))), s = row * cols + column;
    const bytes = (layer) => layer && new Uint8Array(memory(), layer.data, layer.bytes), mask = bytes(layers.mask), diagonals = bytes(layers.diagonals);
    if (!mask || [s, s + 1, s + cols, s + cols + 1].every((k) => mask[k])) {
      const other = diagonals && diagonals[row * (cols - 1) + column] === 1;
      const halves = other ? [[s, s + cols, s + 1], [s + 1, s + cols, s + cols + 1]] : [[s, s + cols, s + cols + 1], [s, s + cols + 1, s + 1]];
      return inside(halves[0], { row, column, triangle: 0 }) || inside(halves[1], { row, column, triangle: 1 });
    }
    const faces = layers.border_faces && new Uint32Array(memory(), layers.border_faces.data, layers.border_faces.bytes / 4);
    for (let t = 0; faces && t < faces.length; t += 3) {
      const found = inside([faces[t], faces[t + 1], faces[t + 2]], { row: 2 ** 32 - 1, column: 2 ** 32 - 1, triangle: t / 3 });
      if (found) return found;
    }
    return null;
  }
  hit(body, corners, weights, more) {
    const [p, q, r] = corners.map((s) => body.place(s)), mean = (of) => corners.reduce((sum, s, k) => plus(sum, of(s), weights[k]), [0, 0, 0]);
    const along = mean((s) => body.normalAt(s)), flat = unit(cross(minus(q, p), minus(r, p)));
    const sample = corners[weights.indexOf(Math.max(...weights))];
    return { body, sample, corners, weights, point: mean((s) => body.place(s)), normal: dot(flat, along) < 0 ? scaled(flat, -1) : flat, front: true, distance: 0, ...more };
  }
}
