// The surface and the displacements of the designs, as arrays.

import { unpacked } from './packed.js';
import { Surface } from '../../../viewer/page/src/surface.js';

const FULL = 65535;

export class Shape extends Surface {
  static async load(data) {
    const shape = new Shape();
    const { surface } = data;
    shape.data = data;
    shape.low = surface.low;
    shape.size = surface.high.map((v, c) => v - surface.low[c]);
    shape.diagonal = surface.diagonal || 1;
    const q = await unpacked('positions', Uint16Array, 3);
    shape.triangles = await unpacked('triangles', Uint32Array, 3);
    shape.start = new Float32Array(q.length);
    // Centred: single precision is spent on the shape, not on where it lies.
    for (let i = 0; i < q.length; ++i) shape.start[i] = (q[i] / FULL - 0.5) * shape.size[i % 3];
    shape.center = surface.low.map((v, c) => v + shape.size[c] / 2);
    shape.labels = [];
    for (const level of data.tree) shape.labels.push(await unpacked(level.blob, Uint16Array, 1));
    shape.cache = new Map();
    shape.finish();
    return shape;
  }

  /** Displacement of a frame, n x 3. */
  async moved(frame) {
    return this.kept(frame.blob, async () => {
      const q = await unpacked(frame.blob, Uint16Array, 3);
      return Float32Array.from(q, (v) => ((2 * v) / FULL - 1) * frame.scale);
    });
  }

  async numbers(field) {
    return this.kept(field.blob, async () => {
      const q = await unpacked(field.blob, Uint16Array, 1);
      return Float32Array.from(q, (v) => field.low + (v / FULL) * (field.high - field.low));
    });
  }

  async kept(name, make) {
    if (!this.cache.has(name)) {
      if (this.cache.size > 24) this.cache.delete(this.cache.keys().next().value);
      this.cache.set(name, make());
    }
    return this.cache.get(name);
  }

  /** Positions of the start plus `factor` times the displacement. */
  positions(moved, factor) {
    const p = Float32Array.from(this.start);
    if (moved) for (let i = 0; i < p.length; ++i) p[i] += factor * moved[i];
    return p;
  }

  /** Displacement along the normals of the start. */
  outward(moved) {
    const out = new Float32Array(this.vertices);
    for (let v = 0; v < out.length; ++v)
      for (let c = 0; c < 3; ++c) out[v] += moved[3 * v + c] * this.normals[3 * v + c];
    return out;
  }

  lengths(moved) {
    const out = new Float32Array(this.vertices);
    for (let v = 0; v < out.length; ++v) out[v] = Math.hypot(moved[3 * v], moved[3 * v + 1], moved[3 * v + 2]);
    return out;
  }
}
