// What the visitor draws, and shapes to begin with.

/** Pixels of a side of the ink: a multiple of all numbers of cells that are offered. */
const SIDE = 576;

const centre = SIDE / 2;

/** Shapes by name: paths in a square of side 1 whose middle is (0, 0), and icons of 24. */
export const SHAPES = {
  circle: { icon: 'M12 4a8 8 0 100 16 8 8 0 000-16z', draw: (ink, radius = 0.2) => ink.disc(0, 0, radius) },
  ring: {
    icon: 'M12 3a9 9 0 100 18 9 9 0 000-18zm0 4.500a4.5 4.5 0 110 9 4.5 4.5 0 010-9z',
    draw: (ink) => ink.path('evenodd', (pen) => (pen.arc(0, 0, 0.28, 0, 7), pen.closePath(), pen.arc(0, 0, 0.16, 0, 7))),
  },
  drops: {
    icon: 'M6.5 7.500a4.5 4.5 0 100 9 4.5 4.5 0 000-9zM17.5 7.500a4.5 4.5 0 100 9 4.5 4.5 0 000-9z',
    draw: (ink) => (ink.disc(-0.22, 0, 0.15), ink.disc(0.22, 0, 0.15)),
  },
  star: {
    icon: 'M12 2.500l2.900 6.200 6.800.8-5 4.700 1.300 6.700-6-3.300-6 3.300 1.300-6.700-5-4.700 6.800-.8z',
    draw: (ink) => ink.path('nonzero', (pen) => corners(10, (i) => (i % 2 ? 0.16 : 0.36)).forEach(([x, y]) => pen.lineTo(x, y))),
  },
  crescent: {
    icon: 'M19.5 15.5A8.5 8.5 0 118.5 4.5a7 7 0 0011 11z',
    draw: (ink) =>
      ink.path('nonzero', (pen) => {
        pen.arc(-0.02, 0, 0.34, 0.1 - 0.9, -0.1 + 0.9 - 2 * Math.PI, true);
        pen.arc(0.13, 0, 0.26, 1.2, -1.2 + 2 * Math.PI);
      }),
  },
  heart: {
    icon: 'M12 20.500C5 15.5 2.5 12 2.5 8.500A4.800 4.800 0 0112 6.500a4.800 4.800 0 019.5 2c0 3.5-2.5 7-9.5 12z',
    draw: (ink) =>
      ink.path('nonzero', (pen) => {
        pen.moveTo(0, 0.31);
        pen.bezierCurveTo(-0.28, 0.12, -0.36, -0.02, -0.36, -0.13);
        pen.bezierCurveTo(-0.36, -0.33, -0.1, -0.36, 0, -0.17);
        pen.bezierCurveTo(0.1, -0.36, 0.36, -0.33, 0.36, -0.13);
        pen.bezierCurveTo(0.36, -0.02, 0.28, 0.12, 0, 0.31);
      }),
  },
};

function corners(count, radius) {
  return Array.from({ length: count }, (_, i) => {
    const turn = (2 * Math.PI * i) / count - Math.PI / 2;
    return [radius(i) * Math.cos(turn), radius(i) * Math.sin(turn)];
  });
}

/** A drawing whose opacity is density. */
export class Ink {
  #pen = Object.assign(document.createElement('canvas'), { width: SIDE, height: SIDE }).getContext('2d', { willReadFrequently: true });

  clear() {
    this.#pen.clearRect(0, 0, SIDE, SIDE);
  }

  /** Fills what `outline` traces. */
  path(rule, outline) {
    this.#pen.save();
    this.#pen.translate(centre, centre);
    this.#pen.scale(SIDE, SIDE);
    this.#pen.beginPath();
    outline(this.#pen);
    this.#pen.fill(rule);
    this.#pen.restore();
  }

  disc(x, y, radius) {
    this.path('nonzero', (pen) => pen.arc(x, y, radius, 0, 7));
  }

  /** A few letters, as large as the box allows. */
  letters(text) {
    const pen = this.#pen;
    const font = (size) => `800 ${size}px "DejaVu Sans", Inter, system-ui, sans-serif`;
    pen.font = font(100);
    const size = measure(pen, text);
    const scale = (0.7 * SIDE) / Math.max(size.width, size.height, 1);
    pen.font = font(100 * scale);
    const { left, top, width, height } = measure(pen, text);
    pen.fillText(text, centre - left - width / 2, centre - top - height / 2);
  }

  /** A stroke from one point to another, in box lengths from the corner. */
  stroke(from, to, width, erase) {
    const pen = this.#pen;
    pen.save();
    pen.globalCompositeOperation = erase ? 'destination-out' : 'source-over';
    pen.lineCap = 'round';
    pen.lineWidth = width * SIDE;
    pen.beginPath();
    pen.moveTo(from[0] * SIDE, from[1] * SIDE);
    // A point is a line that is too short to see.
    pen.lineTo(to[0] * SIDE + 0.01, to[1] * SIDE);
    pen.stroke();
    pen.restore();
  }

  /** The mean opacity of each of `n` x `n` cells and, to soften the edges, a little of its neighbours; x fastest. */
  density(n) {
    const { data } = this.#pen.getImageData(0, 0, SIDE, SIDE);
    const width = SIDE / n;
    const cells = new Float32Array(n * n);
    for (let y = 0; y < SIDE; y++) {
      const row = Math.floor(y / width) * n;
      for (let x = 0; x < SIDE; x++) cells[row + Math.floor(x / width)] += data[4 * (y * SIDE + x) + 3];
    }
    return soften(soften(cells.map((sum) => sum / (255 * width * width)), n, 1), n, n);
  }
}

/** A quarter of each neighbour along one axis and half of the cell itself. */
function soften(cells, n, stride) {
  return cells.map((value, i) => {
    const place = Math.floor(i / stride) % n;
    const [before, after] = [place > 0 ? cells[i - stride] : value, place < n - 1 ? cells[i + stride] : value];
    return 0.25 * before + 0.5 * value + 0.25 * after;
  });
}

function measure(pen, text) {
  const box = pen.measureText(text);
  const [left, top] = [-box.actualBoundingBoxLeft, -box.actualBoundingBoxAscent];
  return { left, top, width: box.actualBoundingBoxRight - left, height: box.actualBoundingBoxDescent - top };
}
