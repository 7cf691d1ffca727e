// SPDX-License-Identifier: MIT
// panel.js: the form beside the surface, and what it says.

const $ = (id) => document.getElementById(id);
const digits = (x, n = 3) => x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(n - 1) : String(+x.toPrecision(n));

class Panel {
  constructor(scene) {
    this.scene = scene;
    this.spoken = 0;
    $("panel").addEventListener("submit", (e) => e.preventDefault());
    for (const id of ["size", "depth"]) $(id).addEventListener("input", () => this.show());
    for (const id of ["look", "wire", "seams", "triangles", "sheet", "detail"]) $(id).addEventListener("change", () => { this.legend(); scene.wake(); });
    $("both").addEventListener("change", () => scene.beside.show());
    for (const id of ["obstacle", "height", "across", "along", "lean"]) $(id).addEventListener("input", () => scene.setObstacle());
    $("solver").addEventListener("change", () => scene.guard(() => scene.solve($("solver").value === "physics")));
    $("undo").addEventListener("click", () => { scene.hand.undo(); this.show(); });
    $("reset").addEventListener("click", () => { $("obstacle").value = "none"; scene.setObstacle(); scene.hand.reset(); if (scene.physics.on) scene.physics.settle(); scene.recorder.clear(); this.show(); });
    $("home").addEventListener("click", () => scene.home());
    $("link").addEventListener("click", () => this.link());
    $("play").addEventListener("click", () => scene.recorder.play());
    $("save").addEventListener("click", () => this.save());
    $("paths").addEventListener("change", () => { const path = scene.paths[$("paths").value]; if (path) scene.openPath(path.text); else scene.recorder.clear(); });
    $("path").addEventListener("change", async (e) => { const file = e.target.files[0]; e.target.value = ""; if (file) scene.openPath(await file.text()); });
    const chosen = (cover) => scene.guard(() => scene.choose(Number($("map").value), cover)).finally(() => scene.listMaps());
    $("map").addEventListener("change", () => chosen(-1));
    $("cover").addEventListener("change", () => chosen(Number($("cover").value)));
    $("fabric").addEventListener("change", () => scene.guard(() => scene.dress(Number($("fabric").value))).then(() => { if (scene.fabric >= 0) $("look").value = "texture", this.show(); }));
    $("up").addEventListener("change", () => { scene.home(); });
  }
  // Layers that have a number a sample; a file has others than a page that was exported.
  listLayers() {
    const look = $("look"), before = look.value;
    while (look.options.length > 4) look.remove(4);
    for (const name of new Set(this.scene.bodies.flatMap((body) => Object.keys(body.layers)))) look.append(new Option(name, name));
    look.value = [...look.options].some((o) => o.value === before) ? before : "texture";
  }
  // Which numbers the colours stand for.
  legend() {
    const layer = $("look").value, { scene } = this, known = scene.bodies.some((body) => body.layers[layer]), box = $("legend");
    box.hidden = !known && layer !== "moved";
    if (box.hidden) return;
    const ends = known ? scene.rangeOf(layer) : [0, scene.diagonal / 10];
    box.className = scene.diverging(layer) ? "diverging" : "";
    box.querySelectorAll("span").forEach((span, k) => { span.textContent = digits(ends[k]); });
  }
  tool() { return document.querySelector("input[name=tool]:checked").value; }
  choose(tool) { document.querySelector("input[name=tool][value=" + tool + "]").checked = true; }
  // From 1/100 to 4/10 of the surface's diagonal, even in ratios.
  size() { return this.scene.diagonal * .01 * 40 ** (Number($("size").value) / 100); }
  depth() { return this.size() * 1.2 * Number($("depth").value) / 100; }
  step(id, by) {
    $(id).value = Number($(id).value) + by;
    this.show();
    this.say((id === "size" ? "Size " : "Depth ") + $(id + "-text").value);
  }
  show() {
    $("size-text").value = digits(this.size());
    $("depth-text").value = digits(this.depth());
    $("height-text").value = (Number($("height").value) / 10).toFixed(0) + " %";
    $("lean-text").value = Math.round(.09 * Number($("lean").value)) + "°";
    $("undo").disabled = !this.scene.hand.done.length;
    $("play").disabled = $("save").disabled = !this.scene.recorder.knots.length;
    this.legend();
    $("look").options[0].disabled = !this.scene.bodies.some((body) => body.picture);
    for (const stroke of this.scene.hand.strokes) stroke.depth = this.depth();
    this.scene.wake();
  }
  options(event) { return { size: this.size(), depth: this.depth(), lasting: $("lasting").checked, invert: $("invert").checked !== Boolean(event && event.ctrlKey) }; }
  say(words) { $("said").textContent = words; }
  fail(error) {
    $("message").hidden = false;
    $("message").textContent = error.message;
    $("message").dataset.code = error.code || "";
  }
  clear() { $("message").hidden = true; }
  readout(hit) {
    if (!hit) return void ($("readout").textContent = "");
    const place = plus(hit.point, hit.body.chart.offset).map((x) => digits(x, 5)), where = hit.row < 2 ** 32 - 1 ? "row " + hit.row + ", column " + hit.column : "border strip";
    const layer = $("look").value, values = hit.body.values(layer), copies = dgm.touch_copies(hit.body.handle, hit.sample);
    const more = (copies ? "\nseam sample with " + copies + " copies" : "") + (values && hit.sample < values.length ? "\n" + layer + " " + this.beyond(layer, values[hit.sample]) + digits(values[hit.sample], 4) : "");
    $("readout").textContent = (this.scene.cover < 0 ? "" : hit.body.map.name + ", ") + "chart " + hit.body.number + ", " + where + "\nplace " + place.join(", ") + "\nnormal " + hit.normal.map((x) => x.toFixed(3)).join(", ") + more;
  }
  // Numbers at the end of a stated scale may be beyond it.
  beyond(layer, value) {
    const scale = this.scene.scale(layer);
    if (!scale) return "";
    return value <= Math.fround(scale.low) && scale.low < 0 ? "at most " : value >= Math.fround(scale.high) ? "at least " : "";
  }
  felt(now) {
    const { felt, strokes } = this.scene.hand, [recent, jumps] = [this.scene.hand.history, this.scene.hand.jumps].map((list) => list.slice(-2000)), leap = jumps.reduce((most, jump) => Math.max(most, jump), 0), pressing = strokes.length > 0;
    if (this.scene.physics.on) $("force").textContent = pressing ? digits(Math.max(...strokes.map((stroke) => stroke.newtons || 0))) + " N" + (this.scene.physics.measured ? "" : ", if the body measures " + 100 * kMetres + " cm") + "\njumps up to " + digits(leap, 2) + " N a step" : "";
    else $("force").textContent = pressing ? (100 * felt.force).toFixed(1) + " % of the limit, jumps up to " + digits(100 * leap, 2) + " % a tick\n" + felt.ticks + " ticks of " + digits(felt.micros, 2) + " µs, " + felt.samples + " samples" : "";
    if (pressing) this.rumble(now, Math.max(felt.force, ...strokes.map((stroke) => (stroke.newtons || 0) / 5)));
    const canvas = $("strip"), c = canvas.getContext("2d", { willReadFrequently: this.scene.soft }), w = canvas.width, h = canvas.height;
    c.clearRect(0, 0, w, h);
    const most = Math.max(.01, ...recent);
    c.strokeStyle = getComputedStyle(document.body).getPropertyValue("--mark");
    c.beginPath();
    recent.forEach((v, k) => c.lineTo((k + 2000 - recent.length) / 2000 * w, h - 3 - v / most * (h - 8)));
    c.stroke();
    // The jumps from tick to tick, at the foot.
    c.fillStyle = "#d9480f";
    jumps.forEach((jump, k) => { if (jump / most > .02) c.fillRect((k + 2000 - jumps.length) / 2000 * w, h - 3, 1, -jump / most * (h - 8)); });
    if (pressing && now - this.spoken > 1000) {
      this.spoken = now;
      this.say((strokes[0].kind === "pull" ? "Pulls, " : "Presses, ") + (this.scene.physics.on ? digits(strokes[0].newtons || 0, 2) + " newtons" : (100 * felt.force).toFixed(0) + " % of the force"));
    }
  }
  // A gamepad that can shake does so with the force.
  rumble(now, force) {
    if (now - (this.shaken || 0) < 50 || !navigator.getGamepads) return;
    this.shaken = now;
    for (const pad of navigator.getGamepads())
      if (pad && pad.vibrationActuator) pad.vibrationActuator.playEffect("dual-rumble", { duration: 80, weakMagnitude: clamp(force, 0, 1), strongMagnitude: clamp(force, 0, 1) ** 2 }).catch(() => {});
  }
  volume(words) { $("volume").textContent = words; }
  link() {
    const { scene } = this, hash = "#view=" + scene.camera.text() + "&tool=" + this.tool() + "&size=" + $("size").value + "&depth=" + $("depth").value + "&look=" + $("look").value + "&map=" + scene.number + (scene.cover < 0 ? "" : "&cover=" + scene.cover) + (scene.fabric < 0 ? "" : "&fabric=" + scene.fabric);
    kOuter.history.replaceState(null, "", hash);
    const done = (words) => this.say(words);
    if (navigator.clipboard) navigator.clipboard.writeText(kOuter.location.href).then(() => done("The link is in the clipboard."), () => done("The link stands in the address bar."));
    else done("The link stands in the address bar.");
  }
  // "#view=YAW,PITCH,ZOOM,X,Y&tool=pull&size=40"
  follow(hash) {
    const words = new URLSearchParams(hash.slice(1));
    if (words.has("view")) this.scene.camera.set(words.get("view"));
    if (["push", "pull", "poke", "turn"].includes(words.get("tool"))) this.choose(words.get("tool"));
    for (const id of ["size", "depth"]) if (words.has(id)) $(id).value = words.get(id);
    if ([...$("look").options].some((o) => o.value === words.get("look"))) $("look").value = words.get("look");
    this.show();
  }
  save() {
    const link = document.createElement("a"), url = URL.createObjectURL(new Blob([this.scene.recorder.text()], { type: "text/plain" }));
    link.href = url, link.download = "path.txt";
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
  }
}
