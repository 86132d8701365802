const SVG = "http://www.w3.org/2000/svg";
const WIDE = 300, HIGH = 150, LEFT = 46, RIGHT = 8, TOP = 8, BOTTOM = 20;  // of a panel, in units
const END = 1e-6;  // of a period: this near to its end is its end, not the beginning of the next one
const EDGE = 5e-4;  // of a period: a panel's edges are this far within it, where no impact is
const SLIP = 6;  // pixels that a finger moves aside before it drags
const FAR = 1.5;  // a limit this many times the largest value would flatten the curves
function element(parent, name, attributes = {}, text = "") {
  const svg = ["svg", "path", "line", "rect", "text", "circle", "g"].includes(name);
  const made = svg ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text) made.textContent = text;
  parent.append(made);
  return made;
}
function ticks(low, high) {  // three to six round numbers between
  const rough = (high - low) / 6, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(n => n * power).find(s => s >= rough);
  const found = [];
  for (let n = Math.ceil(low / step); n * step <= high + 1e-9 * step; n++) found.push(n * step);
  return found;
}
function release(event) {  // after a mouse, the space bar is to play again, not to press once more
  if (event.detail > 0) event.currentTarget.blur();
}
function press(button, on) {  // as one of several that are on or off
  button.classList.toggle("on", on);
  button.setAttribute("aria-pressed", on);
}
function known(value) { return !Number.isNaN(value); }
function opened(panel) {  // with arrays in the place of texts
  const lines = panel.lines.map(
    line => ({ ...line, y: numbers(line.y), ...(line.x && { x: numbers(line.x) }) }));
  return { ...panel, lines };
}
function brief(value, digits = 4) {
  return String(Number(value.toPrecision(digits))).replace("-", "\u2212");
}
function span(values, least) {
  const low = Math.min(...values), high = Math.max(...values);
  const room = 0.08 * Math.max(high - low, least);
  return [low - room, high + room];
}
function calm(low, high, [from, to]) {  // an axis that has room stands still while curves move
  return low <= from && to <= high && high - low < 1.2 * (to - from) ? [low, high] : [from, to];
}
// One panel: lines over time, or y over x where a line has x; a cursor that follows the walk.
class Panel {
  constructor(parent, curves, panel, on) {
    const name = panel.title + (panel.unit && ` in ${panel.unit}`);
    const box = element(parent, "figure", { class: "panel", tabindex: 0, "aria-label": name, title: name });
    const head = element(box, "figcaption");
    element(head, "b", {}, panel.title);
    element(head, "span", {}, " " + panel.unit);
    this.told = element(head, "span", { class: "told" });
    const svg = element(box, "svg", {
      viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": name });
    this.back = element(svg, "g");
    this.curves = panel.lines.map(line => element(svg, "path", { class: "curve " + line.side }));
    this.points = Boolean(panel.lines[0].x);
    if (this.points) {
      this.dots = panel.lines.map(line => element(svg, "circle",
        { class: "dot " + line.side, r: 3.5 }));
    } else {
      this.cursor = element(svg, "line", { class: "cursor", y1: TOP, y2: HIGH - BOTTOM });
      const seek = event => {
        const at = svg.getBoundingClientRect();
        const x = (event.clientX - at.left) / at.width * WIDE;
        const share = (x - LEFT) / (WIDE - LEFT - RIGHT);
        on.seek(Math.max(EDGE, Math.min(1 - EDGE, share)) * this.period);
      };
      svg.style.cursor = "ew-resize";
      let from = NaN;  // where a finger came down, which may be about to scroll the page
      svg.onpointerdown = event => {
        from = event.pointerType === "touch" ? event.clientX : NaN;
        if (from >= 0) return;
        svg.setPointerCapture(event.pointerId);
        seek(event);
      };
      svg.onpointermove = event => {
        if (!event.buttons || Math.abs(event.clientX - from) < SLIP) return;
        from = NaN;
        seek(event);
      };
      svg.onclick = seek;
    }
    box.onpointerenter = box.onfocus = () => on.highlight(panel.joints);
    box.onpointerleave = box.onblur = () => on.highlight([]);
    this.draw(curves, panel);
  }
  draw(curves, panel) {  // also those of another walk
    this.panel = panel; this.time = curves.time; this.period = curves.period;
    this.scales();
    const scene = JSON.stringify([this.low, this.high, this.from, this.to, panel.limits, panel.box]);
    if (scene !== this.scene) {  // else axes and limits are where they were
      this.scene = scene;
      this.back.replaceChildren();
      this.axes();
      this.limits();
    }
    panel.lines.forEach((line, k) => this.curves[k].setAttribute("d", this.path(line)));
  }
  scales() {
    const values = this.panel.lines.flatMap(line => [...line.y]).filter(known);
    const largest = Math.max(...values.map(Math.abs), 1e-9);
    this.rounding = 1e-9 * largest;
    const near = this.panel.limits.filter(l => Math.abs(l) < FAR * largest);
    const box = this.panel.box;
    [this.low, this.high] = calm(this.low, this.high, span(
      box ? [box[1], box[3]] : [...values, 0, ...(this.points ? near : near.filter(
        l => l < 0 ? Math.min(...values) < l / FAR : Math.max(...values) > l / FAR))],
      0.02 * largest));
    [this.from, this.to] = this.points
      ? calm(this.from, this.to, span(
        box ? [box[0], box[2]] : this.panel.lines.flatMap(l => [...l.x]).filter(known), 1e-9))
      : [0, this.period];
    this.right = x => LEFT + (x - this.from) / (this.to - this.from) * (WIDE - LEFT - RIGHT);
    this.up = y => HIGH - BOTTOM - (y - this.low) / (this.high - this.low) * (HIGH - TOP - BOTTOM);
  }
  axes() {
    for (const y of ticks(this.low, this.high)) {
      element(this.back, "line", { class: y === 0 ? "zero" : "grid",
        x1: LEFT, x2: WIDE - RIGHT, y1: this.up(y), y2: this.up(y) });
      element(this.back, "text", { x: LEFT - 5, y: this.up(y) + 4, "text-anchor": "end" }, brief(y));
    }
    for (const x of ticks(this.from, this.to)) {
      element(this.back, "text", { x: this.right(x), y: HIGH - 6, "text-anchor": "middle" },
        brief(x));
    }
  }
  limits() {
    const bottom = HIGH - BOTTOM;
    for (const limit of this.panel.limits) {
      const y = this.up(limit);
      if (y < TOP || y > bottom) continue;
      const beyond = limit > 0 ? [TOP, y - TOP] : [y, bottom - y];
      element(this.back, "rect", { class: "beyond", x: LEFT, width: WIDE - LEFT - RIGHT,
        y: beyond[0], height: Math.max(0, beyond[1]) });
      element(this.back, "line", { class: "limit", x1: LEFT, x2: WIDE - RIGHT, y1: y, y2: y });
    }
    if (this.panel.box) {
      const [x1, y1, x2, y2] = this.panel.box;
      element(this.back, "rect", { class: "sole", x: this.right(x1), y: this.up(y2),
        width: this.right(x2) - this.right(x1), height: this.up(y1) - this.up(y2) });
    }
  }
  path(line) {
    const place = value => Math.round(10 * value) / 10;
    let text = "", open = false;
    for (let i = 0; i < line.y.length; i++) {
      const x = line.x ? line.x[i] : this.time[i], y = line.y[i];
      const seen = known(x) && known(y);
      if (seen) text += `${open ? "L" : "M"}${place(this.right(x))} ${place(this.up(y))}`;
      open = seen;
    }
    return text;
  }
  show(index, share, time) {  // of the curves' instants, and on to the next; within the period
    const words = [];
    const at = values => {
      const value = values[index], next = share ? values[index + 1] : NaN;
      return known(next) ? value + share * (next - value) : value;
    };
    this.panel.lines.forEach((line, k) => {
      const y = at(line.y), x = line.x && at(line.x);
      if (known(y) && !this.points) words.push(brief(Math.abs(y) < this.rounding ? 0 : y, 3));
      if (!this.dots) return;
      const gone = !known(y) || !known(x);
      this.dots[k].style.display = gone ? "none" : "";
      if (gone) return;
      this.dots[k].setAttribute("cx", this.right(x));
      this.dots[k].setAttribute("cy", this.up(y));
    });
    this.told.textContent = words.join(" / ");
    if (this.cursor) {
      this.cursor.setAttribute("x1", this.right(time));
      this.cursor.setAttribute("x2", this.right(time));
    }
  }
}
// The curves of a walk in tabs; `on.seek(time)` and `on.highlight(joints)` tell what was wanted.
class Curves {
  constructor(tabs, place, curves, on) {
    this.take(curves);
    this.place = place; this.on = on;
    this.buttons = curves.tabs.map(tab => {
      const button = element(tabs, "button", {}, tab.name);
      button.onclick = event => { this.open(tab.name); release(event); };
      return button;
    });
    this.open(curves.tabs[0].name);
  }
  take(curves) { this.curves = { ...curves, time: numbers(curves.time) }; }
  open(name) {
    const tab = this.curves.tabs.find(t => t.name === name);
    if (!tab) return;
    for (const button of this.buttons) press(button, button.textContent === name);
    this.place.replaceChildren();
    this.panels = tab.panels.map(
      panel => new Panel(this.place, this.curves, opened(panel), this.on));
    this.index = -1;
    this.show(this.at || 0);
  }
  replace(curves) {  // by those of another walk of this robot; the tab stays
    const open = this.buttons.findIndex(b => b.classList.contains("on"));
    this.take(curves);
    this.panels.forEach(
      (panel, k) => panel.draw(this.curves, opened(this.curves.tabs[open].panels[k])));
    this.index = -1;
    this.show(this.at);
  }
  begun(steps) {  // when the period began that is shown so many steps after the walk began
    const { period, step } = this.curves;
    return Math.max(0, Math.ceil(steps * step / period - END) - 1) * period;
  }
  show(steps) {  // how many have passed since the walk began
    const { time: times, period, step } = this.curves;
    this.at = steps;
    const inside = Math.min(steps * step - this.begun(steps), period);
    let low = 0, high = times.length - 1;
    while (low < high) {  // the last instant not after it
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= inside + END * period) low = middle; else high = middle - 1;
    }
    if (low === this.index && Math.abs(inside - this.inside) < 1e-6) return;
    this.index = low; this.inside = inside;
    const share = Math.max(0, inside - times[low]) / (times[low + 1] - times[low]) || 0;
    for (const panel of this.panels) panel.show(low, share, inside);
  }
}
