// Shows the motion of a page that nutate.view wrote: the body, the polhode, curves with a cursor. `motion` holds the rows and the
// body; everything is drawn on canvases of two dimensions, so that the page needs no library.
"use strict";
(function () {
  const COMPONENTS = ["#d55e00", "#009e73", "#0b3c5d"];
  const OMEGA = "#cc4c8f", MOMENTUM = "#7b3294", PATH = "#e69f00", INK = "#222222", GREY = "#888888", FRAME = "#5f7f95";
  const FONT = "13px Helvetica, Arial, sans-serif";
  const element = (name) => document.getElementById(`nutate-${name}`);
  const play = element("play"), slider = element("slider"), speed = element("speed"), clock = element("time");
  const rows = decoded(motion.rows), drawn = motion.overview ? decoded(motion.overview) : rows;
  const t = rows.t, last = t.length - 1, span = t[last] - t[0], wholeSpan = drawn.t[drawn.t.length - 1] - drawn.t[0];
  let playing = false, time = t[0], before = null;

  // Columns as they were packed: numbers of four bytes.
  function decoded(columns) {
    return Object.fromEntries(Object.entries(columns).map(([name, text]) => {
      const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
      return [name, new Float32Array(bytes.buffer)];
    }));
  }

  const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const norm = (a) => Math.hypot(...a);
  const unit = (a) => times(a, 1 / (norm(a) || 1));
  const three = (source, names, k) => names.map((name) => source[name][k]);

  // The rotation matrix of a quaternion, scalar first, body to space.
  function matrix(q) {
    const n = Math.hypot(...q), [a, b, c, d] = q.map((x) => x / n);
    return [[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]];
  }
  const toSpace = (r, u) => r.map((row) => dot(row, u));
  const toBody = (r, u) => [0, 1, 2].map((i) => r[0][i] * u[0] + r[1][i] * u[1] + r[2][i] * u[2]);

  // The row before a time, and how far the time is on the way to the next one.
  function place(source, at) {
    const list = source.t, sense = Math.sign(list[list.length - 1] - list[0]);
    let low = 0, high = list.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((list[middle] - at) * sense <= 0) low = middle; else high = middle;
    }
    const step = list[high] - list[low];
    return [low, step ? Math.min(1, Math.max(0, (at - list[low]) / step)) : 0];
  }

  // Values of columns at a time, linear between two rows; a quaternion on the shorter way, which it goes as rows are near.
  function valuesAt(names, at) {
    const [k, part] = place(rows, at);
    const a = names.map((name) => rows[name][k]), b = names.map((name) => rows[name][Math.min(k + 1, last)]);
    const sign = names.length === 4 && a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
    return a.map((value, i) => value + part * (sign * b[i] - value));
  }
  const Q = ["q0", "q1", "q2", "q3"], RATE = ["omega1", "omega2", "omega3"], L = ["l_x", "l_y", "l_z"];
  const LVLH = ["lvlh_q0", "lvlh_q1", "lvlh_q2", "lvlh_q3"];

  // A canvas as large as its element, in pixels of CSS.
  function surface(parent) {
    const canvas = document.createElement("canvas");
    parent.appendChild(canvas);
    const context = canvas.getContext("2d");
    return {canvas, context, fit() {
      const ratio = window.devicePixelRatio || 1;
      this.width = parent.clientWidth;
      this.height = parent.clientHeight;
      canvas.width = Math.max(1, Math.round(this.width * ratio));
      canvas.height = Math.max(1, Math.round(this.height * ratio));
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.font = FONT;
    }};
  }

  function label(context, text, x, y, colour, align = "left") {
    context.textAlign = align;
    context.lineWidth = 3;
    context.strokeStyle = "rgba(255, 255, 255, 0.85)";
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  // A picture in three dimensions that is turned by dragging and zoomed by the wheel or two fingers.
  class Space {
    constructor(parent, center, reach) {
      Object.assign(this, {view: surface(parent), center, reach, azimuth: 0.6, elevation: 0.38, zoom: 1, fingers: new Map()});
      const canvas = this.view.canvas;
      canvas.style.touchAction = "pan-y";
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
      });
      for (const end of ["pointerup", "pointercancel"])
        canvas.addEventListener(end, (event) => this.fingers.delete(event.pointerId));
      canvas.addEventListener("pointermove", (event) => this.drag(event));
      canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        this.zoom *= Math.exp(-event.deltaY / 600);
        show();
      }, {passive: false});
      canvas.addEventListener("dblclick", () => { Object.assign(this, {azimuth: 0.6, elevation: 0.38, zoom: 1}); show(); });
    }

    drag(event) {
      const from = this.fingers.get(event.pointerId);
      if (!from) return;
      const spread = () => {
        const [a, b] = [...this.fingers.values()];
        return b && Math.hypot(a[0] - b[0], a[1] - b[1]);
      };
      const wide = spread();
      this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (wide) {
        this.zoom *= spread() / wide;
      } else {
        this.azimuth -= (event.clientX - from[0]) / 150;
        this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + (event.clientY - from[1]) / 150));
      }
      show();
    }

    begin() {
      const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
      const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
      this.right = [-sa, ca, 0];
      this.up = [-se * ca, -se * sa, ce];
      this.ahead = [ce * ca, ce * sa, se];
      this.distance = 5 * this.reach;
      this.scale = this.zoom * 0.47 * Math.min(this.view.width, this.view.height) / this.reach;
      this.view.context.clearRect(0, 0, this.view.width, this.view.height);
      this.view.context.lineJoin = this.view.context.lineCap = "round";
    }

    depth(u) { return dot(this.ahead, add(u, this.center, -1)); }

    // Pixels of a point of space.
    point(u) {
      const v = add(u, this.center, -1), near = this.scale * this.distance / (this.distance - dot(this.ahead, v));
      return [this.view.width / 2 + near * dot(this.right, v), this.view.height / 2 - near * dot(this.up, v)];
    }

    // A face with this middle and normal is seen.
    faces(middle, normal) {
      return dot(normal, add(times(this.ahead, this.distance), add(middle, this.center, -1), -1)) > 0;
    }

    line(points, colour, width, dash = []) {
      const context = this.view.context;
      context.beginPath();
      points.forEach((u, i) => { const [x, y] = this.point(u); if (i) context.lineTo(x, y); else context.moveTo(x, y); });
      Object.assign(context, {strokeStyle: colour, lineWidth: width});
      context.setLineDash(dash);
      context.stroke();
      context.setLineDash([]);
    }

    polygon(points, colour) {
      const context = this.view.context;
      context.beginPath();
      points.forEach((u, i) => { const [x, y] = this.point(u); if (i) context.lineTo(x, y); else context.moveTo(x, y); });
      context.closePath();
      Object.assign(context, {fillStyle: colour, strokeStyle: colour, lineWidth: 0.8});
      context.fill();
      context.stroke();
    }

    head(from, to, colour) {
      const [a, b] = [this.point(from), this.point(to)], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length < 1) return;
      const [x, y] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length], context = this.view.context;
      context.beginPath();
      context.moveTo(b[0] + 4 * x, b[1] + 4 * y);
      context.lineTo(b[0] - 9 * x - 4.5 * y, b[1] - 9 * y + 4.5 * x);
      context.lineTo(b[0] - 9 * x + 4.5 * y, b[1] - 9 * y - 4.5 * x);
      context.fillStyle = colour;
      context.fill();
    }

    shaded(colour, normal) {
      const light = unit(add(add(times(this.right, -0.35), times(this.up, 0.75)), times(this.ahead, 0.56)));
      const bright = 0.72 + 0.34 * Math.max(0, dot(light, normal));
      return `rgb(${[1, 3, 5].map((i) => Math.min(255, Math.round(bright * parseInt(colour.slice(i, i + 2), 16)))).join(",")})`;
    }
  }

  // The body, convex, in body axes; drawn larger than it is where it would hardly be seen.
  const com = motion.center, farthest = (points, from) => Math.max(...points.map((p) => norm(add(p, from, -1))));
  const hangs = motion.path.hangs;
  const places = Array.from(t, (_, k) => toSpace(matrix(three(rows, Q, k)), com));
  const lower = [0, 1, 2].map((i) => places.reduce((least, p) => Math.min(least, p[i]), 0));
  const upper = [0, 1, 2].map((i) => places.reduce((most, p) => Math.max(most, p[i]), 0));
  const ownSize = farthest(motion.points, com), middle = times(add(lower, upper), 0.5);
  const sway = hangs ? Math.max(...places.map((p) => norm(add(p, middle, -1))), norm(middle)) : 0;
  const larger = hangs && ownSize < 0.1 * sway ? 0.15 * sway / ownSize : 1;
  const points = motion.points.map((p) => add(com, add(p, com, -1), larger)), size = larger * ownSize;
  const reach = Math.max((rows.lvlh_q0 ? 1.55 : 1.35) * size, sway + size);
  const faces = motion.corners.map((corner, i) => {
    const [a, b, c] = corner.map((k) => points[k]);
    let normal = unit(cross(add(b, a, -1), add(c, a, -1)));
    if (dot(normal, add(a, com, -1)) < 0) normal = times(normal, -1);
    return {corner, normal, offset: dot(normal, a), colour: motion.colours[i]};
  }).filter((face) => norm(face.normal) > 0.5);
  const edges = [];
  for (let i = 0; i + 1 < motion.edges.length; i++) {
    const [a, b] = [motion.edges[i], motion.edges[i + 1]];
    if (a[0] === null || b[0] === null) continue;
    const ends = [a, b].map((p) => add(com, add(p, com, -1), larger)), halfway = times(add(...ends), 0.5);
    edges.push({ends, faces: faces.filter((face) => Math.abs(dot(face.normal, halfway) - face.offset) < 0.02 * size)});
  }

  // The parts of a line that lie before, inside and behind a convex body: what is drawn before the body and what after it.
  function parted(space, r, from, to) {
    const a = toBody(r, from), b = toBody(r, to), way = add(b, a, -1);
    let [enter, leave, first, second] = [0, 1, null, null];
    for (const face of faces) {
      const out = dot(face.normal, a) - face.offset, slope = dot(face.normal, way);
      if (Math.abs(slope) < 1e-12) { if (out > 0) enter = 2; continue; }
      const at = -out / slope;
      if (slope < 0 && at > enter) [enter, first] = [at, face];
      if (slope > 0 && at < leave) [leave, second] = [at, face];
    }
    const at = (s) => add(from, add(to, from, -1), s);
    const seen = (face, s) => space.faces(at(s), toSpace(r, face.normal));
    if (enter >= leave) return [{from, to, after: space.depth(at(0.5)) > space.depth(toSpace(r, com))}];
    const parts = [{from: at(enter), to: at(leave), after: false}];
    if (first) parts.push({from, to: at(enter), after: seen(first, enter)});
    if (second) parts.push({from: at(leave), to, after: seen(second, leave), ends: true});
    return parts;
  }

  const body = new Space(element("body"), hangs ? middle : [0, 0, 0], reach);
  // Tips of the axis that is followed, or the places of the centre of mass.
  const follow = motion.path.point, onPath = places.map((p, k) => hangs ? p
    : toSpace(matrix(three(rows, Q, k)), times(follow, 1.15 * size)));
  const thin = Math.max(1, Math.ceil(onPath.length / 4000));
  const longest = (names) => Array.from(t, (_, k) => norm(three(rows, names, k))).reduce((a, b) => Math.max(a, b), 0);
  const mostRate = longest(RATE), mostMomentum = longest(L), arrow = 1.25 * size;
  const extent = [0, 1, 2].map((i) => Math.max(...points.map((p) => Math.abs(p[i] - com[i]))));

  function lines(r, at) {
    const base = toSpace(r, com), found = [];
    for (let i = 0; i < 3; i++) {
      const axis = [0, 1, 2].map((j) => Number(i === j));
      const tip = add(com, axis, Math.max(extent[i], 0.3 * size) + 0.22 * size);
      found.push({from: base, to: toSpace(r, tip), colour: COMPONENTS[i], width: 2, name: String(i + 1)});
    }
    if (hangs) found.push({from: [0, 0, 0], to: base, colour: INK, width: 2.5, plain: true});
    const rate = toSpace(r, valuesAt(RATE, at)), momentum = valuesAt(L, at);
    const arrows = [[momentum, mostMomentum, MOMENTUM, "l"], [rate, mostRate, OMEGA, "ω"]];
    for (const [vector, most, colour, name] of arrows)
      if (most) found.push({from: base, to: add(base, vector, arrow / most), colour, width: 3.5, name});
    if (rows.lvlh_q0) {
      const own = matrix(valuesAt(LVLH, at));
      // Columns of R(q) R(lvlh)ᵀ are the axes of the LVLH frame.
      ["forward", null, "nadir"].forEach((name, i) => name && found.push({from: base,
        to: add(base, toSpace(r, own[i]), 1.3 * size), colour: FRAME, width: 1.5, dash: [6, 5], name}));
    }
    return found;
  }

  function drawPath(space, r, after, at) {
    const here = space.depth(toSpace(r, com)), context = space.view.context, now = place(rows, at)[0];
    // What lies a second of the screen back is bold.
    const recent = at - Math.sign(span) * 1.2 * Number(speed.value);
    for (const bold of [false, true]) {
      context.beginPath();
      let open = false;
      for (let k = 0; k < onPath.length; k += bold ? 1 : thin) {
        if (bold && (k > now || (t[k] - recent) * span < 0)) { open = false; continue; }
        if ((space.depth(onPath[k]) > here) !== after) { open = false; continue; }
        const [x, y] = space.point(onPath[k]);
        if (open) context.lineTo(x, y); else context.moveTo(x, y);
        open = true;
      }
      Object.assign(context, {strokeStyle: PATH, lineWidth: bold ? 3 : 1.2, globalAlpha: bold ? 1 : 0.45});
      context.stroke();
      context.globalAlpha = 1;
    }
  }

  function drawBody(at) {
    const space = body, r = matrix(valuesAt(Q, at)), context = space.view.context;
    space.begin();
    if (hangs) drawPivot(space);
    const parts = lines(r, at).flatMap((line) => parted(space, r, line.from, line.to)
      .map((part) => ({...line, ...part, whole: line})));
    const drawLine = (part) => {
      space.line([part.from, part.to], part.colour, part.width, part.dash);
      if (!part.plain && !part.dash && part.to === part.whole.to && norm(add(part.to, part.whole.from, -1)) > 0.12 * size)
        space.head(part.whole.from, part.to, part.colour);
    };
    drawPath(space, r, false, at);
    parts.filter((part) => !part.after).forEach(drawLine);
    parts.filter((part) => !part.after && part.to === part.whole.to).forEach((part) => drawName(space, part.whole));
    const turned = points.map((p) => toSpace(r, p));
    for (const face of faces) {
      const normal = toSpace(r, face.normal);
      if (space.faces(turned[face.corner[0]], normal))
        space.polygon(face.corner.map((k) => turned[k]), space.shaded(face.colour, normal));
    }
    for (const edge of edges) {
      const ends = edge.ends.map((p) => toSpace(r, p));
      if (edge.faces.some((face) => space.faces(ends[0], toSpace(r, face.normal)))) space.line(ends, INK, 1.3);
    }
    motion.wheels.forEach((axis, i) => drawWheel(space, r, axis, i));
    parts.filter((part) => part.after).forEach(drawLine);
    drawPath(space, r, true, at);
    parts.filter((part) => part.after && part.to === part.whole.to).forEach((part) => drawName(space, part.whole));
    drawCorner(space);
    drawCaption(space, at);
  }

  function drawName(space, line) {
    if (!line.name || norm(add(line.to, line.from, -1)) < 0.12 * size) return;
    const [x, y] = space.point(add(line.to, unit(add(line.to, line.from, -1)), 0.09 * size));
    // Angular velocity and momentum often have one direction.
    label(space.view.context, line.name, x + ({"ω": 12, l: -12}[line.name] || 0), y + 4, line.colour, "center");
  }

  function drawPivot(space) {
    const radius = 0.3 * reach;
    const around = Array.from({length: 41}, (_, i) => Math.PI * i / 20);
    space.line(around.map((angle) => [radius * Math.cos(angle), radius * Math.sin(angle), 0]), "#cccccc", 1);
    const [x, y] = space.point([0, 0, 0]), context = space.view.context;
    context.beginPath();
    context.arc(x, y, 3.5, 0, 2 * Math.PI);
    context.fillStyle = INK;
    context.fill();
  }

  // A ring about the axis of a reaction wheel, outside of the body, with its number.
  function drawWheel(space, r, axis, i) {
    const along = unit(axis), aside = unit(cross(along, Math.abs(along[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0]));
    const other = cross(along, aside), radius = 0.2 * size;
    // On the side where the arrow of a body axis does not leave the body.
    const out = Math.max(...points.map((p) => -dot(along, add(p, com, -1)))) + 0.04 * size, base = add(com, along, -out);
    const ring = Array.from({length: 33}, (_, k) => Math.PI * k / 16).map((angle) =>
      toSpace(r, add(add(base, aside, radius * Math.cos(angle)), other, radius * Math.sin(angle))));
    const seen = space.faces(toSpace(r, base), toSpace(r, times(along, -1)));
    if (seen) space.polygon(ring, "rgba(120, 120, 120, 0.35)");
    space.line(ring, seen ? INK : "rgba(34, 34, 34, 0.25)", 1.5);
    const [x, y] = space.point(toSpace(r, base));
    if (seen) label(space.view.context, `wheel ${i + 1}`, x, y + 4, "#444444", "center");
  }

  // The directions of space, in the corner.
  function drawCorner(space) {
    const context = space.view.context, x = 34, y = space.view.height - 34;
    ["x", "y", "z"].forEach((name, i) => {
      const end = [x + 22 * space.right[i], y - 22 * space.up[i]];
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(...end);
      Object.assign(context, {strokeStyle: GREY, lineWidth: 1.5});
      context.stroke();
      label(context, name, x + 30 * space.right[i], y + 4 - 30 * space.up[i], "#555555", "center");
    });
  }

  function drawCaption(space, at) {
    const passed = (event) => (at - event.t) * Math.sign(span), near = 0.8 * Number(speed.value);
    const event = motion.events.filter((each) => passed(each) >= 0 && passed(each) < near).pop();
    const text = [`path of ${motion.path.name}`, ...(larger > 1 ? [`body drawn ${short(larger)} × larger`] : [])];
    text.forEach((line, i) => label(space.view.context, line, 12, 20 + 18 * i, i ? "#555555" : "#9a6a00"));
    const wheels = motion.wheels.map((_, i) => `wheel${i + 1}_speed`).filter((name) => rows[name]);
    wheels.forEach((name, i) => label(space.view.context, `wheel ${name[5]}: ${short(valuesAt([name], at)[0])} rad/s`,
      space.view.width - 12, space.view.height - 14 - 18 * (wheels.length - 1 - i), "#444444", "right"));
    if (event) label(space.view.context, event.name, space.view.width - 12, 20, "#b03a00", "right");
  }

  // The ellipsoid x.Jx = 1 in body axes, and on it the path of ω/√(2T).
  const inertia = motion.inertia;
  function onEllipsoid(w) {
    const length = Math.sqrt(dot(w, inertia.map((row) => dot(row, w))));
    return length > 0 ? times(w, 1 / length) : w;
  }
  const polhode = Array.from(t, (_, k) => onEllipsoid(three(rows, RATE, k)));
  const shell = [];
  for (let i = 0; i < 16; i++) for (let k = 0; k < 32; k++)
    shell.push([[i, k], [i + 1, k], [i + 1, k + 1], [i, k + 1]].map(([a, b]) => {
      const polar = Math.PI * a / 16, round = Math.PI * b / 16;
      return onEllipsoid([Math.sin(polar) * Math.cos(round), Math.sin(polar) * Math.sin(round), Math.cos(polar)]);
    }));
  const ellipsoid = new Space(element("polhode"), [0, 0, 0], 1.45 * Math.max(...shell.map((patch) => norm(patch[0]))));
  const outward = (p) => unit(inertia.map((row) => dot(row, p)));

  function drawPolhode(at) {
    const space = ellipsoid, context = space.view.context;
    space.begin();
    const most = space.reach / 1.45;
    // Where an axis leaves the ellipsoid, and where its line ends.
    const tipOf = (i) => {
      const foot = onEllipsoid([0, 1, 2].map((j) => Number(i === j)));
      return [foot, times(foot, 1 + 0.22 * most / norm(foot))];
    };
    [0, 1, 2].forEach((i) => {
      const tip = tipOf(i)[1];
      space.line([times(tip, -1), tip], COMPONENTS[i], 1.5);
    });
    const across = (behind) => {
      context.beginPath();
      let open = false;
      polhode.forEach((p, k) => {
        const jumps = k && norm(add(p, polhode[k - 1], -1)) > 0.5 * most;
        if (space.faces(p, outward(p)) === behind) { open = false; return; }
        const [x, y] = space.point(p);
        if (open && !jumps) context.lineTo(x, y); else context.moveTo(x, y);
        open = true;
      });
      Object.assign(context, {strokeStyle: OMEGA, lineWidth: behind ? 1.2 : 2.2, globalAlpha: behind ? 0.5 : 1});
      context.stroke();
      context.globalAlpha = 1;
    };
    for (const patch of shell) {
      const normal = outward(times(add(patch[0], patch[2]), 0.5));
      if (space.faces(patch[0], normal)) space.polygon(patch, space.shaded("#b9d3e8", normal));
    }
    [0, 1, 2].forEach((i) => {
      const [foot, tip] = tipOf(i);
      for (const sign of [1, -1])
        if (space.faces(times(foot, sign), times(outward(foot), sign)))
          space.line([times(foot, sign), times(tip, sign)], COMPONENTS[i], 1.5);
      const [x, y] = space.point(times(tip, 1.06));
      label(context, String(i + 1), x, y + 4, COMPONENTS[i], "center");
    });
    across(true);
    across(false);
    const here = onEllipsoid(valuesAt(RATE, at)), [x, y] = space.point(here);
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    Object.assign(context, {fillStyle: OMEGA, globalAlpha: space.faces(here, outward(here)) ? 1 : 0.4});
    context.fill();
    context.globalAlpha = 1;
    label(context, "polhode: ω on the inertia ellipsoid, body axes", 12, 20, OMEGA);
  }

  // Curves: panels side by side where there is room.
  const plots = motion.panels.map((panel) => {
    panel.curves = panel.curves.filter(([name]) => drawn[name]);
    const parent = document.createElement("div");
    element("curves").appendChild(parent);
    const plot = {panel, view: surface(parent), still: document.createElement("canvas")};
    plot.view.canvas.addEventListener("pointerdown", (event) => {
      const {left, width} = plot.box, x = event.clientX - plot.view.canvas.getBoundingClientRect().left;
      start(false);
      goTo(drawn.t[0] + wholeSpan * Math.min(1, Math.max(0, (x - left) / width)));
    });
    return plot;
  });

  function short(value) { return Number(value.toPrecision(Math.abs(value) >= 100 ? 4 : 3)).toString(); }

  function ticks(low, high, count) {
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough)), found = [];
    const step = power * [1, 2, 5, 10].find((s) => s * power >= rough);
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
    return found;
  }

  // What an axis reaches over: the values, and a little more.
  function rangeOf(columns) {
    let [low, high] = [Infinity, -Infinity];
    for (const values of columns)
      for (const value of values)
        if (isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    const span = high - low, least = 1e-6 * Math.max(Math.abs(low), Math.abs(high));
    const pad = span > least ? 0.05 * span : Math.abs(high) * 0.01 || 1;
    return [low - pad, high + pad];
  }

  function stroke(context, from, to, style) {
    context.save();
    Object.assign(context, {lineWidth: 1, ...style});
    context.setLineDash(style.dash || []);
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
    context.restore();
  }

  function number(value) {
    return Math.abs(value) >= 1e5 || (value && Math.abs(value) < 1e-3) ? value.toExponential() : String(value);
  }

  // What does not change: axes, curves, events.
  function drawStill(plot) {
    const {view, panel} = plot, context = view.context;
    view.fit();
    context.clearRect(0, 0, view.width, view.height);
    let x = 10, y = 18;
    label(context, panel.label, x, y, INK);
    x += context.measureText(panel.label).width + 14;
    for (const [, colour, name] of panel.curves) {
      const wide = context.measureText(name).width + 14;
      if (x + wide > view.width) [x, y] = [10, y + 17];
      label(context, name, x, y, colour);
      x += wide;
    }
    const box = plot.box = {left: 58, top: y + 10, width: view.width - 70, height: view.height - y - 46};
    const [low, high] = rangeOf(panel.curves.map(([name]) => drawn[name]));
    const across = plot.across = (value) => box.left + box.width * (value - drawn.t[0]) / wholeSpan;
    const down = (value) => box.top + box.height * (high - value) / (high - low);
    const under = box.top + box.height;
    for (const value of ticks(low, high, Math.max(2, box.height / 40))) {
      stroke(context, [box.left, down(value)], [box.left + box.width, down(value)], {strokeStyle: "#e2e2e2"});
      label(context, number(value), box.left - 6, down(value) + 4, "#555555", "right");
    }
    const ends = [drawn.t[0], drawn.t[0] + wholeSpan].sort((a, b) => a - b);
    for (const value of ticks(...ends, Math.max(2, box.width / 90)))
      label(context, number(value), across(value), under + 17, "#555555", "center");
    label(context, "t (s)", box.left + box.width, under + 33, "#555555", "right");
    const mark = {strokeStyle: "#d55e00", globalAlpha: motion.events.length > 60 ? 0.12 : 0.4, dash: [3, 3]};
    for (const event of motion.events)
      stroke(context, [across(event.t), box.top], [across(event.t), under], mark);
    for (const [name, colour] of panel.curves) {
      context.beginPath();
      let open = false;
      drawn[name].forEach((value, k) => {
        const at = [across(drawn.t[k]), down(value)];
        if (open && !(panel.wraps && Math.abs(value - drawn[name][k - 1]) > 4)) context.lineTo(...at); else context.moveTo(...at);
        open = isFinite(value);
      });
      Object.assign(context, {strokeStyle: colour, lineWidth: 1.6, lineJoin: "round"});
      context.stroke();
    }
    Object.assign(plot.still, {width: view.canvas.width, height: view.canvas.height});
    plot.still.getContext("2d").drawImage(view.canvas, 0, 0);
  }

  function drawCursor(plot, at) {
    const {view, box} = plot, context = view.context, x = plot.across(at);
    context.save();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, view.canvas.width, view.canvas.height);
    context.drawImage(plot.still, 0, 0);
    context.restore();
    context.beginPath();
    context.moveTo(x, box.top);
    context.lineTo(x, box.top + box.height);
    Object.assign(context, {strokeStyle: "#444444", lineWidth: 1.5});
    context.stroke();
  }

  function show() {
    drawBody(time);
    drawPolhode(time);
    plots.forEach((plot) => drawCursor(plot, time));
    clock.textContent = `t = ${time.toPrecision(5)} s`;
    slider.value = Math.round(1000 * (time - t[0]) / span);
  }

  function goTo(at) {
    time = (at - t[0]) * span < 0 ? t[0] : (at - t[last]) * span > 0 ? t[last] : at;
    show();
  }

  function move(now) {
    if (!playing) return;
    if (before !== null) {
      time += Math.sign(span) * Number(speed.value) * (now - before) / 1000;
      if ((time - t[last]) * span > 0) time = t[0];
      show();
    }
    before = now;
    requestAnimationFrame(move);
  }

  function start(on) {
    playing = on;
    before = null;
    play.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(move);
  }

  function lay() {
    body.view.fit();
    ellipsoid.view.fit();
    plots.forEach(drawStill);
    show();
  }

  for (const factor of motion.factors) {
    const how = factor < 1 ? `${short(1 / factor)} × slower than ` : factor > 1 ? `${short(factor)} × faster than ` : "";
    speed.add(new Option(how + "real time", factor, factor === motion.factor, factor === motion.factor));
  }
  slider.max = 1000;
  slider.addEventListener("input", () => { start(false); goTo(t[0] + span * slider.value / 1000); });
  play.addEventListener("click", () => start(!playing));
  window.addEventListener("resize", lay);
  time = t[0] + motion.begin * span;
  lay();
  document.body.dataset.nutate = "drawn";
  if (motion.play) start(true);
})();
