"use strict";
// Draws the charts again at any zoom. Without it the page still shows all of them whole.
(() => {
  const WIDTH = 2000, HEIGHT = 400, COLUMNS = 600, MARGIN = 0.05, FLAT = 1e-6, EMPTY = 65535;
  const holder = document.getElementById("charts");

  // Theme: as the system says, until the button is pressed.
  const root = document.documentElement;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const theme = document.getElementById("theme");
  theme.hidden = false;
  theme.addEventListener("click", () => {
    const now = root.dataset.theme || (dark.matches ? "dark" : "light");
    root.dataset.theme = now === "dark" ? "light" : "dark";
  });
  if (!holder) return;

  const data = JSON.parse(document.getElementById("data").textContent);

  function unpacked(text, Kind) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return new Kind(bytes.buffer);
  }
  const axes = data.axes.map((axis) => {
    const codes = unpacked(axis.x, Uint32Array), x = new Float64Array(codes.length);
    for (let i = 0; i < x.length; i++) x[i] = axis.start + codes[i] * axis.step;
    return x;
  });
  for (const panel of data.panels) {
    for (const line of panel.lines) {
      line.x = axes[line.axis];
      line.codes = unpacked(line.y, Uint16Array);
      line.shown = true;
    }
  }
  const value = (line, i) =>
    line.codes[i] === EMPTY ? NaN : line.low + line.codes[i] * line.step;

  // First row at or after a moment.
  function row(x, moment) {
    let low = 0, high = x.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < moment) low = middle + 1; else high = middle;
    }
    return low;
  }

  let view = data.span.slice();

  function reach(panel) {
    let low = Infinity, high = -Infinity;
    for (const line of panel.lines) {
      if (!line.shown) continue;
      const a = Math.max(row(line.x, view[0]) - 1, 0);
      const b = Math.min(row(line.x, view[1]) + 1, line.x.length);
      for (let i = a; i < b; i++) {
        const v = value(line, i);
        if (v < low) low = v;
        if (v > high) high = v;
      }
    }
    if (low > high) return [0, 1];
    const flat = high - low <= FLAT * Math.max(Math.abs(low), Math.abs(high));
    const room = flat ? Math.abs(high) * 0.1 || 1 : (high - low) * MARGIN;
    return [low - room, high + room];
  }

  // Every column keeps its least and its greatest value, so that no spike is lost.
  function path(line, bounds) {
    const a = Math.max(row(line.x, view[0]) - 1, 0);
    const b = Math.min(row(line.x, view[1]) + 1, line.x.length);
    const across = WIDTH / (view[1] - view[0]), down = HEIGHT / (bounds[1] - bounds[0]);
    const words = [];
    let pen = "M";
    const to = (x, v) => {
      const y = ((bounds[1] - v) * down).toFixed(1);
      words.push(pen, x.toFixed(1), " ", y);
      pen = "L";
    };
    if (b - a <= 2 * COLUMNS) {
      for (let i = a; i < b; i++) {
        const v = value(line, i);
        if (Number.isNaN(v)) pen = "M"; else to((line.x[i] - view[0]) * across, v);
      }
      return words.join("");
    }
    let column = -1, low = -1, high = -1;
    const put = (i) => to((line.x[i] - view[0]) * across, value(line, i));
    const end = () => {
      if (low < 0) { pen = "M"; return; }
      put(Math.min(low, high));
      if (high !== low) put(Math.max(low, high));
    };
    for (let i = a; i < b; i++) {
      const place = (line.x[i] - view[0]) * across * (COLUMNS / WIDTH);
      const c = Math.min(Math.max(Math.floor(place), 0), COLUMNS - 1);
      if (c !== column) {
        if (column >= 0) end();
        column = c; low = high = -1;
      }
      if (line.codes[i] === EMPTY) continue;
      if (low < 0 || line.codes[i] < line.codes[low]) low = i;
      if (high < 0 || line.codes[i] > line.codes[high]) high = i;
    }
    if (column >= 0) end();
    return words.join("");
  }

  function ticks(low, high, most) {
    const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
    const times = [1, 2, 2.5, 5, 10].find((s) => s * power >= raw * 0.999);
    const step = times * power, more = times === 2.5 ? 1 : 0, found = [];
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + more);
    const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
    for (let i = 0; i <= Math.min(last - first, 20); i++) {
      const v = (first + i) * step + 0;
      found.push([v, v.toFixed(digits).replace("-", "−")]);
    }
    return found;
  }

  function boxes(spans) {
    const across = WIDTH / (view[1] - view[0]);
    return spans.map((s) => s.map((t) =>
      (Math.max(Math.min(t, view[1]), view[0]) - view[0]) * across))
      .filter(([a, b]) => b > a)
      .map(([a, b]) => `M${a.toFixed(1)} 0V${HEIGHT}H${b.toFixed(1)}V0Z`).join("");
  }

  function marks(place, found, bounds, side) {
    place.replaceChildren(...found.map(([v, text]) => {
      const mark = document.createElement("span");
      mark.textContent = text;
      mark.style[side] = `${100 * (v - bounds[0]) / (bounds[1] - bounds[0])}%`;
      return mark;
    }));
  }

  const figures = [...document.querySelectorAll(".panel")].map((figure) => ({
    panel: data.panels[figure.dataset.panel],
    plot: figure.querySelector(".plot"),
    xs: figure.querySelector(".xs"),
    ys: figure.querySelector(".ys"),
    grid: figure.querySelector(".grid"),
    lines: [...figure.querySelectorAll(".line")],
    shades: [...figure.querySelectorAll(".shade")],
    cursor: figure.querySelector(".cursor"),
    keys: [...figure.querySelectorAll(".legend button")],
    values: [...figure.querySelectorAll(".value")],
  }));

  function draw() {
    for (const f of figures) {
      const bounds = reach(f.panel);
      f.panel.lines.forEach((line, k) =>
        f.lines[k].setAttribute("d", line.shown ? path(line, bounds) : ""));
      const spans = [...data.regimes.map((r) => r.spans), f.panel.flagged];
      f.shades.forEach((shade, k) => shade.setAttribute("d", boxes(spans[k])));
      const up = ticks(bounds[0], bounds[1], 5);
      const down = HEIGHT / (bounds[1] - bounds[0]);
      f.grid.setAttribute("d", up.map(([v]) =>
        `M0 ${((bounds[1] - v) * down).toFixed(1)}H${WIDTH}`).join(""));
      marks(f.ys, up, bounds, "bottom");
      const most = Math.max(2, Math.min(8, Math.floor(f.plot.clientWidth / 90)));
      marks(f.xs, ticks(view[0], view[1], most), view, "left");
      f.cursor.setAttribute("d", "");
    }
  }

  let asked = false;
  function show(from, to) {
    const [first, last] = data.span, least = (last - first) * 1e-5;
    const size = Math.min(Math.max(to - from, least), last - first);
    const start = Math.min(Math.max(from, first), last - size);
    view = [start, start + size];
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  }

  const at = document.getElementById("at");
  function point(moment) {
    for (const f of figures) {
      const x = (moment - view[0]) / (view[1] - view[0]) * WIDTH;
      f.cursor.setAttribute("d", `M${x.toFixed(1)} 0V${HEIGHT}`);
      f.panel.lines.forEach((line, k) => {
        let i = Math.min(row(line.x, moment), line.x.length - 1);
        if (i > 0 && moment - line.x[i - 1] < line.x[i] - moment) i -= 1;
        const v = value(line, i);
        const text = Number.isNaN(v) ? "–" : Number(v.toPrecision(4)).toString();
        f.values[k].textContent = ` ${text.replace("-", "−")} ${f.panel.unit}`;
      });
    }
    const regime = data.regimes.find((r) =>
      r.spans.some(([a, b]) => a <= moment && moment < b));
    at.textContent = `${moment.toFixed(2)} s${regime ? `, ${regime.name}` : ""}`;
  }

  for (const f of figures) {
    const band = document.createElement("div");
    band.className = "band";
    band.hidden = true;
    f.plot.append(band);
    const share = (event) => {
      const box = f.plot.getBoundingClientRect();
      return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
    };
    const moment = (part) => view[0] + part * (view[1] - view[0]);
    let from = null;
    f.plot.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      from = share(event);
      f.plot.setPointerCapture(event.pointerId);
    });
    f.plot.addEventListener("pointermove", (event) => {
      const part = share(event);
      point(moment(part));
      if (from === null) return;
      band.hidden = false;
      band.style.left = `${100 * Math.min(from, part)}%`;
      band.style.width = `${100 * Math.abs(part - from)}%`;
    });
    f.plot.addEventListener("pointerup", (event) => {
      const part = share(event), wide = Math.abs(part - from) * f.plot.clientWidth;
      band.hidden = true;
      if (from !== null && wide > 8) {
        show(moment(Math.min(from, part)), moment(Math.max(from, part)));
      }
      from = null;
    });
    f.plot.addEventListener("pointercancel", () => { from = null; band.hidden = true; });
    f.plot.addEventListener("dblclick", () => show(...data.span));
    f.keys.forEach((key, k) => key.addEventListener("click", () => {
      const line = f.panel.lines[k];
      line.shown = !line.shown;
      key.setAttribute("aria-pressed", String(line.shown));
      draw();
    }));
  }

  const act = {
    in: (a, size) => show(a + size / 4, a + size * 3 / 4),
    out: (a, size) => show(a - size / 2, a + size * 3 / 2),
    left: (a, size) => show(a - size / 4, a + size * 3 / 4),
    right: (a, size) => show(a + size / 4, a + size * 5 / 4),
    all: () => show(...data.span),
  };
  const keys = {
    "+": "in", "=": "in", "-": "out", "ArrowLeft": "left", "ArrowRight": "right",
    "0": "all", "Escape": "all",
  };
  const tools = holder.querySelector(".tools");
  tools.hidden = false;
  tools.addEventListener("click", (event) => {
    const name = event.target.dataset.do;
    if (name) act[name](view[0], view[1] - view[0]);
  });
  holder.addEventListener("keydown", (event) => {
    const name = keys[event.key];
    if (!name || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act[name](view[0], view[1] - view[0]);
  });
  holder.dataset.ready = "yes";
  window.addEventListener("resize", () => show(...view));
  draw();
})();
