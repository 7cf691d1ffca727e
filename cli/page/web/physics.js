// SPDX-License-Identifier: MIT
// physics.js: bodies with mass and material instead of touches of eq. 7: libdgm's implicit steps, docs/physics.md.

const kMetres = .15; // diagonal that a body is taken to have whose file has no unit
const kStep = 1 / 60, kCycles = 4; // seconds of a step; iterations
const kStepBudget = 12; // ms of a frame for steps; slower bodies move slower
const kStill = 1e-6; // of the largest energy: what moves less stands still

class Physics {
  constructor(scene) { Object.assign(this, { scene, handles: [], due: 0, moving: false, most: 0, cost: 0 }); }
  get on() { return this.handles.length > 0; }
  // Gives all bodies mass, or says why one cannot have it.
  begin() {
    this.end();
    this.measured = true;
    const { scene } = this;
    for (const body of scene.bodies) {
      // The unit and material of the file, or else ours.
      let handle = dgm.touch_physics(body.handle, 0, kStep, 0, 0, 0);
      if (!handle && !body.chart.layers.material) handle = dgm.touch_physics(body.handle, kMetres / scene.diagonal, kStep, 0, 0, 0), this.measured = false;
      if (!handle) {
        const error = new RuntimeError();
        this.end();
        throw error;
      }
      this.handles.push(handle);
    }
    scene.hand.reset();
    this.moving = scene.obstacle !== null;
  }
  end() {
    this.handles.forEach((handle) => dgm.touch_physics_free(handle));
    Object.assign(this, { handles: [], moving: false, most: 0, due: 0, cost: 0 });
    for (const body of this.scene.bodies) dgm.touch_release(body.handle), dgm.touch_normals(body.handle);
    this.scene.meetAgain = true;
  }
  // Runs the steps of `seconds`. True while something moves.
  advance(seconds) {
    const { strokes } = this.scene.hand;
    if (!strokes.length && !this.moving) return false;
    this.due = Math.min(this.due + seconds, .1);
    const began = performance.now();
    let steps = 0, energy = [0, 0];
    for (; this.due >= kStep && (steps === 0 || performance.now() - began < kStepBudget); this.due -= kStep, ++steps) energy = this.step();
    if (this.due >= kStep) this.due = 0;
    if (steps === 0) return true;
    const spent = (performance.now() - began) / steps, [kinetic, elastic] = energy;
    this.cost = this.cost > 0 ? .8 * this.cost + .2 * spent : spent;
    this.most = Math.max(this.most, kinetic + elastic);
    this.moving = strokes.length > 0 || kinetic > kStill * this.most || (!this.scene.obstacle && elastic > kStill * this.most);
    for (const body of this.scene.bodies) dgm.touch_normals(body.handle);
    if (!this.moving && !this.scene.obstacle) this.settle();
    return this.moving;
  }
  // What hardly moves is at rest, to the bit.
  settle() {
    this.handles.forEach((handle) => dgm.touch_physics_reset(handle));
    for (const body of this.scene.bodies) dgm.touch_release(body.handle), dgm.touch_normals(body.handle);
    this.most = 0;
  }
  // Energies, kinetic and elastic.
  step() {
    const { scene } = this, { strokes } = scene.hand, o = scene.obstacle, energy = [0, 0], words = [], radius = .3 * scene.size();
    scene.bodies.forEach((body, k) => {
      const mine = strokes.filter((stroke) => stroke.body === body), count = mine.length ? 1 + Math.max(...mine.map((stroke) => stroke.slot)) : 0;
      const places = new Float32Array(memory(), dgm.touch_places(), 3 * count).fill(0);
      for (let t = 0; t < count; ++t) {
        const stroke = mine.find((s) => s.slot === t);
        dgm.touch_tool(t, stroke ? kKinds[stroke.runtime] : 0, stroke ? 0 : 1);
        if (!stroke) continue;
        stroke.held += kStep;
        const at = scene.hand.target(stroke);
        // A ball touches the surface where it begins; what is held is held at its place.
        stroke.tool = stroke.runtime === "grasp" ? at : plus(at, stroke.normal, radius);
        places.set(stroke.tool, 3 * t);
      }
      const plane = o && o.kind === "plane", p = o ? minus(o.p, body.origin) : [0, 0, 0], q = plane ? o.q : o ? minus(o.q, body.origin) : [0, 0, 0];
      check(dgm.touch_step(body.handle, this.handles[k], kCycles, count, radius, o ? { plane: 0, ball: 1, capsule: 2 }[o.kind] : 9, ...p, ...q, o ? o.radius : 0));
      const a = answers(6 + 4 * count);
      energy[0] += a[3], energy[1] += a[4];
      words.push((a[1] ? "too fast: it stands still\n" : "") + "volume kept to " + digits(Math.abs(a[5]), 2) + ", " + digits(this.cost, 2) + " ms a step");
      for (const stroke of mine) {
        const [contacts, ...force] = a.slice(6 + 4 * stroke.slot, 10 + 4 * stroke.slot);
        Object.assign(stroke, { holding: contacts > 0, contact: stroke.hit.sample, moved: minus(body.place(stroke.hit.sample), body.base.map((array) => array[stroke.hit.sample])), force: scaled(force, .2), newtons: length(force) });
      }
    });
    // The strip has a place a millisecond.
    if (strokes.length) scene.hand.note(Math.max(...strokes.map((stroke) => stroke.newtons)), Math.round(1000 * kStep));
    scene.panel.volume(words.join("\n"));
    return energy;
  }
}
