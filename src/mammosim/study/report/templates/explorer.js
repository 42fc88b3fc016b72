// A slider over a finished table: one quantity against another, and what each line has at the slider's place.
// plotly.js is read when an explorer comes near the screen; without scripts the static figures stand for it.
(() => {
  const PLOTLY = document.currentScript.dataset.plotly;
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
  let reading = null;

  function plotly() {
    reading ??= new Promise((ready, failed) => {
      const script = Object.assign(document.createElement("script"), { src: PLOTLY, onload: ready, onerror: failed });
      document.head.append(script);
    });
    return reading;
  }

  // Linear between the two rows around x; nothing beyond the rows.
  function between(line, name, x) {
    const points = line.x.map((at, i) => [at, line.y[name][i]]).filter(([, y]) => y !== null);
    for (let i = 1; i < points.length; i += 1) {
      const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
      if (x0 <= x && x <= x1) return x1 === x0 ? y1 : y0 + (y1 - y0) * (x - x0) / (x1 - x0);
    }
    return null;
  }

  function place(data, slider) {
    const xs = data.lines.flatMap((line) => line.x);
    const scale = data.logarithmic ? Math.log10 : (value) => value;
    const [low, high] = [Math.min(...xs), Math.max(...xs)].map(scale);
    const at = low + (high - low) * slider.value / 100;
    return data.logarithmic ? 10 ** at : at;
  }

  function traces(data, name) {
    return data.lines.map((line, i) => ({
      type: "scatter", mode: "lines+markers", name: line.name, x: line.x, y: line.y[name],
      line: { color: COLOURS[i % COLOURS.length], dash: i < COLOURS.length ? "solid" : "dot" },
    }));
  }

  function layout(data, name, x) {
    const ink = getComputedStyle(document.body).color;
    const axis = { color: ink, gridcolor: "#8884", zeroline: false, automargin: true };
    const mark = { type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { color: ink, width: 1, dash: "dash" } };
    return {
      xaxis: { ...axis, title: { text: data.x }, type: data.logarithmic ? "log" : "linear" }, yaxis: { ...axis, title: { text: data.y[name] } },
      shapes: [mark], margin: { l: 60, r: 10, t: 10, b: 50 }, height: 380, legend: { orientation: "h", y: -0.25 }, font: { color: ink },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    };
  }

  function words(data, name, x) {
    const values = data.lines.map((line) => [line.name, between(line, name, x)]).filter(([, y]) => y !== null);
    const told = values.map(([line, y]) => `${line} ${y.toPrecision(3)}`).join("; ");
    return `${data.x} ${x.toPrecision(3)}, ${data.y[name]}: ${told || "no line reaches there"}`;
  }

  function start(figure) {
    const data = JSON.parse(figure.querySelector("script").textContent);
    const [chart, slider, choice, output] = [".chart", "input", "select", "output"].map((each) => figure.querySelector(each));
    choice.append(...Object.entries(data.y).map(([name, text]) => new Option(text, name)));
    const draw = () => {
      const x = place(data, slider);
      Plotly.react(chart, traces(data, choice.value), layout(data, choice.value, x), { displaylogo: false, responsive: true });
      output.textContent = words(data, choice.value, x);
      slider.setAttribute("aria-valuetext", `${data.x} ${x.toPrecision(3)}`);
    };
    slider.addEventListener("input", () => requestAnimationFrame(draw));
    choice.addEventListener("change", draw);
    draw();
  }

  const near = new IntersectionObserver((seen) => seen.filter((each) => each.isIntersecting).forEach(({ target }) => {
    near.unobserve(target);
    plotly().then(() => start(target), () => { target.hidden = true; });
  }), { rootMargin: "300px" });
  document.querySelectorAll("figure.explorer").forEach((figure) => {
    figure.hidden = false;
    near.observe(figure);
  });
})();
