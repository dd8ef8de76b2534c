// A click shows a figure over the whole window; there the wheel, or + and -, zooms, dragging moves, 0 shows all.
(() => {
  const view = document.createElement("dialog");
  view.className = "zoom";
  view.setAttribute("aria-label", "Figure, enlarged");
  document.body.append(view);
  let svg, whole, box, from;
  const set = b => { box = b; svg.setAttribute("viewBox", b.join(" ")); };
  const zoom = (factor, x, y) => {
    const r = svg.getBoundingClientRect(), [u, v] = x === undefined ? [0.5, 0.5] : [(x - r.x) / r.width, (y - r.y) / r.height];
    const w = Math.min(whole[2], Math.max(whole[2] / 50, box[2] * factor)), h = w * whole[3] / whole[2];
    set([box[0] + u * (box[2] - w), box[1] + v * (box[3] - h), w, h]);
  };
  const open = original => {
    svg = original.cloneNode(true);
    whole = svg.getAttribute("viewBox").split(" ").map(Number);
    view.replaceChildren(svg);
    set(whole);
    view.showModal();
  };
  for (const original of document.querySelectorAll("figure svg")) {
    original.tabIndex = 0;
    original.addEventListener("click", () => open(original));
    original.addEventListener("keydown", e => { if (e.key === "Enter") open(original); });
  }
  view.addEventListener("wheel", e => { e.preventDefault(); zoom(e.deltaY < 0 ? 0.8 : 1.25, e.clientX, e.clientY); }, { passive: false });
  view.addEventListener("pointerdown", e => { from = [e.clientX, e.clientY, ...box, false]; });
  view.addEventListener("pointermove", e => {
    if (!from) return;
    const [x, y, u, v, w, h] = from, r = svg.getBoundingClientRect();
    from[6] ||= Math.hypot(e.clientX - x, e.clientY - y) > 4;
    if (from[6]) set([u - (e.clientX - x) * w / r.width, v - (e.clientY - y) * h / r.height, w, h]);
  });
  view.addEventListener("pointerup", () => { const moved = from && from[6]; from = null; if (!moved) view.close(); });
  view.addEventListener("keydown", e => {
    if (e.key === "+") zoom(0.8); else if (e.key === "-") zoom(1.25); else if (e.key === "0") set(whole);
  });
})();
