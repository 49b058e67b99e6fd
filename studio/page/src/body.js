// The surface that the server sends, in one piece (studio/surface_payload.hpp).

import { Surface } from '../../../viewer/page/src/surface.js';

const kinds = { f32: Float32Array, u32: Uint32Array };

export class Body extends Surface {
  static read(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const facts = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const body = new Body();
    body.facts = facts;
    body.array = (name) => {
      const place = facts.arrays[name];
      return place ? new kinds[place.type](buffer, 4 + length + place.offset, place.count) : null;
    };
    body.start = body.array('positions');
    body.triangles = body.array('triangles');
    body.size = facts.high.map((v, c) => v - facts.low[c]);
    body.diagonal = facts.diagonal || 1;
    body.center = facts.center;
    body.finish();
    return body;
  }

  get count() { return this.triangles.length / 3; }

  /** Middle of a triangle, in the coordinates of the file. */
  middle(t) {
    return [0, 1, 2].map((c) => this.center[c] + [0, 1, 2].reduce((sum, k) => sum + this.start[3 * this.triangles[3 * t + k] + c] / 3, 0));
  }

  /** Number of a triangle in its file; null: repair made it. */
  inFile(t) {
    const numbers = this.array('file_triangle');
    if (!numbers) return t;
    return numbers[t] === 4294967295 ? null : numbers[t];
  }
}
