// SPDX-License-Identifier: MIT
// main.js: the scene: a map's bodies, the camera, and the frame.

const kSwatch = { clay: [.84, .75, .68], seam: [.84, .118, .141], border: [.094, .345, .769], grid: [.2, .21, .25], solid: [.55, .6, .68] };

const kCloth = 24; // rounds of smoothing of a cover that is pressed, as samples/sit_on_cushion has them
const kKept = 1e-3; // of the volume that an obstacle removes: what comes out again may differ by that
const kCalming = 1.2; // seconds in which a pressed pair springs back to a ten millionth

// Where the address is: a page in a frame has none of its own.
const kOuter = document.body.classList.contains("framed") ? parent : window;

class Scene {
  constructor() {
    this.canvas = $("view"), this.over = $("over");
    this.soft = softDrawing();
    this.painter = new Painter(this.canvas, this.soft);
    Object.assign(this, { maps: [], paths: [], assets: [], bodies: [], camera: new Camera(), number: 0, cover: -1, fabric: -1, diagonal: 1, coarse: 0, pace: 24, untried: true, drawing: null, owed: false, stale: true, waiting: false, obstacle: null, calming: 0, last: 0, frames: 0, marked: null });
    this.hand = new Hand(this);
    this.physics = new Physics(this);
    this.recorder = new Recorder(this);
    this.sheet = new Sheet(this);
    this.beside = new Beside(this);
    this.panel = new Panel(this);
    this.keys = new Keys(this, this.canvas);
    this.drop = new Drop(this);
    // A browser may take the card away, and give another one.
    this.canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.guard(() => this.restore()));
    new ResizeObserver(() => this.wake()).observe($("stage"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.wake());
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    kOuter.addEventListener("hashchange", () => this.guard(() => this.visit(false)));
  }
  // What the address names: "#map=1&cover=0&fabric=2", and what the panel reads. What it does not name stays, but that
  // a map comes alone, and a page opens with its first one.
  async visit(opens) {
    const words = new URLSearchParams(kOuter.location.hash.slice(1)), alone = words.has("map");
    const named = (name, otherwise) => (words.has(name) && this.maps[words.get(name)] ? Number(words.get(name)) : otherwise);
    const map = named("map", opens ? 0 : this.number), fabric = named("fabric", alone || opens ? -1 : this.fabric);
    const cover = named("cover", alone ? -1 : opens ? Number(document.body.dataset.cover ?? -1) : this.cover);
    if (this.maps.length && (opens || map !== this.number || cover !== this.cover)) await this.choose(map, cover);
    if (fabric !== this.fabric) await this.guard(() => this.dress(fabric));
    if (opens && document.body.dataset.look) $("look").value = document.body.dataset.look;
    this.panel.follow(kOuter.location.hash);
  }
  // Runs `work`; what goes wrong is said, never thrown.
  async guard(work) {
    try {
      return await work();
    } catch (error) {
      this.panel.fail(error);
    }
  }
  async add(map) {
    this.maps.push(map);
    this.listMaps();
    try {
      await this.choose(this.maps.length - 1);
    } catch (error) {
      this.maps.pop();
      this.listMaps();
      throw error;
    }
  }
  listMaps() {
    const options = () => this.maps.map((map, k) => new Option(map.name, String(k)));
    $("map").replaceChildren(...options()), $("cover").replaceChildren(new Option("none", "-1"), ...options());
    $("map").value = String(this.number), $("cover").value = String(this.cover);
    $("fabric").replaceChildren(new Option("its own", "-1"), ...options().filter((_, k) => this.maps[k].dropped || this.maps[k].pictures.length));
    $("fabric").value = String(this.fabric);
    $("cover-row").hidden = this.maps.length < 2, $("fabric-row").hidden = this.maps.length < 2 || $("fabric").options.length < 2;
  }
  // The bodies of a map, each chart one.
  async open(map, asset, middle, cover) {
    const bodies = [];
    try {
      asset.charts.forEach((_, k) => bodies.push(new Body(this.painter, asset, k, middle, embeddedValues(map, k))));
      for (const body of bodies) {
        Object.assign(body, { map, cover });
        if (this.painter.gl) body.picture = await this.pictureOf(map, body);
      }
      return bodies;
    } catch (error) {
      bodies.forEach((body) => body.close());
      throw error;
    }
  }
  // Shows map `number`, with map `cover` over it if that is another one.
  async choose(number, cover = -1) {
    if (cover === number || !this.maps[cover]) cover = -1;
    const maps = [number, cover].filter((k) => k >= 0).map((k) => this.maps[k]), assets = [], bodies = [];
    let low, high, middle;
    try {
      for (const map of maps) {
        assets.push(new Asset(await map.bytes()));
        if (map.unpack) await map.unpack(), map.unpack = null;
      }
      const boxes = assets.flatMap((asset) => asset.charts.map((chart) => chart.box)), edge = (pick, from) => [0, 1, 2].map((c) => pick(...boxes.map((box) => box[from + c])));
      low = edge(Math.min, 0), high = edge(Math.max, 3), middle = scaled(plus(low, high), .5);
      for (const [k, map] of maps.entries()) bodies.push(...await this.open(map, assets[k], middle, k > 0));
    } catch (error) {
      bodies.forEach((body) => body.close());
      assets.forEach((asset) => asset.close());
      throw error;
    }
    this.recorder.playing = null, $("caption").hidden = true;
    const solid = this.physics.on && cover < 0;
    this.physics.end();
    this.recorder.list(this.paths, this.maps, number);
    this.bodies.forEach((body) => body.close());
    this.assets.forEach((asset) => asset.close());
    Object.assign(this, { assets, bodies, number, cover, fabric: -1, low, high, middle });
    const under = bodies.filter((body) => !body.cover);
    bodies.forEach((body, index) => Object.assign(body, { index, under: body.cover ? under : [] }));
    this.listMaps();
    const map = maps[0];
    this.beside.put(map.source && this.painter.gl ? new Source(this.painter, map.source, middle, map.scales) : null);
    $("facts").textContent = map.facts || "";
    $("drop").hidden = true;
    this.hand.strokes = [], this.hand.done = [], this.hand.history = [], this.hand.jumps = [], this.marked = null;
    this.diagonal = length(minus(high, low)) || 1;
    this.panel.clear();
    this.panel.listLayers();
    if ($("look").value === "texture" && !bodies.some((body) => body.picture)) $("look").value = "clay";
    this.home();
    this.setObstacle();
    await this.guard(() => this.solve(solid)); // a map that cannot have physics is shown, and touched
    this.changed();
  }
  // Touches, or physics where the bodies can have it.
  solve(solid) {
    $("solver").disabled = this.cover >= 0;
    $("solver").value = "touch", $("lasting").disabled = false;
    for (const stroke of [...this.hand.strokes]) this.hand.end(stroke);
    this.recorder.stop();
    if (solid) this.physics.begin();
    else this.physics.end();
    if (solid) $("solver").value = "physics", $("lasting").disabled = true;
    this.changed();
  }
  // Thickness of a cover's cloth: it is drawn as far out, and what is under it is drawn twice as far in.
  get cloth() { return this.cover < 0 ? 0 : .0045 * this.diagonal; }
  // Puts the pictures of another map on what is seen, chart by chart, whatever is done to its shape. -1: its own.
  async dress(fabric) {
    const map = this.maps[fabric], seen = this.bodies.filter((body) => body.cover === (this.cover >= 0)), pictures = [];
    const asset = map && !map.pictures.length ? new Asset(await map.bytes()) : null;
    try {
      for (const { number, chart, map: own } of seen) {
        const other = asset ? asset.charts[number] : { layers: {} }, picture = await this.pictureOf(map || own, { number, chart: map ? other || { layers: {} } : chart });
        if (map && !picture) throw new Error(map.name + " has no picture for chart " + number + ".");
        pictures.push(picture);
      }
      seen.forEach((body, k) => {
        if (body.picture) this.painter.gl.deleteTexture(body.picture.texture);
        body.picture = pictures[k];
      });
      this.fabric = map ? fabric : -1;
      this.panel.clear();
    } finally {
      if (asset) asset.close();
      this.listMaps();
      this.changed();
    }
  }
  // Gives another card what the one before had. Shapes are the runtime's: nothing of them is lost.
  async restore() {
    this.painter.begin();
    this.drawing = null;
    for (const body of this.bodies) {
      Object.assign(body, { parts: {}, layer: null, shown: null, picture: null });
      body.load(body.uv);
    }
    const { source, scales } = this.maps[this.number] || {};
    if (source) this.beside.put(new Source(this.painter, source, this.middle, scales));
    for (const body of this.bodies) body.picture = await this.pictureOf(body.map, body);
    if (this.fabric >= 0) await this.dress(this.fabric);
    this.wake();
  }
  async pictureOf(map, body) {
    const made = map.pictures.find((picture) => picture.chart === body.number), layer = body.chart.layers.texture;
    if (made) return this.painter.picture(await createImageBitmap(made.blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" }));
    if (!layer) return null;
    return this.painter.picture({ width: layer.shape[1], height: layer.shape[0], pixels: new Uint8Array(memory(), layer.data, layer.bytes).slice() });
  }
  openPath(words) { return this.guard(() => { this.recorder.load(words); this.panel.clear(); }); }
  changed() { this.panel.show(); }
  size() { return this.panel.size(); }
  home() {
    this.camera.fit([0, 0, 0], this.diagonal / 2, $("up").checked ? "z" : "y");
    this.wake();
  }
  aspect() { return this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight); }
  pick(at) {
    const flat = this.sheet.pick(at);
    if (flat !== undefined) return flat;
    const ray = this.camera.ray(...at, this.aspect());
    const seen = (hit) => hit.distance - (hit.body.cover ? 3 * this.cloth : 0);
    return this.bodies.map((body) => body.pick(ray)).filter(Boolean).sort((a, b) => seen(a) - seen(b))[0] || null;
  }
  // Axes that the obstacle's sliders mean: up, and two across.
  axes() { return this.camera.up === "z" ? [2, 0, 1] : [1, 0, 2]; }
  // A table from below, or a ball or bar from above, each anywhere; table and bar lean.
  setObstacle() {
    const kind = $("obstacle").value, value = (id) => Number($(id).value) / 1000;
    this.obstacle = null;
    for (const row of document.querySelectorAll(".placed")) row.hidden = kind === "none";
    if (kind !== "none" && this.low) {
      const [up, side, other] = this.axes(), tall = this.high[up] - this.low[up], radius = .16 * this.diagonal, p = [0, 0, 0], q = [0, 0, 0], lean = value("lean") * Math.PI / 2;
      p[side] = value("across") * this.diagonal, p[other] = value("along") * this.diagonal;
      if (kind === "plane") p[up] = this.low[up] - this.middle[up] + .6 * value("height") * tall, q[up] = Math.cos(lean), q[side] = Math.sin(lean);
      else {
        const way = [0, 0, 0];
        if (kind === "capsule") way[side] = .3 * Math.cos(lean) * this.diagonal, way[other] = .3 * Math.sin(lean) * this.diagonal;
        p[up] = this.high[up] - this.middle[up] + radius - .8 * value("height") * tall;
        p.forEach((x, c) => { q[c] = x + way[c], p[c] = x - way[c]; });
      }
      this.obstacle = { kind, p, q, radius };
    }
    if (this.physics.on) this.physics.moving = true;
    else this.meetAgain = true;
    this.panel.show();
  }
  // How far away a ball or bar is under the pointer, or null.
  gripObstacle(at) {
    const o = this.obstacle;
    if (!o || o.kind === "plane") return null;
    const { origin, direction } = this.camera.ray(...at, this.aspect());
    // Balls along the bar: where the ray meets the first of them.
    let nearest = null;
    for (let k = 0; k <= 32; ++k) {
      const to = minus(plus(scaled(o.p, 1 - k / 32), o.q, k / 32), origin), along = dot(to, direction), left = o.radius ** 2 - (dot(to, to) - along ** 2);
      const distance = left >= 0 ? along - Math.sqrt(left) : -1;
      if (distance > 0 && (nearest === null || distance < nearest)) nearest = distance;
      if (o.kind === "ball") break;
    }
    return nearest;
  }
  // Moves it in the plane of the screen, as far as the sliders go.
  dragObstacle(dx, dy, distance) {
    const [right, up] = this.camera.frame(), half = this.camera.unitsAt(distance), way = plus(scaled(right, dx * half * this.aspect()), up, dy * half);
    const [axis, side, other] = this.axes(), add = (id, by) => { $(id).value = Number($(id).value) + 1000 * by; };
    add("height", -way[axis] / (.8 * (this.high[axis] - this.low[axis]) || 1));
    add("across", way[side] / this.diagonal), add("along", way[other] / this.diagonal);
    this.setObstacle();
  }
  // Presses every body against the obstacle, and a cover against what it lies over: from their shapes without elastic
  // touches, or with those of this frame.
  meet(pressed = this.hand.strokes.length > 0) {
    const o = this.obstacle, words = [], { cloth } = this;
    let deep = false;
    for (const body of this.bodies) {
      if (!pressed) dgm.touch_release(body.handle);
      if (o && !deep) {
        // An obstacle lies on the cloth.
        const before = body.copy(), thick = body.cover ? cloth : 2 * cloth, q = o.kind === "plane" ? o.q : minus(o.q, body.origin), p = minus(o.p, body.origin);
        check(dgm.touch_obstacle(body.handle, { plane: 0, ball: 1, capsule: 2 }[o.kind], 0, ...(o.kind === "plane" ? plus(p, unit(o.q), thick) : p), ...q, o.radius + thick, body.cover ? kCloth : 0));
        const [status, samples, removed, gained] = answers(4);
        // Where it goes through, what is left can neither keep the volume nor a shape.
        deep = status === 1 && (Math.abs(gained) > kKept || body.farthest(before) > (o.kind === "plane" ? .6 : .3) * this.diagonal);
        if (deep) dgm.touch_release(body.handle), words.push("too deep: it goes through");
        else if (status === 1) words.push(samples + " samples moved, volume " + digits(dgm.touch_volume(body.handle), 5) + "\nkept to " + digits(Math.abs(gained), 2) + " of " + digits(Math.abs(removed)) + " pressed in");
        if (status === 3) words.push(samples + " samples moved; open, so it has no volume");
      }
      for (const other of body.under) check(dgm.touch_other(body.handle, other.handle, 0, ...minus(other.origin, body.origin), 0));
      dgm.touch_normals(body.handle);
    }
    this.panel.volume(words.join("\n"));
    this.meetAgain = false, this.stale = true;
  }
  // `over`: the surface is as it was, and only what is over it changes.
  wake(over = false) {
    this.stale = this.stale || !over;
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => this.guard(() => this.frame(now)));
  }
  frame(now) {
    this.waiting = false;
    const seconds = clamp((now - (this.running ? this.last : now - 16)) / 1000, 0, .05);
    this.last = now;
    if (this.physics.on) {
      this.running = this.physics.advance(seconds);
      this.paint(now, this.running || this.keys.pointers.size > 0);
      return void (this.running && this.wake());
    }
    const worked = this.hand.advance(seconds), played = this.recorder.advance(seconds), busy = worked || played;
    if (busy && this.cover >= 0) this.calming = kCalming;
    // Beside an obstacle nothing fades: what is let go is pressed anew from where it rests.
    const pressing = busy || this.hand.strokes.length > 0;
    this.meetAgain = this.meetAgain || (this.obstacle !== null && this.pressed && !pressing);
    this.pressed = pressing;
    this.fading = !this.obstacle && !this.hand.strokes.length && !played && this.relax(seconds);
    if (this.meetAgain || ((this.obstacle || this.cover >= 0) && (busy || this.fading))) this.meet(busy || this.fading || this.hand.strokes.length > 0);
    this.running = this.hand.strokes.length > 0 || played || this.fading;
    this.paint(now, this.running || this.keys.pointers.size > 0);
    if (this.running) this.wake();
  }
  // True while shapes spring back. A cover never quite does, where it lies on what is under it: it gets its time.
  relax(seconds) {
    let fading = false;
    if (this.cover >= 0) {
      if (this.calming <= 0) return false;
      this.calming = this.calm.matches ? 0 : this.calming - seconds;
      if (this.calming <= 0) return this.meetAgain = true, false;
    }
    for (const body of this.bodies) {
      if (!dgm.touch_active(body.handle)) continue;
      if (this.calm.matches) dgm.touch_release(body.handle);
      else check(dgm.touch_relax(body.handle, seconds, kBack));
      dgm.touch_normals(body.handle);
      fading = fading || dgm.touch_active(body.handle) > 0;
    }
    return fading;
  }
  paint(now, moving) {
    if (!this.painter.gl) return;
    if (this.stale || moving) {
      if (this.drawing && !(moving && this.drawing.resting)) return void (this.owed = true, this.canvas.dataset.resting = "false");
      this.paintSurface(moving);
    }
    this.drawOver();
    // Words and strip are read, not watched: each time the browser lays out and draws the form anew.
    if (!moving || !(now - this.told < 80)) this.panel.felt(this.told = now);
    const hit = this.keys.hover && !this.hand.strokes.length ? this.pick(this.keys.hover) : null;
    if (this.keys.hover) this.panel.readout(hit);
  }
  paintSurface(moving) {
    this.stale = this.owed = false;
    for (const canvas of [this.canvas, this.over]) {
      const dots = Math.min(2, window.devicePixelRatio || 1), w = Math.max(2, Math.round(canvas.clientWidth * dots)), h = Math.max(2, Math.round(canvas.clientHeight * dots));
      if (canvas.width !== w || canvas.height !== h) canvas.width = w, canvas.height = h;
    }
    const coarse = moving && this.soft ? this.coarse : 0;
    for (const body of this.bodies) body.upload();
    this.draw(2 ** coarse, coarse > 0);
    if (this.soft) this.follow(moving);
    clearTimeout(this.later);
    if (coarse > 0 && !this.running) this.later = setTimeout(() => this.wake(), 300);
    ++this.frames;
    Object.assign(this.canvas.dataset, { frames: this.frames, uploaded: this.painter.uploaded, resting: String(!moving) });
  }
  // Where a processor draws, one picture at a time, and the first that moves behind one that rests: others that wait would be seen
  // too late. Vertices cost most, so what moves is drawn with fewer triangles, as many as the time of the last ones allows, and all
  // of them once it rests. The first picture, which rests, says where to begin.
  follow(moving) {
    const { gl } = this.painter, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), began = performance.now();
    const alone = !this.drawing, mine = this.drawing = { resting: !moving }, look = () => {
      if (this.drawing !== mine) return; // of a card that is gone
      if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return void setTimeout(look, 2);
      gl.deleteSync(fence);
      this.drawing = null;
      const took = performance.now() - began, way = (ms) => (ms > 75 ? 2 : ms > 35 ? 1 : 0);
      if (moving && alone) {
        this.pace += (took > this.pace ? .5 : .1) * (took - this.pace);
        const by = way(this.pace) || (this.pace < 12 ? -1 : 0);
        if (by) this.coarse = clamp(this.coarse + by, 0, 3), this.pace = 24;
      } else if (!moving && this.untried) this.coarse = way(took) + way(took / 4), this.untried = false;
      if (this.owed) this.wake();
    };
    gl.flush();
    setTimeout(look, 2);
  }
  draw(stride, moving) {
    const { painter } = this, gl = painter.gl, background = getComputedStyle(this.canvas).backgroundColor.match(/[\d.]+/g).slice(0, 3).map((x) => x / 255);
    // Not below 33 rows or columns, unless that is asked for.
    const strideOf = ({ chart }) => Math.max(Math.min(stride, 2 ** Math.floor(Math.log2(Math.max(1, (Math.max(chart.rows, chart.cols) - 1) / 32)))), Number($("detail").value));
    const looks = { texture: 1, clay: 0, moved: 2, normal: 3 }, layer = $("look").value, wanted = layer in looks ? looks[layer] : 4;
    const range = wanted === 4 ? this.rangeOf(layer) : [0, 1], coloured = this.diverging(layer) ? 5 : 4;
    const shade = (look) => (look === 4 ? coloured : look), known = this.beside.shown && this.beside.source.layer === layer;
    this.beside.draw(background, { look: known ? shade(4) : 0, plain: kSwatch.clay, range });
    painter.start(this.camera, this.aspect(), background);
    const one = (body) => {
      const look = (wanted === 1 && !body.picture) || (wanted === 4 && !body.show(layer)) ? 0 : wanted, common = { origin: body.origin, plain: kSwatch.clay, puff: (body.cover ? 1 : -2) * this.cloth };
      painter.draw(body.array, body.level(strideOf(body)), gl.TRIANGLES, { ...common, look: shade(look), picture: body.picture || painter.blank, most: this.diagonal / 10, range });
      const line = (name, plain, push) => {
        const part = body.lines(name);
        if (part.count) painter.draw(body.array, part, gl.LINES, { ...common, look: 9, plain, push });
      };
      if ($("triangles").checked && !moving) line("triangles", kSwatch.grid, 2e-4);
      if ($("wire").checked && !moving) line("grid", kSwatch.grid, 3e-4);
      if ($("seams").checked) line("seams", kSwatch.seam, 6e-4), line("borders", kSwatch.border, 6e-4);
    };
    this.bodies.forEach(one);
    if (this.obstacle) painter.drawSolid(this.obstacle.kind, this.obstacle.p, this.obstacle.q, this.obstacle.kind === "plane" ? this.diagonal : this.obstacle.radius, kSwatch.solid);
    if (this.sheet.shown) this.sheet.draw(this.canvas.width / Math.max(1, this.canvas.clientWidth), background, one);
  }
  // The ends of a layer's colours, where the page states them: { low, high, diverging }.
  scale(layer) { return ((this.maps[this.number] || {}).scales || {})[layer]; }
  diverging(layer) { const scale = this.scale(layer); return scale !== undefined && scale.diverging; }
  // Least and largest value of a layer on all bodies.
  rangeOf(layer) {
    if (this.ranged !== layer + this.number) {
      let low = Infinity, high = -Infinity;
      const scale = this.scale(layer);
      if (scale) [low, high] = [scale.low, scale.high];
      else for (const body of this.bodies) for (const v of body.values(layer) || []) low = Math.min(low, v), high = Math.max(high, v);
      Object.assign(this, { ranged: layer + this.number, range: [low, high > low ? high : low + 1] });
      const [dark, light] = this.diverging(layer) ? ["blue", "red"] : ["dark", "light"];
      this.panel.say(layer + ": " + digits(low) + " (" + dark + ") to " + digits(high) + " (" + light + ")");
    }
    return this.range;
  }
  // Pointer, thread between tool and surface, force arrow.
  drawOver() {
    const c = this.over.getContext("2d", { willReadFrequently: this.soft }), w = this.over.width, h = this.over.height, aspect = this.aspect(), scale = w / Math.max(1, this.over.clientWidth);
    c.clearRect(0, 0, w, h);
    const place = (p) => { const [x, y] = this.camera.project(p, aspect); return [(x + 1) / 2 * w, (1 - y) / 2 * h]; };
    const line = (a, b, colour, width) => { c.strokeStyle = colour; c.lineWidth = width * scale; c.beginPath(); c.moveTo(...a); c.lineTo(...b); c.stroke(); };
    const ring = (p, r, colour) => { c.strokeStyle = colour; c.lineWidth = 1.5 * scale; c.beginPath(); c.arc(...p, r, 0, 7); c.stroke(); };
    const ink = getComputedStyle(document.body).getPropertyValue("--mark");
    for (const s of this.hand.strokes) {
      if (!s.holding || s.contact >= this.bodyCount(s)) continue;
      const grip = plus(s.body.place(s.contact), s.body.origin), tool = plus(s.tool, s.body.origin), [a, b] = [place(grip), place(tool)];
      if (Math.hypot(a[0] - b[0], a[1] - b[1]) > 4 * scale) line(a, b, ink, 1.5);
      ring(b, 5 * scale, ink);
      const size = length(s.force);
      if (size > 1e-4) line(a, place(plus(grip, unit(s.force), Math.min(1, Math.sqrt(size)) * .25 * this.diagonal)), "#d9480f", 4);
    }
    const { playing } = this.recorder;
    // The first tool wherever it is, others while they touch.
    for (const [k, tool] of playing ? playing.tools.entries() : []) if (k === 0 || tool.kind !== "away") ring(place(plus(minus(tool.place, playing.body.chart.offset), playing.body.origin)), 7 * scale, ink);
    const around = (p, hit) => {
      const [, , away] = this.camera.project(plus(hit.point, hit.body.origin), aspect), pixels = h / 2 / this.camera.unitsAt(away);
      // The one that is being set, in its own colour.
      if (this.keys.modal && this.keys.modal.id === "depth") ring(p, .5 * this.panel.depth() * pixels, "#d9480f");
      else ring(p, .5 * this.size() * pixels, ink);
    };
    const spot = (hit) => { if (this.sheet.shown) ring(this.sheet.place(hit).map((x) => x * scale), 4 * scale, "#d9480f"); };
    for (const s of this.hand.strokes) if (s.hit) spot(s.hit);
    const hover = this.keys.hover && !this.hand.strokes.length && this.panel.tool() !== "turn" ? this.pick(this.keys.hover) : null;
    if (hover) around(place(plus(hover.point, hover.body.origin)), hover), spot(hover);
    const walker = this.keys.walker;
    if (walker && document.activeElement === this.canvas && this.bodies.includes(walker.body)) {
      const hit = this.keys.walkerHit(), p = place(plus(hit.point, hit.body.origin));
      ring(p, 4 * scale, "#d9480f"), around(p, hit), spot(hit);
    }
  }
  bodyCount(stroke) { return stroke.body.count; }
}

