// A pad to draw on, and its presets.

import { Ink, SHAPES } from './ink.js';
import { Smoke } from './smoke.js';

/** Cells that a pad shows, whatever the solve takes. */
const SHOWN = 96;

export class Pad {
  /** `changed` is called after every change; `brush()` is the width of the brush in box lengths. */
  constructor(name, { brush, changed }) {
    this.canvas = document.getElementById(name);
    this.ink = new Ink();
    this.smoke = new Smoke(this.canvas);
    this.brush = brush;
    this.changed = changed;
    this.#offer(document.querySelector(`[data-pad="${name}"]`));
    this.#listen();
  }

  /** Shows a shape of `SHAPES`; a circle as large as `radius` says. */
  shape(name, radius) {
    this.preset = name;
    this.letters.value = '';
    this.#anew(() => SHAPES[name].draw(this.ink, radius));
  }

  /** Shows letters. */
  write(text) {
    this.preset = 'letters';
    this.letters.value = text;
    this.#anew(() => this.ink.letters(text));
  }

  clear() {
    this.preset = null;
    this.letters.value = '';
    this.#anew(() => {});
  }

  /** Smoke in each of n x n cells. */
  density(n) {
    return this.ink.density(n);
  }

  #anew(draw) {
    this.ink.clear();
    draw();
    this.#show();
  }

  #show() {
    this.smoke.draw(this.ink.density(SHOWN), SHOWN, { full: 1.08 });
    for (const [name, button] of this.buttons) button.setAttribute('aria-pressed', name === this.preset);
    this.changed(this);
  }

  #offer(place) {
    this.buttons = Object.entries(SHAPES).map(([name, { icon }]) => {
      return [name, this.#button(name, `<path fill-rule="evenodd" d="${icon}"/>`, () => this.shape(name))];
    });
    this.letters = Object.assign(document.createElement('input'), { type: 'text', maxLength: 3, placeholder: 'abc', title: 'Letters' });
    this.letters.setAttribute('aria-label', 'Letters');
    this.letters.addEventListener('input', () => this.letters.value.trim() && this.write(this.letters.value.trim()));
    place.append(...this.buttons.map(([, button]) => button), this.letters, this.#button('clear', '<path d="M6 6l12 12M18 6L6 18" style="stroke-width:2"/>', () => this.clear()));
  }

  #button(name, icon, press) {
    const button = Object.assign(document.createElement('button'), { type: 'button', title: name, innerHTML: `<svg viewBox="0 0 24 24" aria-hidden="true">${icon}</svg>` });
    button.setAttribute('aria-label', name);
    button.addEventListener('click', press);
    return button;
  }

  #listen() {
    let last = null;
    const place = ({ offsetX, offsetY }) => [offsetX / this.canvas.clientWidth, offsetY / this.canvas.clientHeight];
    const draw = (event) => {
      if (!last) return;
      const next = place(event);
      this.preset = null;
      this.letters.value = '';
      this.ink.stroke(last, next, this.brush(), event.shiftKey || (event.buttons & 2) !== 0);
      last = next;
      this.#show();
    };
    this.canvas.addEventListener('pointerdown', (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      last = place(event);
      draw(event);
    });
    this.canvas.addEventListener('pointermove', draw);
    for (const end of ['pointerup', 'pointercancel']) this.canvas.addEventListener(end, () => (last = null));
    this.canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }
}
