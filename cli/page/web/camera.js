// SPDX-License-Identifier: MIT
// camera.js: where the eye is. A turntable around a middle, y or z up, perspective of 28 degrees.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, t) => [a[0] * t, a[1] * t, a[2] * t];
const length = (a) => Math.hypot(...a);
const unit = (a) => scaled(a, 1 / (length(a) || 1));
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

// Where one looks from at first: the page may say.
const kStart = document.body.dataset.view ? document.body.dataset.view.split(",").map((x) => x * Math.PI / 180) : [.5, .35];
const kHalf = Math.tan(14 * Math.PI / 180);

class Camera {
  constructor() { this.fit([0, 0, 0], 1, "y"); }
  fit(middle, radius, up) {
    Object.assign(this, { middle, radius, up, yaw: kStart[0], pitch: kStart[1], zoom: 1, shift: [0, 0] });
  }
  // right, up, towards the eye
  frame() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const rows = [[cy, 0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]];
    return this.up === "z" ? rows.map(([x, y, z]) => [x, -z, y]) : rows;
  }
  away(aspect) { return 1.02 * this.radius / Math.sin(14 * Math.PI / 180) / this.zoom / Math.min(1, aspect); }
  target() {
    const [r, u] = this.frame();
    return plus(plus(this.middle, r, this.shift[0]), u, this.shift[1]);
  }
  eye(aspect) { return plus(this.target(), this.frame()[2], this.away(aspect)); }
  matrix(aspect) {
    const [r, u, b] = this.frame(), target = this.target(), away = this.away(aspect), reach = 2.2 * this.radius + length(this.shift);
    const near = Math.max(away - reach, this.radius / 500), far = away + reach;
    const k = (far + near) / (near - far), l = 2 * far * near / (near - far), out = new Float32Array(16);
    for (let c = 0; c < 3; ++c) {
      out[4 * c] = r[c] / (kHalf * aspect);
      out[4 * c + 1] = u[c] / kHalf;
      out[4 * c + 2] = k * b[c];
      out[4 * c + 3] = -b[c];
    }
    out[12] = -dot(r, target) / (kHalf * aspect);
    out[13] = -dot(u, target) / kHalf;
    out[14] = -k * dot(b, target) - k * away + l;
    out[15] = dot(b, target) + away;
    return out;
  }
  // x, y: -1 .. 1, y up
  ray(x, y, aspect) {
    const [r, u, b] = this.frame();
    return { origin: this.eye(aspect), direction: unit(plus(plus(scaled(b, -1), r, x * kHalf * aspect), u, y * kHalf)) };
  }
  project(point, aspect) {
    const [r, u, b] = this.frame(), d = minus(point, this.eye(aspect)), w = -dot(b, d);
    return [dot(r, d) / (w * kHalf * aspect), dot(u, d) / (w * kHalf), w];
  }
  // How many units a screen of height 2 shows at a distance w from the eye.
  unitsAt(w) { return w * kHalf; }
  turn(dx, dy) {
    this.yaw -= dx;
    this.pitch = clamp(this.pitch + dy, -Math.PI / 2, Math.PI / 2);
  }
  pan(dx, dy, aspect) {
    const step = this.away(aspect) * kHalf, most = 2 * this.radius;
    this.shift = [clamp(this.shift[0] - dx * step * aspect, -most, most), clamp(this.shift[1] - dy * step, -most, most)];
  }
  zoomBy(factor) { this.zoom = clamp(this.zoom * factor, .3, 40); }
  text() { return [this.yaw, this.pitch, this.zoom, ...this.shift.map((s) => s / this.radius)].map((x) => +x.toFixed(4)).join(","); }
  set(words) {
    const v = words.split(",").map(Number);
    if (v.length !== 5 || !v.every(Number.isFinite)) return;
    [this.yaw, this.pitch, this.zoom] = [v[0], clamp(v[1], -1.5708, 1.5708), clamp(v[2], .3, 40)];
    this.shift = [clamp(v[3], -2, 2) * this.radius, clamp(v[4], -2, 2) * this.radius];
  }
}