// True where a processor stands in for a graphics card.
function softDrawing() {
  const gl = document.createElement("canvas").getContext("webgl2"), info = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const soft = info ? /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : false;
  if (gl && gl.getExtension("WEBGL_lose_context")) gl.getExtension("WEBGL_lose_context").loseContext();
  return soft;
}

const scriptMaps = () => [...document.querySelectorAll("script.map")].map((element, k) => ({
  name: element.dataset.name, facts: element.dataset.facts,
  bytes: async () => decodeGrids(await inflated(bytesOf(element)), element.dataset.grids),
  pictures: [...document.querySelectorAll("script.picture[data-map='" + k + "']")].map((picture) => ({
    chart: Number(picture.dataset.chart), blob: new Blob([bytesOf(picture)], { type: picture.dataset.type }) })),
  async unpack() {
    const mine = (kind) => [...document.querySelectorAll("script." + kind + "[data-map='" + k + "']")];
    this.values = await Promise.all(mine("values").map(async (v) => ({ name: v.dataset.name, number: Number(v.dataset.chart), codes: await inflated(bytesOf(v)) })));
    this.scales = Object.fromEntries(mine("values").map(({ dataset: d }) => [d.name, { low: Number(d.low), high: Number(d.high), diverging: d.diverging === "1" }]));
    for (const element of mine("source")) this.source = { element, bytes: await inflated(bytesOf(element)) };
  },
}));

