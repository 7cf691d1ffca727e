// SPDX-License-Identifier: MIT
// recorder.js: strokes as paths, "SECONDS X Y Z KIND[:TOOL] [CAPTION]" in the mesh's frame, as samples/paths has them.

const parsePath = (words) => {
  const knots = [], last = [];
  words.split("\n").forEach((line, k) => {
    if (/^\s*(#|$)/.test(line)) return;
    const [seconds, x, y, z, word, ...caption] = line.trim().split(/\s+/), numbers = [seconds, x, y, z].map(Number);
    const fail = (what) => { throw new Error("Line " + (k + 1) + ": " + what + "."); };
    const [, kind, number] = /^(touch|poke|grasp|away)(?::([1-4]))?$/.exec(word) || [], tool = (number || 1) - 1;
    if (numbers.some((n) => !Number.isFinite(n)) || !kind) fail("a line is SECONDS X Y Z touch|poke|grasp|away, for a second tool touch:2 and so on");
    if (numbers[0] <= last[tool]) fail("times of a tool must increase");
    if (knots.length && numbers[0] < knots.at(-1).seconds) fail("times must not go back");
    last[tool] = numbers[0];
    knots.push({ seconds: numbers[0], place: numbers.slice(1), kind, tool, caption: caption.join(" ") });
  });
  if (!knots.length) throw new Error("The path is empty.");
  return knots;
};
// In the order of time, and each tool's times a millisecond apart: a finger may come back at once.
const inOrder = (knots) => {
  const last = [];
  return knots.map((knot) => ({ ...knot, seconds: last[knot.tool] = Math.max(knot.seconds, (last[knot.tool] ?? -1) + kTick) })).sort((a, b) => a.seconds - b.seconds);
};
// The knots of each tool.
const tracksOf = (knots) => {
  const tracks = [];
  for (const knot of knots) (tracks[knot.tool] ||= []).push(knot);
  return Array.from(tracks, (track) => track || []);
};

// Where a tool is: straight and even between knots, in single precision as the samples have it.
const f = Math.fround;
const toolAt = (track, seconds) => {
  let low = 0, high = track.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (track[middle].seconds > seconds) high = middle; else low = middle + 1;
  }
  const [from, to] = [track[low - 1], track[low]];
  if (!from) return { kind: "away", place: to ? to.place.map(f) : [0, 0, 0] };
  if (!to) return { kind: from.kind, place: from.place.map(f) };
  const t = f((seconds - from.seconds) / (to.seconds - from.seconds));
  return { kind: from.kind, place: from.place.map((p, c) => f(f(p) + f(t * f(f(to.place[c]) - f(p))))) };
};

const kPause = 1.2; // seconds that a caption is read

class Recorder {
  constructor(scene) { Object.assign(this, { scene, knots: [], size: 0, playing: null }); }
  add(log) {
    if (!log.ticks.length) return;
    log.knots.findLast((knot) => knot.kind !== "away").caption = $("words").value.trim().replace(/\s+/g, " ");
    $("words").value = "";
    const s = this.settings, other = s && (s.step !== log.settings.step || s.mode !== log.settings.mode);
    if (this.loaded || other) this.clear();
    if (other) this.scene.panel.say("A path has one size: it begins anew.");
    const start = this.knots.length ? this.knots.at(-1).seconds + .2 : 0;
    this.knots.push(...inOrder(log.knots).map((knot) => ({ ...knot, seconds: start + knot.seconds })));
    this.settings = log.settings;
    this.scene.changed();
  }
  clear() { this.knots = [], this.settings = null, this.loaded = false, $("paths").value = "", this.scene.changed(); }
  text() {
    const s = this.settings, words = (x) => String(+x.toPrecision(9));
    return "# Recorded by touch. Size " + words(s.step * kSteps) + ", d_max " + words(s.d_max) + (s.mode ? ", it stays" : "") + ".\n# seconds x y z what\n" +
      this.knots.map((k) => [k.seconds.toFixed(3), ...k.place.map(words), k.kind + (k.tool ? ":" + (k.tool + 1) : ""), k.caption || ""].join(" ").trimEnd()).join("\n") + "\n";
  }
  load(words) {
    this.stop();
    this.knots = parsePath(words);
    this.loaded = true;
    // As formats/path reads it; paths without it are played with the size of the panel.
    const own = /^\s*#.*?Size (\S+?), d_max ([^\s,]+)(.*)/m.exec(words), [size, most] = own ? [parseFloat(own[1]), parseFloat(own[2])] : [0, 0];
    this.settings = size > 0 && most > 0 ? { ...this.scene.hand.settings(size, own[3].includes(", it stays")), d_max: most } : null;
    this.scene.changed();
  }
  // All of a path at once, a tick a millisecond, as the samples run it.
  replay(body, knots, settings) {
    const start = knots[0].seconds, end = knots.at(-1).seconds, tracks = tracksOf(knots);
    for (let step = 0; ; ++step) {
      this.tick(body, tracks.map((track) => toolAt(track, start + step * kTick)), settings);
      if (end <= start + step * kTick + kTick / 2) break;
    }
  }
  // The largest force that a tool feels.
  tick(body, tools, settings) {
    const places = tools.flatMap(({ place }) => place.map((p, c) => f(p - f(body.chart.offset[c]))));
    this.scene.hand.run(body, settings, { kinds: tools.map(({ kind }) => (kind === "away" ? [0, 1] : [kKinds[kind], 0])), places, count: 1, dt: kTick }, settings.relax || 0);
    const felt = answers(3 + 10 * tools.length);
    return Math.max(...tools.map((_, k) => Math.hypot(...felt.slice(10 * k + 10, 10 * k + 13))));
  }
  play() {
    if (this.scene.physics.on) this.scene.solve(false); // recorded strokes are touches
    this.stop();
    const body = this.nearest();
    if (!body) return;
    this.playing = { body, knots: this.knots, tracks: tracksOf(this.knots), tools: [], at: 0, steps: 0, next: 0, pause: 0, settings: this.settings || this.scene.hand.settings(this.scene.size(), false) };
    dgm.touch_release(body.handle);
    this.scene.wake();
  }
  stop() {
    if (this.playing) this.scene.hand.lift(this.playing.body), this.scene.hand.last = null;
    this.playing = null;
    $("caption").hidden = true;
  }
  // The body whose box the path is closest to.
  nearest() {
    const gap = (body) => this.knots.reduce((sum, { place }) => sum + Math.hypot(...place.map((p, c) => Math.max(body.chart.box[c] - p, p - body.chart.box[3 + c], 0))), 0);
    return [...this.scene.bodies].sort((a, b) => gap(a) - gap(b))[0];
  }
  // Goes on playing. True while there is something left.
  advance(seconds) {
    const p = this.playing;
    if (!p) return false;
    if (p.pause > 0) {
      p.pause -= seconds;
      return true;
    }
    p.at += seconds;
    const start = p.knots[0].seconds, end = p.knots.at(-1).seconds, began = performance.now();
    const more = () => p.steps === 0 || end > start + (p.steps - 1) * kTick + kTick / 2; // as replay()
    for (; p.steps * kTick <= p.at && more() && p.pause <= 0 && performance.now() - began < 30; ++p.steps) {
      p.tools = p.tracks.map((track) => toolAt(track, start + p.steps * kTick));
      this.scene.hand.note(this.tick(p.body, p.tools, p.settings));
      for (; p.next < p.knots.length && p.knots[p.next].seconds <= start + p.steps * kTick + kTick / 2; ++p.next)
        if (p.knots[p.next].caption) this.say(p, p.knots[p.next].caption);
    }
    p.at = Math.min(p.at, p.steps * kTick); // a machine that cannot keep up plays slower
    if (!more() && p.pause <= 0) this.stop();
    return true;
  }
  say(playing, words) {
    playing.pause = kPause;
    $("caption").textContent = words, $("caption").hidden = false;
    this.scene.panel.say(words);
  }
  // The page's own paths that go with a map: those that are called like it, and those that are called like none.
  list(paths, maps, number) {
    const owner = (path) => maps.findIndex((map) => path.name === map.name || path.name.startsWith(map.name + "_"));
    $("paths").replaceChildren(new Option("what was recorded here", ""), ...paths.filter((path) => [-1, number].includes(owner(path))).map((path) => new Option(path.name.replaceAll("_", " "), paths.indexOf(path))));
    $("paths").hidden = $("paths").options.length < 2;
  }
}
