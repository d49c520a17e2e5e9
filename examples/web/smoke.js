// Smoke on a canvas: densities enlarged by cubic interpolation, then coloured.

/** From the ground through slate and lavender to warm white. */
const COLOURS = [
  [0, 8, 10, 13],
  [0.1, 19, 23, 33],
  [0.3, 50, 56, 80],
  [0.55, 104, 106, 132],
  [0.78, 172, 164, 168],
  [0.92, 224, 214, 204],
  [1, 255, 248, 236],
];

const RAMP = ramp();
const OUTLINE = [240, 163, 94];

function ramp() {
  const table = new Uint32Array(256);
  for (let i = 0; i < 256; i++) {
    const value = i / 255;
    const above = Math.max(1, COLOURS.findIndex(([at]) => at >= value));
    const [low, high] = [COLOURS[above - 1], COLOURS[above]];
    const part = (value - low[0]) / (high[0] - low[0]);
    const [red, green, blue] = [1, 2, 3].map((c) => Math.round(low[c] + part * (high[c] - low[c])));
    table[i] = (255 << 24) | (blue << 16) | (green << 8) | red;
  }
  return table;
}

/** The cubic of Mitchell and Netravali. */
function cubic(x) {
  const far = Math.abs(x);
  if (far < 1) return (7 * far ** 3 - 12 * far ** 2 + 16 / 3) / 6;
  return far < 2 ? ((-7 / 3) * far ** 3 + 12 * far ** 2 - 20 * far + 32 / 3) / 6 : 0;
}

/** Four neighbours for every pixel of a side, and their weights. */
function taps(n, side) {
  return Array.from({ length: side }, (_, pixel) => {
    const at = ((pixel + 0.5) * n) / side - 0.5;
    const around = [-1, 0, 1, 2].map((offset) => Math.floor(at) + offset);
    return { cells: around.map((cell) => Math.min(n - 1, Math.max(0, cell))), weights: around.map((cell) => cubic(at - cell)) };
  });
}

/** Draws densities of `n` x `n` cells on the whole of a square canvas. */
export class Smoke {
  constructor(canvas) {
    this.side = canvas.width;
    this.pen = canvas.getContext('2d');
    this.image = this.pen.createImageData(this.side, this.side);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.large = new Float32Array(this.side * this.side);
    this.n = 0;
  }

  /** Draws a density; `full` is what is shown brightest. With a `target`, its outline lies above. */
  draw(density, n, { full = 1, target = null } = {}) {
    this.#enlarge(density, n);
    const { large, pixels } = this;
    for (let i = 0; i < large.length; i++) pixels[i] = RAMP[Math.max(0, Math.min(255, Math.round((255 * large[i]) / full)))];
    if (target) this.#trace(target, n, full);
    this.pen.putImageData(this.image, 0, 0);
  }

  #enlarge(density, n) {
    const { side, large } = this;
    if (this.n !== n) {
      this.n = n;
      this.taps = taps(n, side);
      this.wide = new Float32Array(n * side);
    }
    const { taps: all, wide } = this;
    for (let x = 0; x < side; x++) {
      const { cells: [a, b, c, d], weights: [p, q, r, s] } = all[x];
      for (let y = 0; y < n; y++) {
        const row = y * n;
        wide[y * side + x] = p * density[row + a] + q * density[row + b] + r * density[row + c] + s * density[row + d];
      }
    }
    for (let y = 0; y < side; y++) {
      const { cells, weights: [p, q, r, s] } = all[y];
      const [a, b, c, d] = cells.map((cell) => cell * side);
      for (let x = 0; x < side; x++) large[y * side + x] = p * wide[a + x] + q * wide[b + x] + r * wide[c + x] + s * wide[d + x];
    }
  }

  /** Where the target passes half of `full`, one pixel and a half wide. */
  #trace(target, n, full) {
    if (this.traced !== target) {
      this.traced = target;
      this.#enlarge(target, n);
      const { side, large } = this;
      this.outline = new Float32Array(large.length);
      for (let y = 1; y < side - 1; y++) {
        for (let i = y * side + 1; i < (y + 1) * side - 1; i++) {
          const slope = 0.5 * Math.hypot(large[i + 1] - large[i - 1], large[i + side] - large[i - side]);
          if (slope > 1e-3 * full) this.outline[i] = Math.max(0, Math.min(1, 1.4 - Math.abs(large[i] - 0.5 * full) / slope));
        }
      }
    }
    const { data } = this.image;
    this.outline.forEach((cover, i) => {
      if (cover === 0) return;
      const part = 0.55 * cover;
      for (let c = 0; c < 3; c++) data[4 * i + c] += part * (OUTLINE[c] - data[4 * i + c]);
    });
  }
}