const scriptPaths = () => [...document.querySelectorAll("script.path")].map((element) => ({ name: element.dataset.name, text: new TextDecoder().decode(bytesOf(element)) }));

(async () => {
  try {
    await startModule(await inflated(bytesOf($("module"))));
    $("up").checked = document.body.dataset.up === "z";
    const scene = new Scene();
    if (!scene.painter.gl) {
      $("message").hidden = false;
      $("message").textContent = "This browser shows no WebGL 2, so the surface cannot be touched here.";
      const still = document.querySelector("script.still");
      if (still) $("still").src = URL.createObjectURL(new Blob([bytesOf(still)], { type: "image/jpeg" })), $("still").alt = "The surface at rest", $("still").hidden = false;
      $("panel").hidden = true;
      if (window.frameElement) frameElement.style.height = "80px";
      document.body.dataset.ready = "still";
      return;
    }
    const maps = scriptMaps();
    scene.maps = maps;
    scene.paths = scriptPaths();
    if (!maps.length) scene.panel.say("Drop a .dgm here, or open one."), $("drop").hidden = false;
    await scene.visit(true);
    window.dgmPage = scene; // for scripts that drive the page
    requestAnimationFrame(() => { document.body.dataset.ready = "yes"; });
  } catch (error) {
    $("message").hidden = false;
    $("message").textContent = error.message;
    document.body.dataset.ready = "failed";
  }
})();
