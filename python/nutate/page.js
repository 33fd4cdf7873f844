// Moves the pictures of a page that nutate.view wrote: the body, its axes, the points on the curves. `motion` holds the frames,
// `figures` what plotly draws first.
"use strict";
(function () {
  const scene = document.getElementById("nutate-body");
  const ellipsoid = document.getElementById("nutate-polhode");
  const curves = document.getElementById("nutate-curves");
  const play = document.getElementById("nutate-play");
  const slider = document.getElementById("nutate-slider");
  const speed = document.getElementById("nutate-speed");
  const clock = document.getElementById("nutate-time");
  const last = motion.t.length - 1;
  const span = motion.t[last] - motion.t[0];
  let playing = false, time = motion.t[0], shown = -1, before = null, busy = false;

  // Rows of the rotation matrix of a unit quaternion, scalar first, body to space.
  function matrix(q) {
    const [a, b, c, d] = q;
    return [[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]];
  }

  // Components of points of the body along one axis of space.
  function turned(row, points) {
    const [x, y, z] = points;
    return x.map((_, i) => x[i] === null ? null : row[0] * x[i] + row[1] * y[i] + row[2] * z[i]);
  }

  // The frame at a time: frames are in order, forward or back.
  function frameAt(t) {
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((motion.t[middle] - t) * span <= 0) low = middle; else high = middle;
    }
    return (motion.t[high] - t) * span <= 0 ? high : low;
  }

  function arrow(v) { return [[0, v[0]], [0, v[1]], [0, v[2]]]; }

  async function show(k) {
    if (k === shown || busy) return;
    busy = true;
    shown = k;
    const r = matrix(motion.q[k]);
    const parts = [motion.mesh, motion.edges].map((points) => r.map((row) => turned(row, points)));
    parts.push(arrow(motion.axis[k]), arrow(motion.omega[k]), arrow(motion.momentum[k]));
    const update = {x: parts.map((p) => p[0]), y: parts.map((p) => p[1]), z: parts.map((p) => p[2])};
    const p = motion.polhode[k];
    await Promise.all([
      Plotly.restyle(scene, update, [0, 1, 2, 3, 4]),
      Plotly.restyle(ellipsoid, {x: [[p[0]]], y: [[p[1]]], z: [[p[2]]]}, [0]),
      Plotly.relayout(curves, Object.fromEntries(motion.cursors.flatMap((i) =>
        [[`shapes[${i}].x0`, motion.t[k]], [`shapes[${i}].x1`, motion.t[k]]]))),
    ]);
    clock.textContent = `t = ${motion.t[k].toPrecision(5)} s`;
    slider.value = k;
    busy = false;
  }

  function move(now) {
    if (!playing) return;
    if (before !== null) {
      time += Math.sign(span) * Number(speed.value) * motion.rate * (now - before) / 1000;
      if ((time - motion.t[last]) * span > 0) time = motion.t[0];
    }
    before = now;
    show(frameAt(time));
    requestAnimationFrame(move);
  }

  function start(on) {
    playing = on;
    before = null;
    play.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(move);
  }

  slider.max = last;
  slider.addEventListener("input", () => {
    start(false);
    time = motion.t[slider.value];
    show(Number(slider.value));
  });
  play.addEventListener("click", () => start(!playing));
  const options = {responsive: true, displaylogo: false};
  Promise.all([Plotly.newPlot(scene, figures.body.data, figures.body.layout, options),
               Plotly.newPlot(ellipsoid, figures.polhode.data, figures.polhode.layout, options),
               Plotly.newPlot(curves, figures.curves.data, figures.curves.layout, options)])
    .then(() => show(frameAt(motion.t[0] + motion.begin * span)))
    .then(() => { time = motion.t[shown]; document.body.dataset.nutate = "drawn"; if (motion.play) start(true); });
})();
