// SPDX-License-Identifier: MIT
// keys.js: mouse, fingers, pen and keys.
//
// On the surface a pointer works with the tool, beside it it turns the view. Two pointers beside the surface, or with
// the tool Turn, pan and zoom; two on the surface are two tools. Keys walk over rows and columns.

class Keys {
  constructor(scene, canvas) {
    Object.assign(this, { scene, canvas, pointers: new Map(), hover: null, walker: null, modal: null });
    const on = (name, call, options) => canvas.addEventListener(name, (e) => scene.guard(() => call(e)), options);
    on("pointerdown", (e) => this.down(e));
    on("pointermove", (e) => this.move(e));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) on(name, (e) => this.up(e));
    on("pointerleave", () => { this.hover = null; scene.wake(true); });
    on("contextmenu", (e) => e.preventDefault());
    on("dblclick", (e) => { if (!scene.pick(this.at(e))) scene.home(); });
    on("wheel", (e) => this.wheel(e), { passive: false });
    on("keydown", (e) => this.key(e));
    on("keyup", (e) => { if ((e.key === " " || e.key === "p") && this.walker && this.walker.stroke) this.letGo(); });
    on("focus", () => { if (!this.pointers.size && canvas.matches(":focus-visible")) canvas.dataset.keys = "yes"; });
    on("blur", () => this.letGo());
    addEventListener("blur", () => this.dropAll());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.dropAll(); });
    document.addEventListener("keydown", (e) => scene.guard(() => this.anywhere(e)));
  }
  at(e) {
    const box = this.canvas.getBoundingClientRect();
    return [2 * (e.clientX - box.left) / box.width - 1, 1 - 2 * (e.clientY - box.top) / box.height];
  }
  down(e) {
    if (this.modal) return this.modal = null, this.scene.changed();
    const { scene } = this, at = this.at(e), tool = scene.panel.tool(), left = e.button === 0;
    this.canvas.focus({ preventScroll: true });
    delete this.canvas.dataset.keys;
    if (e.pointerId !== undefined && e.isTrusted) this.canvas.setPointerCapture(e.pointerId);
    this.letGo();
    const pointer = { at, start: this.scene.sheet.pick(at) ? at : null, role: e.button === 1 || (e.button === 2 && e.shiftKey) ? "pan" : "turn", stroke: null };
    const hit = left && tool !== "turn" ? scene.pick(at) : null, grip = left ? scene.gripObstacle(at) : null;
    if (grip !== null && (!hit || grip < hit.distance)) {
      pointer.role = "obstacle", pointer.grip = grip;
      return void this.pointers.set(e.pointerId, pointer);
    }
    if (hit && ![...this.pointers.values()].some((p) => p.role !== "tool")) {
      // Shift slides a poke, and lets a push stay.
      const kind = tool === "push" && e.shiftKey ? "poke" : tool === "poke" && e.shiftKey ? "push" : tool;
      pointer.stroke = scene.hand.begin(hit, kind, scene.panel.options(e));
      if (pointer.stroke) pointer.role = "tool", pointer.hit = hit, this.press(pointer, e);
    }
    this.pointers.set(e.pointerId, pointer);
  }
  // F, as sculptors know it: the pointer's way to the right sets the size, with Shift the depth; a click or Escape ends it.
  begin(id) {
    if (this.hover && this.scene.pick(this.hover)) this.modal = { id, at: this.hover, value: Number($(id).value) };
    else $(id).focus();
  }
  adjust(at) {
    const { id, value } = this.modal;
    $(id).value = value + 100 * (at[0] - this.modal.at[0]);
    this.scene.panel.step(id, 0);
  }
  press(pointer, e) {
    if (e.pointerType === "pen" && e.pressure > 0) pointer.stroke.pressure = clamp(2 * e.pressure, .05, 2);
  }
  move(e) {
    const { scene } = this, at = this.at(e), pointer = this.pointers.get(e.pointerId);
    if (this.modal) return this.adjust(at);
    if (!pointer) {
      this.hover = at;
      return scene.wake(true);
    }
    const dx = at[0] - pointer.at[0], dy = at[1] - pointer.at[1], aspect = scene.aspect();
    const others = [...this.pointers.values()].filter((p) => p !== pointer && p.role !== "tool");
    if (pointer.role === "obstacle") scene.dragObstacle(dx, dy, pointer.grip);
    else if (pointer.role === "tool") this.drag(pointer, at, e);
    else if (others.length) this.pinch(pointer, others[0], at, dx, dy);
    else if (pointer.role === "pan") scene.camera.pan(dx, dy, aspect);
    else scene.camera.turn(dx * 1.6 * aspect, -dy * 1.6);
    pointer.at = at;
    scene.wake();
  }
  drag(pointer, at, e) {
    const { scene } = this, { stroke, hit } = pointer, { camera } = scene, aspect = scene.aspect();
    this.press(pointer, e);
    if (stroke.kind === "pull") {
      // In the plane of the screen through the place that was taken.
      const [right, up] = camera.frame(), grip = plus(hit.point, hit.body.origin), seen = camera.project(grip, aspect), half = camera.unitsAt(seen[2]), from = pointer.start || seen;
      return scene.hand.follow(stroke, { way: plus(scaled(right, (at[0] - from[0]) * half * aspect), up, (at[1] - from[1]) * half) });
    }
    if (stroke.kind === "push") scene.hand.follow(stroke, { hit: scene.pick(at) });
  }
  pinch(pointer, other, at, dx, dy) {
    const { camera } = this.scene, aspect = this.scene.aspect();
    const span = (p) => Math.hypot((p[0] - other.at[0]) * aspect, p[1] - other.at[1]) || 1e-3;
    camera.zoomBy(span(at) / span(pointer.at));
    camera.pan(dx / 2, dy / 2, aspect);
  }
  up(e) {
    const pointer = this.pointers.get(e.pointerId);
    if (!pointer) return;
    this.pointers.delete(e.pointerId);
    if (pointer.stroke) this.scene.hand.end(pointer.stroke);
    this.scene.changed();
  }
  dropAll() {
    for (const id of [...this.pointers.keys()]) this.up({ pointerId: id });
    this.letGo();
  }
  // The page never keeps the wheel from those who did not click into the view.
  wheel(e) {
    if (document.activeElement !== this.canvas) return;
    e.preventDefault();
    const way = clamp(e.deltaY, -100, 100);
    if (this.scene.hand.strokes.length) this.scene.panel.step("depth", way < 0 ? 4 : -4);
    else this.scene.camera.zoomBy(Math.exp(-way * .002));
    this.scene.wake();
  }
  anywhere(e) {
    const { scene } = this, form = e.target.closest && e.target.closest("select");
    if (form || e.altKey || e.metaKey) return;
    if ((e.ctrlKey && e.key === "z")) scene.hand.undo();
    else if (e.ctrlKey) return;
    else if (e.key === "[" || e.key === "]") scene.panel.step("size", e.key === "]" ? 4 : -4);
    else if (e.key === "{" || e.key === "}") scene.panel.step("depth", e.key === "}" ? 4 : -4);
    else if (e.key === "f" || e.key === "F") this.begin(e.key === "f" ? "size" : "depth");
    else if (e.key === "Escape" && this.modal) $(this.modal.id).value = this.modal.value, this.modal = null;
    else if (["1", "2", "3", "4"].includes(e.key)) scene.panel.choose(["push", "pull", "poke", "turn"][e.key - 1]);
    else return;
    e.preventDefault();
    scene.changed();
  }
  key(e) {
    this.canvas.dataset.keys = "yes";
    const { scene } = this, way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (e.ctrlKey || e.altKey || e.metaKey) return;
    if (way && e.shiftKey) scene.camera.turn(.1 * way[0], .1 * way[1]);
    else if (way) this.walk(...way);
    else if (e.key === "+" || e.key === "-") scene.camera.zoomBy(e.key === "+" ? 1.1 : 1 / 1.1);
    else if (e.key === " " || e.key === "p") this.hold(e.key === "p" ? "pull" : scene.panel.tool() === "poke" ? "poke" : "push", e);
    else if (e.key === "Escape") this.letGo();
    else if (e.key === "Home") scene.home();
    else return;
    e.preventDefault();
    scene.wake();
  }
  // Where the keys are: a sample, the middle of the grid at first.
  ensureWalker() {
    if (this.walker && this.scene.bodies.includes(this.walker.body)) return this.walker;
    const body = this.scene.bodies[0];
    if (!body) return null;
    const { rows, cols, layers } = body.chart;
    const mask = layers.mask && new Uint8Array(memory(), layers.mask.data, rows * cols);
    const middle = (rows >> 1) * cols + (cols >> 1);
    let best = middle;
    for (let s = 0; mask && s < mask.length && !mask[best]; ++s) if (mask[s]) best = s;
    this.walker = { body, i: Math.floor(best / cols), j: best % cols, stroke: null };
    return this.walker;
  }
  walk(dx, dy) {
    const w = this.ensureWalker();
    if (!w) return;
    const { rows, cols, layers } = w.body.chart, stride = Math.max(1, Math.round((rows - 1) / 64));
    if (w.stroke && w.stroke.kind === "pull") {
      const [right, up] = this.scene.camera.frame(), step = .1 * this.scene.panel.size();
      w.way = plus(plus(w.way || [0, 0, 0], right, dx * step), up, -dy * step);
      return this.scene.hand.follow(w.stroke, { way: w.way });
    }
    const mask = layers.mask && new Uint8Array(memory(), layers.mask.data, rows * cols);
    let i = w.i + dy * stride, j = w.j + dx * stride;
    if (i < 0 || j < 0 || i >= rows || j >= cols) {
      // Across the seam, if there is one: to the other copy of the border's sample.
      const edge = clamp(i, 0, rows - 1) * cols + clamp(j, 0, cols - 1), count = dgm.touch_copies(w.body.handle, edge);
      const other = answers(Math.min(count, 64)).find((s) => s !== edge && s < rows * cols);
      const to = other === undefined ? edge : other;
      i = Math.floor(to / cols), j = to % cols;
    }
    if (mask && !mask[i * cols + j]) return;
    w.i = i, w.j = j;
    if (w.stroke) this.scene.hand.follow(w.stroke, { hit: this.walkerHit() });
    const place = plus(w.body.place(i * cols + j), w.body.chart.offset);
    this.scene.panel.say("Row " + i + ", column " + j + ", at " + place.map((x) => digits(x, 4)).join(", "));
  }
  // The sample as if a ray had hit a triangle's corner there.
  walkerHit() {
    const w = this.ensureWalker(), { cols, rows } = w.body.chart, sample = w.i * cols + w.j;
    const a = Math.min(w.i, rows - 2), b = Math.min(w.j, cols - 2), corners = [sample, sample, sample];
    // Two other corners of its quad, turned as triangles are, for the normal.
    const ring = [[a, b], [a + 1, b], [a + 1, b + 1], [a, b + 1]].map(([i, j]) => i * cols + j), at = ring.indexOf(sample);
    corners[1] = ring[(at + 1) % 4], corners[2] = ring[(at + 3) % 4];
    return { body: w.body, sample, row: a, column: b, corners, weights: [1, 0, 0], point: w.body.place(sample), normal: w.body.normalAt(sample), front: true };
  }
  hold(kind, e) {
    const w = this.ensureWalker();
    if (!w || e.repeat || w.stroke || this.scene.hand.strokes.length) return;
    w.way = null;
    w.stroke = this.scene.hand.begin(this.walkerHit(), kind, this.scene.panel.options(e));
    w.sticky = kind === "pull";
  }
  letGo() {
    if (!this.walker || !this.walker.stroke) return;
    this.scene.hand.end(this.walker.stroke);
    this.walker.stroke = null;
    this.scene.changed();
  }
}
