// SPDX-License-Identifier: MIT
// draw.js: surfaces, lines and solids in WebGL 2. Positions and normals are uploaded as the runtime has them: an array
// a coordinate.

const kSurfaceVertex = `
  in float x; in float y; in float z; in float nx; in float ny; in float nz; in vec2 uv; in float x0; in float y0; in float z0; in float value;
  uniform mat4 camera; uniform vec3 origin; uniform float push; uniform float puff; uniform vec4 sheet;
  out vec3 n; out vec2 at; out float moved; out float number;
  void main() {
    n = vec3(nx, ny, nz); at = uv; number = value; moved = length(vec3(x, y, z) - vec3(x0, y0, z0));
    gl_Position = sheet.z > 0. ? vec4(sheet.xy + uv * vec2(sheet.z, -sheet.w), 0, 1) : camera * vec4(vec3(x, y, z) + origin + puff * n, 1);
    gl_Position.z -= push * gl_Position.w;
  }`;
const kSurfaceFragment = `
  in vec3 n; in vec2 at; in float moved; in float number; out vec4 colour;
  uniform sampler2D picture; uniform vec2 texels; uniform int look; uniform vec3 plain; uniform vec3 right; uniform vec3 up; uniform vec3 back; uniform float most; uniform vec2 range; uniform vec4 sheet;
  vec3 heat(float t) { // viridis, straight between five of its colours
    vec3 c = mix(vec3(.267, .005, .329), vec3(.229, .322, .546), clamp(4. * t, 0., 1.));
    c = mix(c, vec3(.128, .567, .551), clamp(4. * t - 1., 0., 1.));
    c = mix(c, vec3(.369, .789, .383), clamp(4. * t - 2., 0., 1.));
    return mix(c, vec3(.993, .906, .144), clamp(4. * t - 3., 0., 1.));
  }
  vec3 sides(float t) { // blue, pale, red
    vec3 c = mix(vec3(0., .349, .686), vec3(.486, .659, .878), clamp(4. * t, 0., 1.));
    c = mix(c, vec3(.961, .957, .957), clamp(4. * t - 1., 0., 1.));
    c = mix(c, vec3(.855, .557, .518), clamp(4. * t - 2., 0., 1.));
    return mix(c, vec3(.675, .016, .047), clamp(4. * t - 3., 0., 1.));
  }
  void main() {
    if (look == 9) { colour = vec4(plain, 1); return; }
    vec3 m = normalize(n) * (gl_FrontFacing || sheet.z > 0. ? 1. : -1.);
    vec3 e = vec3(dot(m, right), dot(m, up), dot(m, back));
    float key = max(0., dot(e, normalize(vec3(-.45, .6, .7)))), fill = max(0., dot(e, normalize(vec3(.8, -.1, .4))));
    float gloss = pow(max(0., dot(e, normalize(vec3(-.25, .35, 1.)))), 40.);
    float light = .34 + .6 * key + .18 * fill;
    vec3 base = plain;
    if (look == 1) base = texture(picture, (at * (texels - 1.) + .5) / texels).rgb;
    if (look == 2) { base = heat(clamp(moved / most, 0., 1.)); light = .7 + .3 * key; }
    float share = clamp((number - range.x) / (range.y - range.x), 0., 1.);
    if (look == 4) { base = heat(share); light = .7 + .3 * key; }
    if (look == 5) { base = sides(share); light = .7 + .3 * key; }
    if (look == 3) { base = .5 + .5 * normalize(n); light = 1.; gloss = 0.; }
    colour = vec4(base * light + .1 * gloss, 1);
  }`;

