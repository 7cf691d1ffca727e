// SPDX-License-Identifier: MIT
// libdgm/web/package/index.d.ts
// The runtime of deformable geometry maps for scripts. Everything runs on the thread that calls; a Runtime may live in a
// Worker of its own. Coordinates are local: source = ChartInfo.offset + local. Units are those of the source mesh.
//
// Memory belongs to the module. What open(), kernel() and state() return is released by close(), in any order, and by
// nothing else; a method of something closed throws. Arrays are copies, but for State.positions and State.normals.

export type Vector = readonly [number, number, number] | ArrayLike<number>;

/** What the runtime refuses. */
export class DgmError extends Error {
  /** Name of a dgm_code of dgm.h, e.g. "HASH_MISMATCH". */
  readonly code: string;
  /** Place in the file in bytes, or null. */
  readonly offset: number | null;
}

/**
 * Starts the module.
 * @param source  where dgm.wasm is, its bytes, its response or its module; by default beside this file, by fetch()
 * @throws if the module cannot be fetched or the engine has no 128-bit vectors
 */
export function load(source?: URL | string | BufferSource | Response | WebAssembly.Module | Promise<Response>): Promise<Runtime>;

export class Runtime {
  private constructor();
  /**
   * Opens the bytes of a .dgm, which are copied. Header and index are always checked.
   * @param options.verify  compare all bytes with their hashes (true by default): O(bytes)
   * @throws DgmError NOT_DGM, BAD_VERSION, TRUNCATED, HASH_MISMATCH, BAD_INDEX, BAD_LAYER, UNKNOWN_LAYER, OUT_OF_MEMORY
   */
  open(data: ArrayBuffer | ArrayBufferView, options?: { verify?: boolean }): Asset;
  /**
   * A round kernel, exp(-r^2 / sigma) with r in grid steps, that may be used by all states.
   * @param options.reach  grid steps, 1 .. 1024; no larger than the maxReach of the states
   * @param options.sigma  squared grid steps, 1e-6 .. 1e12
   * @param options.end    "compact" (default): value and slope are 0 at the reach; "printed": as equation 7 of the paper
   * @throws DgmError BAD_ARGUMENT, OUT_OF_MEMORY
   */
  kernel(options: { reach: number; sigma: number; end?: "compact" | "printed" }): Kernel;
  /** Size of the module's memory in bytes. It grows, and never shrinks. */
  readonly bytes: number;
}

export interface Kernel {
  readonly reach: number;
  close(): void;
}

export interface ChartInfo {
  readonly rows: number;
  readonly cols: number;
  readonly domain: "square" | "free";
  readonly borderSamples: number;
  /** Names of its layers, in the order of the file. */
  readonly layers: string[];
  /** Box in the frame of the source mesh. */
  readonly min: number[];
  readonly max: number[];
  /** source = offset + local */
  readonly offset: number[];
  /** local = scale * what the layer "geometry" holds */
  readonly scale: number[];
  /** Name of the parameterization. */
  readonly method: string;
}

export interface Layer {
  readonly shape: number[];
  /** Row by row. */
  readonly data: Uint8Array | Uint16Array | Uint32Array | Int16Array | Float32Array;
  /** True if data holds the bits of 16-bit floating-point numbers. */
  readonly half: boolean;
}

export class Asset {
  private constructor();
  readonly charts: ChartInfo[];
  /** @throws DgmError BAD_ARGUMENT (no such chart) */
  chart(chart: number): ChartInfo;
  /** A copy of a layer, or null if the chart has none of that name. */
  layer(chart: number, name: string): Layer | null;
  /** Checks all values of a chart, as state() does. @throws DgmError NOT_FINITE, BAD_VALUE, BAD_SEAM_TABLE, SEAM_GAP */
  validate(chart: number): void;
  /**
   * A deformable copy of a chart, independent of the asset.
   * @param options.maxReach  largest reach of the kernels to come, 1 .. 1024 (default 65)
   * @throws DgmError as validate(), and OUT_OF_MEMORY. O(samples), about 130 bytes a sample
   */
  state(chart: number, options?: { maxReach?: number }): State;
  close(): void;
}

export interface RayHit {
  /** The corner with the largest weight, as the representative of its seam copies. */
  sample: number;
  /** The quad, or null for a face of the border strip. */
  row: number | null;
  column: number | null;
  /** Number in the quad, 0 or 1; else the row of the layer "border_faces". */
  triangle: number;
  corners: number[];
  front: boolean;
  barycentric: number[];
  distance: number;
  point: number[];
  normal: number[];
}

