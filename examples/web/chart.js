// The objective of every iteration, on a logarithmic axis. Iterations on coarser grids are muted.

const INK = { line: '#242933', text: '#8b90a0', coarse: '#5d6478', fine: '#f0a35e' };
const EDGE = { left: 44, right: 6, top: 10, bottom: 18 };

export class Chart {
  constructor(canvas) {
    this.canvas = canvas;
    this.clear();
    new ResizeObserver(() => this.#draw()).observe(canvas);
  }

  clear() {
    this.points = [];
    this.#draw();
  }

  add({ iteration, data, force, level }) {
    if (data + force > 0) this.points.push({ iteration, level, value: data + force });
    this.#draw();
  }

  #draw() {
    const { canvas, points } = this;
    const scale = devicePixelRatio;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [width * scale, height * scale];
    const pen = canvas.getContext('2d');
    pen.scale(scale, scale);
    pen.font = '11px system-ui, "DejaVu Sans", sans-serif';
    pen.fillStyle = INK.text;
    if (points.length === 0) {
      pen.fillText('objective per iteration', EDGE.left, height - 5);
      this.#rule(pen, height - EDGE.bottom, width);
      return;
    }
    const values = points.map(({ value }) => Math.log10(value));
    const [low, high] = spread(Math.min(...values), Math.max(...values));
    const last = Math.max(points.at(-1).iteration, 10);
    const x = (iteration) => EDGE.left + ((iteration - 1) / (last - 1)) * (width - EDGE.left - EDGE.right);
    const y = (value) => EDGE.top + ((high - Math.log10(value)) / (high - low)) * (height - EDGE.top - EDGE.bottom);
    pen.textAlign = 'right';
    for (const value of ticks(low, high)) {
      this.#rule(pen, y(value), width);
      pen.fillText(Number(value.toPrecision(1)).toString(), EDGE.left - 8, y(value) + 4);
    }
    pen.fillText(`iteration ${points.at(-1).iteration}`, width - EDGE.right, height - 4);
    pen.textAlign = 'left';
    pen.fillText('objective, on coarser grids first', EDGE.left, height - 4);
    pen.lineWidth = 1.75;
    pen.lineJoin = 'round';
    for (const level of new Set(points.map((point) => point.level))) {
      pen.strokeStyle = level === 0 ? INK.fine : INK.coarse;
      pen.beginPath();
      points.filter((point) => point.level === level).forEach(({ iteration, value }) => pen.lineTo(x(iteration), y(value)));
      pen.stroke();
    }
    const end = points.at(-1);
    pen.fillStyle = end.level === 0 ? INK.fine : INK.coarse;
    pen.beginPath();
    pen.arc(x(end.iteration), y(end.value), 3, 0, 7);
    pen.fill();
  }

  #rule(pen, y, width) {
    pen.strokeStyle = INK.line;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(EDGE.left, Math.round(y) + 0.5);
    pen.lineTo(width - EDGE.right, Math.round(y) + 0.5);
    pen.stroke();
  }
}

/** At least a third of a decade, so that a flat line looks flat. */
function spread(low, high) {
  const missing = Math.max(0, 0.34 - (high - low)) / 2;
  return [low - missing - 0.02, high + missing + 0.02];
}

/** 1, 2 and 5 of each decade, or the first of them where that is too many. */
function ticks(low, high) {
  const of = (digits) => {
    const all = [];
    for (let decade = Math.floor(low); decade <= high; decade++) all.push(...digits.map((digit) => digit * 10 ** decade));
    return all.filter((value) => Math.log10(value) >= low && Math.log10(value) <= high);
  };
  const all = of([1, 2, 5]);
  return all.length > 5 ? of([1]) : all;
}
