// SPDX-License-Identifier: MIT
// tools.js: what presses and pulls. A stroke is one tool from where it begins to where it lets go; up to four at a time.
// Ticks are a millisecond long while the machine keeps up, else longer.

const kKinds = { touch: 0, poke: 1, grasp: 2 };
const kTick = .001, kBack = 14, kBudget = 10; // seconds; 1/s of springing back; ms of a frame for ticks
const kSharp = .25; // of the depth: a push with less room sticks to its place

class Hand {
  constructor(scene) {
    Object.assign(this, { scene, strokes: [], done: [], due: 0, cost: 0, table: dgm.touch_table(kSteps, kSteps * kSteps / 5, 1), history: [], jumps: [], last: null });
    this.felt = { force: 0, ticks: 0, micros: 0, samples: 0 };
  }
  settings(size, lasting) {
    return { mode: lasting ? 1 : 0, d_max: 2 * size, f_max: 1, step: size / kSteps, grasp: size };
  }
  apply(s, dt, relax) {
    dgm.touch_ticking(kGeodesic, s.mode, 0, dt, s.d_max, s.f_max, relax, 0, s.grasp, s.step);
  }
  // `hit` from Body.pick(); kind: push, pull or poke.
  begin(hit, kind, options) {
    if (this.strokes.length === 4 || (this.strokes.length && this.strokes[0].body !== hit.body)) return null;
    const { body } = hit;
    this.scene.recorder.stop();
    const solid = this.scene.physics.on;
    if (!this.strokes.length && solid) body.base = body.copy(), body.facing = body.copy(body.normals), this.log = null;
    else if (!this.strokes.length) {
      // Places are read in the shape without elastic touches: what a press does to the surface never moves the tool.
      for (const each of [...body.under, body]) {
        dgm.touch_release(each.handle);
        dgm.touch_normals(each.handle);
      }
      body.base = body.copy(), body.facing = body.copy(body.normals);
      this.log = { body, settings: this.settings(options.size, options.lasting), ticks: [], knots: [], started: 0 };
    }
    const { point, normal } = body.before(hit), free = [0, 1, 2, 3].find((k) => !this.strokes.some((s) => s.slot === k));
    const outward = options.invert && kind !== "pull";
    const stroke = { body, kind, hit, slot: free, held: 0, depth: options.depth, pressure: 1, outward, mirror: options.invert && kind === "pull",
      runtime: kind === "pull" || outward ? "grasp" : kind === "push" ? "touch" : "poke", start: point, anchor: point, normal, pull: [0, 0, 0], tool: point, most: Infinity };
    if (stroke.runtime === "touch") stroke.most = this.room(stroke);
    if (!solid && stroke.runtime !== "grasp" && !this.meets(stroke)) stroke.runtime = body.under.length ? "poke" : "grasp", stroke.most = Infinity;
    this.strokes.push(stroke);
    if (!solid) this.log.knots.push(this.knot(stroke));
    this.scene.wake();
    return stroke;
  }
  // Follows the pointer: a pull by the way in space, a push to another place of the surface.
  follow(stroke, { hit, way }) {
    if (stroke.kind === "pull" && way) stroke.pull = stroke.mirror ? scaled(way, -1) : way;
    if (stroke.runtime === "touch" && hit && hit.body === stroke.body) {
      const { point, normal } = stroke.body.before(hit);
      stroke.anchor = point, stroke.normal = normal, stroke.hit = hit;
      stroke.most = this.room(stroke);
    }
    this.scene.wake();
  }
  // A push presses what is nearest to the tool: so far in that is what faces as the place does. Four fifths of the ball that touches the
  // surface there from behind, and holds no sample of another side.
  room({ body, anchor, normal }) {
    let most = Infinity;
    this.each(body, anchor, normal, (s, same, square, below) => { if (same < .5 && below > 0) most = Math.min(most, square / (2 * below)); });
    return .8 * most;
  }
  // Whether the runtime's own rule for touches, the sample nearest to the tool and its normal, agrees on the way down. On edges and
  // tips it may not, or press the place itself by less than a third: there a push takes hold of its place.
  meets({ body, anchor, normal, depth, most }) {
    if (most < kSharp * depth) return false;
    const ways = [.1, .3, .6, 1].map((share) => share * Math.min(depth, most)), nearest = ways.map(() => [Infinity, 0]);
    this.each(body, anchor, normal, (s, same, square, below) => ways.forEach((t, k) => {
      const distance = square + t * t - 2 * t * below;
      if (distance < nearest[k][0]) nearest[k] = [distance, s];
    }));
    return ways.every((t, k) => {
      const [square, s] = nearest[k], facing = body.facing.map((array) => array[s]), v = plus(anchor, normal, -t).map((x, c) => x - body.base[c][s]), h = dot(v, facing);
      return h < 0 && dot(facing, normal) > .6 && square - h * h < 4 * (body.step ** 2 + h * h);
    });
  }
  // Calls f(sample, cosine of its normal to `normal`, squared distance from `place`, how far it is below) of the shape before the stroke.
  each(body, [a, b, c], [n, m, l], f) {
    const [x, y, z] = body.base, [u, v, w] = body.facing;
    for (let s = 0; s < body.count; ++s) {
      const dx = a - x[s], dy = b - y[s], dz = c - z[s];
      if (u[s] || v[s] || w[s]) f(s, u[s] * n + v[s] * m + w[s] * l, dx * dx + dy * dy + dz * dz, dx * n + dy * m + dz * l);
    }
  }
  target(stroke) {
    if (stroke.kind === "pull") return plus(stroke.start, stroke.pull);
    const depth = Math.min(stroke.depth * stroke.pressure, stroke.most) * (1 - Math.exp(-stroke.held / .25));
    return plus(stroke.anchor, stroke.normal, stroke.outward ? depth : -depth);
  }
  end(stroke) {
    if (!this.strokes.includes(stroke)) return;
    this.strokes.splice(this.strokes.indexOf(stroke), 1);
    if (this.log) this.log.knots.push({ ...this.knot(stroke), seconds: this.log.started + kTick, kind: "away" });
    if (!this.strokes.length) this.finish();
    this.scene.wake();
  }
  finish() {
    const { log } = this;
    this.last = null;
    this.felt = { force: 0, ticks: 0, micros: 0, samples: 0 };
    if (!log) return;
    this.lift(log.body);
    if (log.settings.mode === 1 && log.ticks.length) this.done.push(log);
    this.scene.recorder.add(log);
    this.log = null;
  }
  lift(body) { this.run(body, this.settings(1, false), { kinds: Array(4).fill([0, 1]), places: new Float32Array(12), count: 1, dt: kTick }, -1); }
  // Runs the ticks of `seconds`. True if anything moved.
  advance(seconds) {
    if (!this.strokes.length || !this.log) return false;
    this.due += seconds;
    const most = this.cost > 0 ? Math.max(1, Math.floor(kBudget / this.cost)) : 50;
    const wanted = Math.floor(this.due / kTick + 1e-6), count = Math.min(wanted, most, 250);
    if (count === 0) return false;
    const dt = count === wanted ? kTick : wanted * kTick / count, { log } = this;
    this.due -= wanted * kTick;
    const tools = 1 + Math.max(...this.strokes.map((s) => s.slot)), places = new Float32Array(3 * count * tools);
    for (const stroke of this.strokes) {
      const from = stroke.tool;
      stroke.held += wanted * kTick;
      const to = this.target(stroke).map(Math.fround);
      for (let t = 0; t < count; ++t)
        for (let c = 0; c < 3; ++c) places[3 * (t * tools + stroke.slot) + c] = from[c] + (t + 1) / count * (to[c] - from[c]);
      stroke.tool = to;
    }
    const kinds = Array.from({ length: tools }, (_, k) => this.strokes.find((s) => s.slot === k)).map((s) => s ? [kKinds[s.runtime], 0] : [0, 1]);
    const batch = { kinds, places, count, dt };
    log.ticks.push(batch);
    const before = performance.now();
    this.run(log.body, log.settings, batch, this.scene.obstacle || log.body.under.length ? 0 : kBack);
    const spent = (performance.now() - before) / count;
    this.cost = this.cost > 0 ? .7 * this.cost + .3 * spent : spent;
    this.read(log, batch, count * dt);
    return true;
  }
  // One batch, as it was recorded. What lies under a cover is pressed through it by the same tools, and not taken hold of.
  run(body, settings, batch, relax) {
    const { kinds, places } = batch;
    for (const other of body.under) {
      const way = minus(body.origin, other.origin);
      this.tick(other, settings, { ...batch, kinds: kinds.map(([kind, lifted]) => (kind === kKinds.grasp ? [0, 1] : [kind, lifted])), places: places.map((p, k) => p + way[k % 3]) }, relax);
    }
    this.tick(body, settings, batch, relax);
  }
  tick(body, settings, { kinds, places, count, dt }, relax) {
    kinds.forEach(([kind, lifted], k) => dgm.touch_tool(k, kind, lifted));
    this.apply(settings, dt, relax);
    new Float32Array(memory(), dgm.touch_places(), places.length).set(places);
    check(dgm.touch_ticks(body.handle, this.table, count, kinds.length));
  }
  read(log, { kinds, count }, seconds) {
    const a = answers(3 + 10 * kinds.length), forces = floats(dgm.touch_forces(), 3 * count * kinds.length);
    for (let t = 0; t < count; ++t) {
      let most = 0;
      for (let k = 0; k < kinds.length; ++k) {
        const f = forces.subarray(3 * (t * kinds.length + k));
        most = Math.max(most, Math.hypot(f[0], f[1], f[2]));
      }
      this.note(most);
    }
    for (const stroke of this.strokes) {
      const out = a.slice(3 + 10 * stroke.slot, 13 + 10 * stroke.slot);
      stroke.holding = out[2] === 1, stroke.contact = out[3], stroke.moved = out.slice(4, 7), stroke.force = out.slice(7, 10);
    }
    log.started += seconds;
    log.knots.push(...this.strokes.map((stroke) => this.knot(stroke)));
    this.felt = { force: this.history.at(-1), ticks: count, micros: 1000 * this.cost, samples: a[1] };
  }
  // A tick's force, and its jump from the tick before of the same stroke; `times` milliseconds of it.
  note(force, times = 1) {
    const jump = this.last === null ? 0 : Math.abs(force - this.last);
    this.last = force;
    for (let t = 0; t < times; ++t) this.history.push(force), this.jumps.push(t === 0 ? jump : 0);
    if (this.history.length > 3000) for (const list of [this.history, this.jumps]) list.splice(0, list.length - 2000);
  }
  knot(stroke) { return { seconds: this.log.started, place: plus(stroke.tool, stroke.body.chart.offset), kind: stroke.runtime, tool: stroke.slot }; }
  // The last stroke that stayed is taken back: the others run again from the shape at rest, to the same bits.
  undo() {
    const last = this.strokes.length ? null : this.done.pop();
    if (!last) return;
    const moved = [last.body, ...last.body.under];
    // A cover and what is under it are done again together.
    const again = this.scene.bodies.filter((body) => moved.includes(body) || moved.some((other) => body.under.includes(other) || other.under.includes(body)));
    for (const body of again) dgm.touch_reset(body.handle);
    for (const log of this.done)
      if (again.includes(log.body)) {
        for (const batch of log.ticks) this.run(log.body, log.settings, batch, 0);
        this.lift(log.body);
      }
    for (const body of again) {
      dgm.touch_release(body.handle);
      dgm.touch_normals(body.handle);
    }
    this.scene.meetAgain = true;
    this.scene.wake();
  }
  reset() {
    for (const stroke of [...this.strokes]) this.end(stroke);
    this.done = [];
    for (const body of this.scene.bodies) {
      this.lift(body); // a path may end with a grasp
      dgm.touch_reset(body.handle);
      dgm.touch_normals(body.handle);
    }
    this.scene.meetAgain = true;
    this.scene.wake();
  }
}
