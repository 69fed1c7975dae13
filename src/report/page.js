"use strict";
// The page is whole without this: it adds the switch of light and dark, quick tips, and the stage for comparing pictures.
(() => {
  const root = document.documentElement;
  const make = (name, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(name), properties);
    element.append(...children);
    return element;
  };

  // Light and dark: what the system prefers, until the button is pressed.
  const theme = document.getElementById("theme");
  theme.hidden = false;
  theme.addEventListener("click", () => {
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
  });

  // Tips: the title of a mark, at once instead of after a second.
  const tip = document.getElementById("tip");
  for (const mark of document.querySelectorAll(".mark")) {
    const title = mark.querySelector("title");
    mark.dataset.tip = title.textContent;
    title.remove();
  }
  document.addEventListener("pointerover", (event) => {
    const mark = event.target.closest?.(".mark");
    tip.hidden = !mark;
    if (!mark) return;
    tip.textContent = mark.dataset.tip;
    const place = mark.getBoundingClientRect();
    const left = Math.min(place.right + 8, innerWidth - tip.offsetWidth - 8);
    const top = place.top - tip.offsetHeight - 8;
    tip.style.left = `${Math.max(8, left)}px`;
    tip.style.top = `${top > 0 ? top : place.bottom + 8}px`;
  });

  // The stage: two pictures of the figure under a slider or side by side, magnified and moved together.
  for (const host of document.querySelectorAll("[data-compare]")) {
    const images = [...host.parentElement.querySelectorAll(".tile img")];
    const view = { zoom: 1, x: 0, y: 0 };
    const stage = make("div", { className: "stage" });
    stage.dataset.mode = "slider";
    const option = (image, i) => make("option", { value: i, textContent: image.alt });
    const sides = [0, 1].map((side) => {
      const image = make("img", { draggable: false });
      const name = make("span");
      const select = make("select", {}, ...images.map(option));
      const show = () => {
        const chosen = images[select.value];
        image.src = chosen.src;
        image.alt = name.textContent = chosen.alt;
      };
      select.value = side === 0 ? 0 : images.length - 1;
      // Without differences the last picture is the natural partner of the first; with them, the second is.
      if (side === 1 && host.parentElement.querySelectorAll(".row").length > 1) select.value = 1;
      select.addEventListener("change", show);
      show();
      stage.append(make("div", { className: "pane" }, image, name));
      return { image, select };
    });
    // A picture stands at its own size; magnified, the stage grows as far as the page has room, then shows a part.
    let inside = 1;
    const fit = () => {
      const side = mode.value === "side" && innerWidth > 560;
      const gap = side ? 4 : 0, panes = side ? 2 : 1;
      const room = (host.clientWidth - gap) / panes;
      const own = Math.min(room, Math.max(...sides.map(({ image }) => image.naturalWidth || room)));
      const width = Math.min(room, own * view.zoom);
      stage.style.width = `${width * panes + gap}px`;
      inside = own * view.zoom / width;
    };
    const draw = () => {
      fit();
      const width = sides[0].image.clientWidth, height = sides[0].image.clientHeight;
      view.x = Math.min(0, Math.max(width * (1 - inside), view.x));
      view.y = Math.min(0, Math.max(height * (1 - inside), view.y));
      for (const { image } of sides) image.style.transform = `translate(${view.x}px, ${view.y}px) scale(${inside})`;
      stage.toggleAttribute("data-zoomed", view.zoom > 1);
    };
    const zoomTo = (zoom) => {
      // The middle of the stage stays where it is.
      const size = () => [sides[0].image.clientWidth * inside, sides[0].image.clientHeight * inside];
      const place = () => [sides[0].image.clientWidth / 2, sides[0].image.clientHeight / 2];
      const [before, middle] = [size(), place()];
      const seen = [(middle[0] - view.x) / before[0], (middle[1] - view.y) / before[1]];
      view.zoom = zoom;
      fit();
      const [after, centre] = [size(), place()];
      [view.x, view.y] = [centre[0] - seen[0] * after[0], centre[1] - seen[1] * after[1]];
      draw();
    };
    let held = null;
    stage.addEventListener("pointerdown", (event) => {
      if (view.zoom === 1) return;
      held = { x: event.clientX - view.x, y: event.clientY - view.y };
      stage.setPointerCapture(event.pointerId);
    });
    stage.addEventListener("pointermove", (event) => {
      if (!held) return;
      view.x = event.clientX - held.x;
      view.y = event.clientY - held.y;
      draw();
    });
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, () => { held = null; });

    const cut = make("input", { type: "range", className: "cut", min: 0, max: 100, value: 50, step: 0.5 });
    cut.setAttribute("aria-label", "Where the left picture ends and the right one begins, percent of the width");
    const place = () => stage.style.setProperty("--cut", `${cut.value}%`);
    cut.addEventListener("input", place);
    place();
    const mode = make("select", {}, make("option", { value: "slider", textContent: "slider" }), make("option", { value: "side", textContent: "side by side" }));
    mode.addEventListener("change", () => {
      stage.dataset.mode = mode.value;
      cut.hidden = mode.value !== "slider";
      zoomTo(view.zoom);
    });
    const zoom = make("select", {}, ...[1, 2, 4, 8, 16].map((n) => make("option", { value: n, textContent: `${n}×` })));
    zoom.addEventListener("change", () => zoomTo(Number(zoom.value)));
    for (const { image } of sides) image.addEventListener("load", draw);
    const controls = make("div", { className: "controls" },
      make("label", {}, "Left", sides[0].select), make("label", {}, "Right", sides[1].select),
      make("label", {}, "Show as", mode), make("label", {}, "Zoom", zoom), "drag to move");
    host.append(controls, stage, cut);
    host.hidden = false;
    draw();
    addEventListener("resize", draw);
  }
})();
