// Values under the pointer: reads the JSON beside each panel and shows every curve at the nearest abscissa.
for (const panel of document.querySelectorAll(".panel[data-hover]")) {
  const data = JSON.parse(panel.querySelector("script").textContent);
  const svg = panel.querySelector("svg"), [left, top, width, height] = data.box;
  const make = (name, attributes) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    return node;
  };
  const share = (v, [a, b], log) => log ? (Math.log(v) - Math.log(a)) / (Math.log(b) - Math.log(a)) : (v - a) / (b - a);
  const line = make("line", {y1: top, y2: top + height, stroke: "var(--soft)", "stroke-width": 0.7, visibility: "hidden"});
  const dots = make("g", {visibility: "hidden"});
  const tip = document.createElement("div");
  tip.className = "tip"; tip.hidden = true;
  svg.append(line, dots); panel.append(tip);
  const all = [...new Set(data.series.flatMap(s => s.x))].sort((a, b) => a - b);
  const hide = () => { tip.hidden = true; line.setAttribute("visibility", "hidden"); dots.setAttribute("visibility", "hidden"); };
  let shownAt = 0;
  const show = event => {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
    const at = ((event.clientX - box.left) * scale - left) / width;
    if (at < -0.02 || at > 1.02) return hide();
    let k = 0, best = Infinity;
    all.forEach((value, n) => {
      const distance = Math.abs(share(value, data.x, data.logx) - at);
      if (distance < best) { best = distance; k = n; }
    });
    showAt(k);
  };
  const showAt = k => {
    const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width, x = all[k];
    shownAt = k;
    const rows = [];
    dots.replaceChildren();
    for (const series of data.series) {
      const k = series.x.indexOf(x);
      if (k < 0 || series.y[k] === null) continue;
      rows.push([series.label, series.y[k], series.colour]);
      dots.append(make("circle", {cx: left + width * share(x, data.x, data.logx), r: 2.6, fill: series.colour,
        cy: top + height * (1 - share(series.y[k], data.y, data.logy))}));
    }
    const px = left + width * share(x, data.x, data.logx);
    line.setAttribute("x1", px); line.setAttribute("x2", px);
    line.setAttribute("visibility", "visible"); dots.setAttribute("visibility", "visible");
    const head = document.createElement("b");
    head.textContent = data.name + " " + x;
    tip.replaceChildren(head, ...rows.map(([label, value, colour]) => {
      const row = document.createElement("div"), name = document.createElement("span"), swatch = document.createElement("i");
      swatch.style.background = colour;
      name.append(swatch, label);
      const number = document.createElement("span");
      number.textContent = value.toPrecision(3) + " " + data.unit;
      row.append(name, number);
      return row;
    }));
    tip.hidden = false;
    const shown = px / scale;
    tip.style.left = (shown < box.width / 2 ? shown + 12 : shown - tip.offsetWidth - 12) + "px";
    tip.style.top = Math.max(0, top / scale + 6) + "px";
  };
  svg.addEventListener("pointermove", show);
  svg.addEventListener("pointerdown", show);
  svg.addEventListener("pointerleave", hide);
  panel.addEventListener("blur", hide);
  panel.addEventListener("keydown", event => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (event.key === "Escape") return hide();
    if (!step) return;
    event.preventDefault();
    showAt(Math.min(all.length - 1, Math.max(0, tip.hidden ? shownAt : shownAt + step)));
  });
}
