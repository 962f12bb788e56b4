'use strict';
// The face as numbers: unpacked from the page's data, moved by intensities, its normals and hollows. No drawing, no
// document. Millimetres; x to the subject's left, y up, z out of the face. Binary fields are little-endian.

const { floor, max, min, sqrt } = Math;

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

const u16Of = (base64) => new Uint16Array(bytesOf(base64).buffer);
const i16Of = (base64) => new Int16Array(bytesOf(base64).buffer);
const i8Of = (base64) => new Int8Array(bytesOf(base64).buffer);

class Face {
  constructor(data) {
    const places = u16Of(data.vertices);
    this.count = places.length / 3;
    this.rest = Float32Array.from(places, (value, i) => data.low_mm[i % 3] + data.step_mm * value);
    this.triangles = u16Of(data.triangles);
    this.skinTriangles = data.skin_triangles;
    this.colours = Float32Array.from(bytesOf(data.colours), (value) => Math.pow(value / 255, 2.2));  // linear light
    this.camera = data.camera;
    this.creases = data.creases;
    this.aus = data.aus.map((au) => ({
      name: au.name,
      stepMm: au.step_mm,
      indices: u16Of(au.indices),
      moves: i16Of(au.moves),
      creaseCells: au.crease_cells ? u16Of(au.crease_cells) : new Uint16Array(0),
      creaseHeights: au.crease_heights ? i8Of(au.crease_heights) : new Int8Array(0),
    }));
    this.edges = this.#edges();
  }

  /** Every edge once: both ends, and in how many triangles it is. */
  #edges() {
    const seen = new Map();
    const t = this.triangles;
    for (let i = 0; i < t.length; ++i) {
      const next = i % 3 === 2 ? i - 2 : i + 1;
      const low = min(t[i], t[next]), high = max(t[i], t[next]);
      const key = low * 65536 + high;
      seen.set(key, (seen.get(key) ?? 0) + 1);
    }
    const edges = { from: new Uint16Array(seen.size), to: new Uint16Array(seen.size), times: new Uint8Array(seen.size) };
    let k = 0;
    for (const [key, times] of seen) {
      edges.from[k] = floor(key / 65536);
      edges.to[k] = key % 65536;
      edges.times[k++] = times;
    }
    return edges;
  }
}

/** One face in one expression; its arrays are used again for the next one. */
class FacePose {
  constructor(face) {
    this.face = face;
    this.positions = new Float32Array(face.rest);
    this.normals = new Float32Array(3 * face.count);
    this.openness = new Float32Array(face.count);
    this.bend = new Float32Array(face.count);
    this.sum = new Float32Array(face.count);
    this.weight = new Float32Array(face.count);
    const cells = face.creases.columns * face.creases.rows;
    this.creaseSum = new Float32Array(cells);
    this.creaseHeights = new Uint8ClampedArray(cells);  // 128: level skin
  }

  /** One intensity per AU of the face. */
  set(intensities) {
    this.#move(intensities);
    this.#fold(intensities);
    this.#turnNormals();
    this.#shadeHollows();
  }

  #move(intensities) {
    const { positions, face } = this;
    positions.set(face.rest);
    face.aus.forEach((au, k) => {
      const share = intensities[k] * au.stepMm;
      if (share === 0) return;
      const { indices, moves } = au;
      for (let i = 0; i < indices.length; ++i) {
        const at = 3 * indices[i];
        positions[at] += share * moves[3 * i];
        positions[at + 1] += share * moves[3 * i + 1];
        positions[at + 2] += share * moves[3 * i + 2];
      }
    });
  }

  #fold(intensities) {
    const { creaseSum, creaseHeights, face } = this;
    creaseSum.fill(128);
    face.aus.forEach((au, k) => {
      if (intensities[k] === 0) return;
      for (let i = 0; i < au.creaseCells.length; ++i)
        creaseSum[au.creaseCells[i]] += intensities[k] * au.creaseHeights[i];
    });
    creaseHeights.set(creaseSum);  // rounds
  }

  /** Weighted by area. */
  #turnNormals() {
    const { positions: p, normals: n, face } = this;
    const t = face.triangles;
    n.fill(0);
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i], b = 3 * t[i + 1], c = 3 * t[i + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      n[a] += x; n[a + 1] += y; n[a + 2] += z;
      n[b] += x; n[b + 1] += y; n[b + 2] += z;
      n[c] += x; n[c + 1] += y; n[c + 2] += z;
    }
    for (let i = 0; i < n.length; i += 3) {
      const length = sqrt(n[i] * n[i] + n[i + 1] * n[i + 1] + n[i + 2] * n[i + 2]) || 1;
      n[i] /= length; n[i + 1] /= length; n[i + 2] /= length;
    }
  }

  /** How much light reaches each vertex: less where its neighbours stand before it. Smoothed twice. */
  #shadeHollows() {
    const { positions: p, normals: n, bend, sum, weight, openness, face } = this;
    const { from, to, times } = face.edges;
    bend.fill(0);
    weight.fill(1e-9);
    for (let k = 0; k < from.length; ++k) {
      const a = 3 * from[k], b = 3 * to[k];
      const x = p[b] - p[a], y = p[b + 1] - p[a + 1], z = p[b + 2] - p[a + 2];
      const length = sqrt(x * x + y * y + z * z);
      if (length === 0) continue;
      const counted = times[k] * min(length, 3);
      bend[from[k]] += counted / length * (x * n[a] + y * n[a + 1] + z * n[a + 2]);
      bend[to[k]] -= counted / length * (x * n[b] + y * n[b + 1] + z * n[b + 2]);
      weight[from[k]] += counted;
      weight[to[k]] += counted;
    }
    for (let i = 0; i < bend.length; ++i) bend[i] /= weight[i];
    for (let pass = 0; pass < 2; ++pass) {
      sum.set(bend);
      weight.fill(1);
      for (let k = 0; k < from.length; ++k) {
        const share = 0.5 * times[k];
        sum[from[k]] += share * bend[to[k]];
        sum[to[k]] += share * bend[from[k]];
        weight[from[k]] += share;
        weight[to[k]] += share;
      }
      for (let i = 0; i < bend.length; ++i) bend[i] = sum[i] / weight[i];
    }
    for (let i = 0; i < bend.length; ++i) openness[i] = max(0.35, min(1.12, 1 - 1.9 * bend[i]));
  }
}

/** Intensities over time: one row per frame. */
class Clip {
  constructor(data, width, fullScale) {
    this.frames = data.frames;
    this.width = width;
    this.values = u16Of(data.values);
    this.unit = fullScale / 65535;
  }

  /** Fills `row`; between frames on a straight line, held before the first and behind the last. */
  at(frame, row) {
    const place = max(0, min(this.frames - 1, frame));
    const below = floor(place), above = min(below + 1, this.frames - 1), share = place - below;
    for (let k = 0; k < this.width; ++k) {
      const a = this.values[below * this.width + k], b = this.values[above * this.width + k];
      row[k] = this.unit * (a + share * (b - a));
    }
    return row;
  }
}