export interface TickOptions {
  /** Largest displacement, local units, > 0. */
  dMax: number;
  /** Distance that the kernel reads (default "surface"). */
  footprint?: "surface" | "geodesic" | "grid";
  mode?: "elastic" | "plastic";
  rule?: "smooth" | "printed";
  /** Seconds a tick (default 0.001). */
  dt?: number;
  /** Largest force on each axis (default 1). */
  fMax?: number;
  /** 1/s: how fast elastic displacement fades without contact. 0 (default): at once; negative: it stays. */
  relaxRate?: number;
  /** Seconds in which jumps fade. 0 (default): 0.01; negative: they pass at once. */
  settleTime?: number;
  /** Local units. 0 (default): four mean steps. */
  graspDistance?: number;
  /** Local length of a step of the kernel. 0 (default): the mean step. */
  step?: number;
}

export interface Tool {
  kind?: "touch" | "poke" | "grasp";
  /** True: it lets go and does not touch. */
  lifted?: boolean;
  /** x, y, z of each tick: 3 * ticks numbers. */
  positions: ArrayLike<number>;
}

export interface ToolAnswer {
  /** Nearest sample of the shape without elastic touches. */
  sample: number;
  hit: boolean;
  holding: boolean;
  /** The sample that the tool displaces, or null. */
  contact: number | null;
  displacement: number[];
  /** After the last tick; forces has x, y, z of each. */
  force: number[];
  forces: Float32Array;
}

export interface TickReport {
  contacts: number;
  samples: number;
  crossedSeam: boolean;
  tools: ToolAnswer[];
}

/** Samples first + r * cols + c for r < rows, c < columns; from rows * cols of the chart on, border samples in one row. */
export interface ChangedRange {
  first: number;
  columns: number;
  rows: number;
}

export type Obstacle =
  | { kind: "plane"; point: Vector; normal: Vector }
  | { kind: "sphere"; point: Vector; radius: number }
  | { kind: "capsule"; point: Vector; end: Vector; radius: number }
  /** Another state, whose origin lies at `point`; `reach` as in dgm_obstacle. */
  | { kind: "surface"; state: State; point?: Vector; reach?: number };

export interface ContactReport {
  status: "clear" | "contact" | "restored" | "open";
  samples: number;
  removed: number;
  /** Volume gained by the call, divided by `removed`. */
  volumeError: number;
  volumeKept: boolean;
  deepest: number;
}

export class State implements ChartInfo {
  private constructor();
  readonly rows: number;
  readonly cols: number;
  readonly domain: "square" | "free";
  readonly borderSamples: number;
  readonly layers: string[];
  readonly min: number[];
  readonly max: number[];
  readonly offset: number[];
  readonly scale: number[];
  readonly method: string;
  /** Grid and border. */
  readonly sampleCount: number;
  readonly meanStep: number;
  /** Samples that elastic touches may still have moved. */
  readonly activeSamples: number;
  /** x, y and z of the present shape, in the module's memory: read them anew after open(), kernel() or state(). */
  readonly positions: [Float32Array, Float32Array, Float32Array];
  /** Unit normals; those of the last tick() or updateNormals(). */
  readonly normals: [Float32Array, Float32Array, Float32Array];
  /** Two numbers a sample: along columns, then along rows, 0 .. 1; the first row is the top of the picture. */
  uv(): Float32Array;
  /** Triangles of blocks of `stride` quads; borders keep all samples. All levels share the vertices. */
  indices(stride?: number): Uint32Array;
  /** A sample and all its seam copies (64 at most), in ascending order. */
  copies(sample: number): number[];
  /** The first triangle on a ray, or null. O(log samples). @throws DgmError BAD_ARGUMENT */
  pick(origin: Vector, direction: Vector): RayHit | null;
  /**
   * Runs ticks of the haptic loop, 1000 at most, with up to four tools. Normals are brought up to date by the last one.
   * @throws DgmError BAD_ARGUMENT, LIMIT_EXCEEDED, NOT_FOUND
   */
  tick(kernel: Kernel, options: TickOptions, tools: readonly Tool[], ticks?: number): TickReport;
  /** What has moved since the last call; all samples at the first one. */
  changed(): ChangedRange[];
  /** Ends elastic touches and contacts. */
  release(): void;
  /** Back to the shape at rest. */
  reset(): void;
  /** Multiplies elastic displacements by exp(-rate * dt). */
  relax(dt: number, rate: number): void;
  updateNormals(): void;
  /** Moves the shape out of an obstacle and bulges it so that its volume stays. Normals need updateNormals(). */
  contact(obstacle: Obstacle, options?: { mode?: "elastic" | "plastic" }): ContactReport;
  /** Enclosed volume, local units cubed; 0 for an open surface. O(samples). */
  volume(): number;
  close(): void;
}
