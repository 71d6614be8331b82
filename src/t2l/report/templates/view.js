"use strict";
// Two robots side by side, posed as measured and as simulated at a moment of a recording.
(() => {
  const figure = document.getElementById("view"), view = data.view;
  const canvas = figure.querySelector("canvas"), stage = figure.querySelector(".stage");
  const element = id => document.getElementById(id);
  const probe = document.createElement("canvas");
  if (!(probe.getContext("webgl2") || probe.getContext("webgl"))) {
    body.dataset.view = "none";
    stage.outerHTML = "<p class='note'>This browser has no WebGL, so the robots are not drawn. The plots above show the same motion.</p>";
    figure.querySelector(".player").remove();
    return;
  }
  const bytes = packed => Uint8Array.from(atob(packed), c => c.charCodeAt(0)).buffer;
  const FULL = 32767, GREY_LINK = new THREE.Color("#c9ced6"), MEASURED = new THREE.Color("#8fa3b8");
  const SCALE = ["#c9ced6", "#fecf92", "#fe9f6d", "#de4968", "#8c0f20"].map(c => new THREE.Color(c));
  function colour(part, out) {
    const at = Math.min(Math.max(part, 0), 1) * (SCALE.length - 1), low = Math.min(Math.floor(at), SCALE.length - 2);
    return out.copy(SCALE[low]).lerp(SCALE[low + 1], at - low);
  }

  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.setScissorTest(true);
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  const scene = new THREE.Scene(), extent = view.extent;
  scene.background = new THREE.Color("#f5f7f9");
  scene.add(new THREE.HemisphereLight("#ffffff", "#a9b2bc", 0.78));
  const sun = new THREE.DirectionalLight("#ffffff", 0.55);
  sun.position.set(1, -2, 3);
  scene.add(sun);

  function geometry(shape) {
    const made = new THREE.BufferGeometry();
    const place = Float32Array.from(new Int16Array(bytes(shape.vertices)), v => v * extent / FULL);
    made.setAttribute("position", new THREE.BufferAttribute(place, 3));
    made.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(shape.triangles)), 1));
    return made;
  }
  const moving = view.bodies.map(geometry), fixed = view.fixed.map(geometry);
  function robot() {
    const group = new THREE.Group();
    const mesh = made => {
      const one = new THREE.Mesh(made, new THREE.MeshLambertMaterial({ color: GREY_LINK, flatShading: true, side: THREE.DoubleSide }));
      group.add(one);
      return one;
    };
    fixed.forEach((made, i) => {
      const one = mesh(made), pose = view.fixed[i].pose;
      one.position.fromArray(pose);
      one.quaternion.fromArray(pose, 3);
    });
    scene.add(group);
    return { group, links: moving.map(mesh) };
  }
  const robots = [robot(), robot()];

  let recording, model = 0, frame = 0, playing = false, started = 0;
  function pose(target, packed) {
    target.links.forEach((link, i) => {
      const at = (frame * moving.length + i) * 7;
      link.position.set(packed[at], packed[at + 1], packed[at + 2]).multiplyScalar(extent / FULL);
      link.quaternion.set(packed[at + 3], packed[at + 4], packed[at + 5], packed[at + 6]).normalize();
    });
  }
  const njoint = data.joints.length;
  function show() {
    pose(robots[0], recording.poses[0]);
    pose(robots[1], recording.poses[1 + model]);
    const errors = recording.errors[model];
    robots[0].links.forEach(link => link.material.color.copy(MEASURED));
    robots[1].links.forEach((link, i) => {
      const joint = view.joint[i];
      colour(joint < 0 ? 0 : errors[frame * njoint + joint] / view.largest_rad, link.material.color);
    });
    element("view-time").value = frame;
    element("view-clock").textContent = (frame / view.rate).toFixed(2) + " s";
    render();
  }
  const unpacked = new Map();
  function choose() {
    const index = Number(element("view-recording").value);
    if (!unpacked.has(index)) {
      const packed = view.recordings[index];
      unpacked.set(index, { count: packed.count, poses: packed.poses.map(p => new Int16Array(bytes(p))), errors: packed.errors.map(floats) });
    }
    recording = unpacked.get(index);
    frame = Math.min(frame, recording.count - 1);
    element("view-time").max = recording.count - 1;
    show();
  }

  // all that moves, as it is at some moments, and what stands, decide where the camera looks
  const box = new THREE.Box3();
  element("view-recording").addEventListener("change", () => { frame = 0; choose(); });
  if (element("view-model")) element("view-model").addEventListener("change", event => { model = Number(event.target.value); show(); });
  element("view-time").addEventListener("input", event => { stop(); frame = Number(event.target.value); show(); });
  element("view-play").addEventListener("click", () => playing ? stop() : play());
  function stop() { playing = false; element("view-play").textContent = "Play"; }
  function play() {
    if (frame >= recording.count - 1) frame = 0;
    playing = true;
    element("view-play").textContent = "Pause";
    started = performance.now() - 1000 * frame / view.rate;
    requestAnimationFrame(step);
  }
  function step(now) {
    if (!playing) return;
    frame = Math.min(Math.max(0, Math.floor((now - started) / 1000 * view.rate)), recording.count - 1);
    show();
    if (frame >= recording.count - 1) stop(); else requestAnimationFrame(step);
  }

  const camera = new THREE.PerspectiveCamera(35, 2, 0.01 * extent, 40 * extent);
  camera.up.set(0, 0, 1);
  const look = { turn: -1.1, rise: 0.3, far: 1, centre: new THREE.Vector3() };
  function render() {
    const { turn, rise, far, centre } = look;
    camera.position.set(Math.cos(turn) * Math.cos(rise), Math.sin(turn) * Math.cos(rise), Math.sin(rise)).multiplyScalar(far).add(centre);
    camera.lookAt(centre);
    // each in its half, seen from the same side: what looks different is different
    const { x: width, y: height } = renderer.getSize(new THREE.Vector2());
    robots.forEach(({ group }, i) => {
      robots.forEach(other => { other.group.visible = other.group === group; });
      renderer.setViewport(i * width / 2, 0, width / 2, height);
      renderer.setScissor(i * width / 2, 0, width / 2, height);
      renderer.render(scene, camera);
    });
  }
  function fit() {
    const width = stage.clientWidth, height = Math.max(260, Math.min(440, width * 0.55));
    renderer.setSize(width, height);
    camera.aspect = width / 2 / height;
    camera.updateProjectionMatrix();
    const size = box.getSize(new THREE.Vector3());
    const wide = Math.hypot(size.x, size.y), half = Math.tan(camera.fov * Math.PI / 360);
    look.far = wide / 2 + 0.55 * Math.max(size.z, wide / camera.aspect) / half;
    box.getCenter(look.centre);
    render();
  }
  let held = null;
  canvas.addEventListener("pointerdown", event => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", event => {
    if (!held) return;
    look.turn -= (event.clientX - held[0]) / 150;
    look.rise = Math.min(1.5, Math.max(-1.5, look.rise + (event.clientY - held[1]) / 150));
    held = [event.clientX, event.clientY];
    render();
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); look.far *= Math.exp(event.deltaY / 1000); render(); }, { passive: false });
  window.addEventListener("resize", fit);

  choose();
  const moments = 12, last = recording.count - 1;
  for (let k = 0; k <= moments; k++) {
    frame = Math.round(k * last / moments);
    pose(robots[0], recording.poses[0]);
    scene.updateMatrixWorld(true);
    box.expandByObject(robots[0].group);
  }
  // at first, the moment of the largest error
  let most = 0;
  recording.errors[0].forEach((value, i) => { if (value > recording.errors[0][most]) most = i; });
  frame = Math.floor(most / njoint);
  fit();
  show();
  body.dataset.view = "drawn";
  window.t2lView = { get recording() { return recording; } };
})();