class Painter {
  constructor(canvas, soft) {
    this.gl = canvas.getContext("webgl2", { antialias: !soft, alpha: false });
    if (!this.gl) return;
    this.canvas = canvas;
    this.uploaded = 0; // bytes
    this.begin();
  }
  // What every picture needs.
  begin() {
    const { gl } = this;
    this.program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, kSurfaceVertex], [gl.FRAGMENT_SHADER, kSurfaceFragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    ["x", "y", "z", "nx", "ny", "nz", "uv", "x0", "y0", "z0", "value"].forEach((name, k) => gl.bindAttribLocation(this.program, k, name));
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(this.program));
    gl.useProgram(this.program);
    this.uniforms = {};
    for (const name of ["camera", "origin", "push", "puff", "texels", "look", "plain", "right", "up", "back", "most", "range", "sheet"])
      this.uniforms[name] = gl.getUniformLocation(this.program, name);
    this.blank = this.picture({ width: 1, height: 1, pixels: new Uint8Array([210, 190, 175, 255]) });
    this.solids = { ball: this.solid(ballMesh(32, 24, 0)), capsule: this.solid(ballMesh(32, 24, 1)), plane: this.solid(planeMesh()) };
  }
  buffer(target, data, use) {
    const gl = this.gl, made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, use || gl.STATIC_DRAW);
    this.uploaded += data.byteLength;
    return made;
  }
  // An array of attribute `k` for the vertex array that is bound.
  attribute(k, size, data, use) {
    const gl = this.gl, made = this.buffer(gl.ARRAY_BUFFER, data, use);
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, size, gl.FLOAT, false, 0, 0);
    return made;
  }
  indices(data) {
    this.gl.bindVertexArray(null);
    return { buffer: this.buffer(this.gl.ELEMENT_ARRAY_BUFFER, data), count: data.length };
  }
  picture(source) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    if (source.pixels) gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, source.width, source.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, source.pixels);
    else gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, source);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    for (const key of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, key, gl.CLAMP_TO_EDGE);
    return { texture, width: source.width, height: source.height };
  }
  solid(mesh) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffers = mesh.columns.map((column, k) => this.attribute(k, 1, column, gl.DYNAMIC_DRAW));
    const index = this.indices(mesh.index);
    return { array, buffers, index, mesh };
  }
  start(camera, aspect, background) {
    const gl = this.gl, u = this.uniforms, [right, up, back] = camera.frame();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(u.camera, false, camera.matrix(aspect));
    gl.uniform3fv(u.right, right), gl.uniform3fv(u.up, up), gl.uniform3fv(u.back, back);
  }
  draw(array, part, kind, { look, plain, origin = [0, 0, 0], push = 0, puff = 0, picture = this.blank, most = 1, range = [0, 1] }) {
    const gl = this.gl, u = this.uniforms;
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.buffer);
    gl.bindTexture(gl.TEXTURE_2D, picture.texture);
    gl.uniform2f(u.texels, picture.width, picture.height);
    gl.uniform1i(u.look, look), gl.uniform3fv(u.plain, plain), gl.uniform3fv(u.origin, origin);
    gl.uniform1f(u.push, push), gl.uniform1f(u.puff, puff), gl.uniform1f(u.most, most), gl.uniform2fv(u.range, range);
    gl.drawElements(kind, part.count, gl.UNSIGNED_INT, 0);
  }
  // A ball or bar between `p` and `q`, or a plane through `p` across `q` of half width `radius`.
  drawSolid(kind, p, q, radius, plain) {
    const gl = this.gl, solid = this.solids[kind], { columns, unit: shape } = solid.mesh, count = columns[0].length;
    const along = unit(kind === "plane" ? q : kind === "ball" ? [0, 0, 1] : minus(q, p));
    const side = unit(cross(along, Math.abs(along[0]) < .7 ? [1, 0, 0] : [0, 1, 0])), other = cross(along, side);
    for (let k = 0; k < count; ++k) {
      const [a, b, c, end] = shape.subarray(4 * k, 4 * k + 4), flat = kind === "plane";
      const foot = end > 0 && kind === "capsule" ? q : p;
      for (let d = 0; d < 3; ++d) {
        const way = a * side[d] + b * other[d] + c * along[d];
        columns[d][k] = foot[d] + radius * way;
        columns[3 + d][k] = flat ? along[d] : way;
      }
    }
    for (let d = 0; d < 6; ++d) {
      gl.bindBuffer(gl.ARRAY_BUFFER, solid.buffers[d]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, columns[d]);
    }
    this.draw(solid.array, solid.index, gl.TRIANGLES, { look: 0, plain });
  }
}

// Unit shapes: a, b across and c along an axis, and the end (0 or 1) that a point belongs to.
function ballMesh(around, up) {
  const shape = [], index = [], ring = around + 1;
  for (let i = 0; i <= up + 1; ++i) {
    const end = i > up / 2 ? 1 : 0, t = Math.PI * ((i - end) / up - .5); // the equator twice: a bar's two ends
    for (let j = 0; j <= around; ++j) {
      const s = 2 * Math.PI * j / around;
      shape.push(Math.cos(t) * Math.cos(s), Math.cos(t) * Math.sin(s), Math.sin(t), end);
      if (i > 0 && j > 0) {
        const k = i * ring + j;
        index.push(k - ring - 1, k - ring, k, k - ring - 1, k, k - 1);
      }
    }
  }
  return columnsOf(shape, index);
}
function planeMesh() {
  return columnsOf([-1, -1, 0, 0, 1, -1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0], [0, 1, 2, 0, 2, 3]);
}
function columnsOf(shape, index) {
  const columns = Array.from({ length: 6 }, () => new Float32Array(shape.length / 4));
  return { columns, unit: new Float32Array(shape), index: new Uint32Array(index) };
}
