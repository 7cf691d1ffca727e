// SPDX-License-Identifier: GPL-3.0-or-later
// Source and reconstruction side by side under one camera, in WebGL 2. Data: report/viewer_data.h.
"use strict";
(() => {
  const canvas = document.getElementById("view");
  const data = JSON.parse(document.getElementById("viewer-data").textContent);
  const gl = data.map && canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) {
    canvas.hidden = true;
    canvas.style.display = "none";
    document.querySelector("#viewer .captions").hidden = true;
    document.querySelector("#viewer .tools").hidden = true;
    document.getElementById("no-viewer").hidden = false;
    canvas.dataset.drawn = "none";
    return;
  }

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const decoded = (text, Type) => new Type(bytes(text).buffer);

  const compile = (vertex, fragment) => {
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "position");
    gl.bindAttribLocation(program, 1, "normal");
    gl.bindAttribLocation(program, 2, "place");
    gl.linkProgram(program);
    return program;
  };
  // A pushed line is drawn a little nearer than the surface it lies on.
  const program = compile(`
    in vec3 position; in vec3 normal; in float place;
    uniform mat4 camera; uniform mat3 turn; uniform vec3 centre; uniform float push; uniform vec2 shift;
    out vec3 n; out vec3 seen; out float t;
    void main() {
      n = turn * normal; seen = turn * (position - centre); t = place;
      gl_Position = camera * vec4(position - centre, 1);
      gl_Position.z -= push * gl_Position.w;
      gl_Position.xy += shift * gl_Position.w;
    }`, `
    in vec3 n; in vec3 seen; in float t; out vec4 colour;
    uniform sampler2D table; uniform int mode; uniform vec3 plain;
    void main() {
      if (mode == 2) { colour = vec4(plain, 1); return; }
      vec3 m = normalize(n);
      if (dot(m, cross(dFdx(seen), dFdy(seen))) < 0.) m = -m; // sources are not always wound alike
      float key = max(0., dot(m, normalize(vec3(-.45, .6, .7)))), fill = max(0., dot(m, normalize(vec3(.8, -.1, .4))));
      float light = mode == 1 ? .72 + .28 * key : .38 + .58 * key + .16 * fill;
      vec3 base = mode == 1 ? texture(table, vec2((t * 255. + .5) / 256., .5)).rgb : plain;
      colour = vec4(base * light, 1);
    }`);
  gl.useProgram(program);
  const place = (name) => gl.getUniformLocation(program, name);
  const uniforms = Object.fromEntries(["camera", "turn", "centre", "push", "shift", "table", "mode", "plain"].map((n) => [n, place(n)]));

  const buffer = (target, array) => {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, array, gl.STATIC_DRAW);
    return made;
  };
  const upload = (mesh) => {
    const Index = mesh.wide ? Uint32Array : Uint16Array;
    const out = { type: mesh.wide ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT, parts: {}, places: {} };
    out.array = gl.createVertexArray();
    gl.bindVertexArray(out.array);
    const attribute = (number, text, size, type, Type, normalised) => {
      const made = buffer(gl.ARRAY_BUFFER, decoded(text, Type));
      gl.enableVertexAttribArray(number);
      gl.vertexAttribPointer(number, size, type, normalised, 0, 0);
      return made;
    };
    attribute(0, mesh.position, 3, gl.UNSIGNED_SHORT, Uint16Array, false);
    attribute(1, mesh.normal, 3, gl.BYTE, Int8Array, true);
    for (const name of ["index", "grid", "seams", "borders"])
      if (mesh[name]) {
        const list = decoded(mesh[name], Index);
        out.parts[name] = { buffer: buffer(gl.ELEMENT_ARRAY_BUFFER, list), count: list.length };
      }
    for (const name of ["distance", "area", "angle"])
      if (mesh[name]) out.places[name] = buffer(gl.ARRAY_BUFFER, decoded(mesh[name], Uint8Array));
    return out;
  };
  const source = upload(data.source), map = upload(data.map);
  const tables = {};
  for (const name of ["diverging", "sequential"]) {
    tables[name] = { bytes: bytes(data.tables[name]), texture: gl.createTexture() };
    gl.bindTexture(gl.TEXTURE_2D, tables[name].texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, tables[name].bytes);
    for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, key, value);
  }

  // Everything is measured in steps of the stored positions.
  const size = data.size.map((s) => s / data.step), centre = size.map((s) => s / 2);
  const radius = Math.hypot(...size) / 2 || 1;
  const radians = (degrees) => degrees * Math.PI / 180;
  const start = { yaw: radians(data.view.yaw), pitch: radians(data.view.pitch), zoom: 1.25 };
  let view = { ...start }, waiting = false;

  const frame = () => {
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    return [[cy, 0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]]; // right, up, towards the eye
  };
  const camera = (rows, aspect) => {
    const half = Math.tan(radians(14)), away = 1.04 * radius / Math.sin(radians(14)) / view.zoom / Math.min(1, aspect);
    const near = Math.max(away - 1.1 * radius, radius / 1000), far = away + 1.1 * radius;
    const [r, u, b] = rows, k = (far + near) / (near - far), l = 2 * far * near / (near - far);
    const out = new Float32Array(16);
    for (let c = 0; c < 3; ++c) {
      out[4 * c] = r[c] / (half * aspect);
      out[4 * c + 1] = u[c] / half;
      out[4 * c + 2] = k * b[c];
      out[4 * c + 3] = -b[c];
    }
    out[14] = -k * away + l;
    out[15] = away;
    return out;
  };

  const mode = document.getElementById("mode"), grid = document.getElementById("grid"), seams = document.getElementById("seams");
  const draw = (mesh, part, kind) => {
    if (!mesh.parts[part]) return; // no seams, or no borders
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.parts[part].buffer);
    gl.drawElements(kind, mesh.parts[part].count, mesh.type, 0);
  };
  const lines = (part, colour, width, pixel) => {
    gl.uniform3fv(uniforms.plain, colour);
    const reach = (width - 1) / 2;
    for (let x = -reach; x <= reach; ++x)
      for (let y = -reach; y <= reach; ++y) {
        gl.uniform2f(uniforms.shift, x * pixel[0], y * pixel[1]);
        draw(map, part, gl.LINES);
      }
    gl.uniform2f(uniforms.shift, 0, 0);
  };
  const paint = () => {
    waiting = false;
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.max(2, Math.round(canvas.clientWidth * scale));
    canvas.height = Math.max(2, Math.round(canvas.clientHeight * scale));
    const background = getComputedStyle(canvas).backgroundColor.match(/[\d.]+/g).map(Number);
    gl.clearColor(background[0] / 255, background[1] / 255, background[2] / 255, 1);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const width = Math.floor(canvas.width / 2), rows = frame();
    gl.uniformMatrix4fv(uniforms.camera, false, camera(rows, width / canvas.height));
    gl.uniformMatrix3fv(uniforms.turn, true, rows.flat());
    gl.uniform3fv(uniforms.centre, centre);
    gl.uniform2f(uniforms.shift, 0, 0);
    const kind = mode.value, pixel = [2 / width, 2 / canvas.height];
    [source, map].forEach((mesh, side) => {
      gl.viewport(side * width, 0, width, canvas.height);
      gl.bindVertexArray(mesh.array);
      const coloured = Boolean(mesh.places[kind]); // the source knows its distance only
      gl.uniform1i(uniforms.mode, coloured ? 1 : 0);
      gl.uniform1f(uniforms.push, 0);
      gl.uniform3f(uniforms.plain, .84, .75, .68);
      gl.disableVertexAttribArray(2);
      gl.vertexAttrib1f(2, 0);
      if (coloured) {
        gl.bindTexture(gl.TEXTURE_2D, tables[kind === "angle" ? "sequential" : "diverging"].texture);
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.places[kind]);
        gl.enableVertexAttribArray(2);
        gl.vertexAttribPointer(2, 1, gl.UNSIGNED_BYTE, true, 0, 0);
      }
      draw(mesh, "index", gl.TRIANGLES);
      if (mesh !== map) return;
      gl.uniform1i(uniforms.mode, 2);
      gl.uniform1f(uniforms.push, 4e-4);
      if (grid.checked) lines("grid", [.2, .21, .25], 1, pixel);
      if (seams.checked) lines("borders", [.094, .345, .769], 3, pixel);
      if (seams.checked) lines("seams", [.84, .118, .141], 3, pixel);
    });
    canvas.dataset.drawn = String((source.parts.index.count + map.parts.index.count) / 3);
  };
  const soon = () => {
    if (!waiting) requestAnimationFrame(paint);
    waiting = true;
  };

  const digits = (value) => value === 0 ? "0" : String(Number(value.toPrecision(3)));
  const length = (value) => digits(value) + (data.diagonal > 0 ? " (" + Number((100 * value / data.diagonal).toPrecision(2)) + " %)" : "");
  const legend = () => {
    const box = document.getElementById("legend"), kind = mode.value, s = data.scales;
    box.hidden = kind === "none";
    if (box.hidden) return;
    const picture = box.querySelector("canvas").getContext("2d"), strip = picture.createImageData(256, 1);
    const table = tables[kind === "angle" ? "sequential" : "diverging"].bytes;
    for (let k = 0; k < 256; ++k) strip.data.set([table[3 * k], table[3 * k + 1], table[3 * k + 2], 255], 4 * k);
    picture.putImageData(strip, 0, 0);
    const more = s.worst > s.distance * 1.001 ? ", worst " + length(s.worst) : "";
    const words = {
      distance: ["inside " + length(s.distance), "0", "outside " + length(s.distance) + more],
      area: ["1/" + digits(2 ** s.area) + " of the mean", "mean", digits(2 ** s.area) + " times the surface a cell"],
      angle: ["1: none", digits(2 ** (s.angle / 2)), digits(2 ** s.angle) + ": circles become that long"],
    }[kind];
    box.querySelectorAll("span").forEach((span, k) => { span.textContent = words[k]; });
  };

  const turn = (dx, dy) => {
    view.yaw -= dx;
    view.pitch = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, view.pitch + dy));
    soon();
  };
  const zoom = (factor) => {
    view.zoom = Math.min(40, Math.max(.3, view.zoom * factor));
    soon();
  };
  canvas.addEventListener("pointerdown", (e) => canvas.setPointerCapture(e.pointerId));
  canvas.addEventListener("pointermove", (e) => { if (e.buttons) turn(e.movementX * .008, e.movementY * .008); });
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(-Math.max(-100, Math.min(100, e.deltaY)) * .002)); }, { passive: false });
  canvas.addEventListener("dblclick", () => { view = { ...start }; soon(); });
  canvas.addEventListener("keydown", (e) => {
    const step = { ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1] }[e.key];
    if (step) turn(...step);
    else if (e.key === "+" || e.key === "-") zoom(e.key === "+" ? 1.1 : 1 / 1.1);
    else return;
    e.preventDefault();
  });
  mode.addEventListener("change", () => { legend(); soon(); });
  for (const box of [grid, seams]) box.addEventListener("change", soon);
  new ResizeObserver(soon).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", soon);
  // "#distance" after the page's name opens it in that colour.
  if ([...mode.options].some((option) => "#" + option.value === location.hash)) mode.value = location.hash.slice(1);
  legend();
  paint();
})();
