function bytes_of(text) {  // base64
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}
async function unpacked(text) {  // what was compressed, as bytes
  const stream = new Blob([bytes_of(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
function numbers(text) {  // what `data_text` packed; NaN where there is no value
  return new Float32Array(bytes_of(text).buffer);
}
async function draw(viewer, commands) {  // what MeshCat's viewer is to show or to move
  const bytes = await unpacked(commands), numbers = new DataView(bytes.buffer);
  for (let at = 0; at < bytes.length;) {
    const end = at + 4 + numbers.getUint32(at, true);  // its length stands before each command
    viewer.handle_command_bytearray(bytes.slice(at + 4, end));
    at = end;
  }
}
function move(viewer, motion) {  // as another film of the same nodes; nothing is built again
  const { animator } = viewer, times = numbers(motion.times), end = times[times.length - 1];
  animator.actions.forEach((action, node) => {
    action._clip.duration = end;
    action._interpolants.forEach((track, k) => {
      track.parameterPositions = times;
      track.sampleValues = numbers(motion.tracks[node][k]);
      track._cachedIndex = 0;
    });
  });
  animator.duration = end;
  animator.time_scrubber.max(end);
}
function copy(viewer, from, to) {  // pale shapes of a robot for nodes that are moved already
  const paint = material => Object.assign(material.clone(), { transparent: true, opacity: 0.35 });
  for (const [name, node] of Object.entries(viewer.scene_tree.find(from).children)) {
    const target = viewer.scene_tree.find([...to, name]).object;
    for (const child of node.object.children) {
      const twin = child.clone();
      twin.traverse(part => {
        if (part.material) part.material = Array.isArray(part.material)
          ? part.material.map(paint) : paint(part.material);
      });
      target.add(twin);
    }
  }
}
// Show what has moved, as often as the machine can: software renderers take all of it for a picture.
const SLOW = 40, REST = 0.5, HELD = 6;  // ms of a picture; rests after one, in its times
function run(viewer) {
  const gl = viewer.renderer.getContext();
  let fence = null, begun = 0, took = 0, ended = 0;
  const waits = now => {
    if (fence && gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED) {
      gl.deleteSync(fence);
      fence = null;
      took = Math.min(now - begun, 1000);
      ended = now;
    }
    const held = viewer.held(now);
    if (!viewer.animator.playing && !held) return false;
    if (fence && Math.max(took, now - begun) > SLOW) return true;
    return took > SLOW && now - ended < (held ? HELD : REST) * took;
  };
  let seen = true;  // of a notebook's many pages all would else walk at once
  new IntersectionObserver(found => { seen = found.at(-1).isIntersecting; })
    .observe(document.documentElement);
  (function frame() {
    requestAnimationFrame(frame);
    const now = performance.now();
    if (!seen || waits(now)) return;
    viewer.animator.update();
    viewer.moved();
    if (!viewer.needs_render) return;
    viewer.render();
    if (fence || !gl.fenceSync) return;
    begun = now;
    fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  })();
}
// Without WebGL there is no picture, but the walk's time and its curves are there all the same: the
// renderer is made on a context of which every constant, call and member is this one, and zero.
const NOTHING = new Proxy(() => {}, {
  apply: () => NOTHING,
  get: (_, name) => name === Symbol.toPrimitive ? hint => hint === "string" ? "WebGL 2.0" : 0 : NOTHING,
  set: () => true,
});
function openViewer(pane) {
  try {  // a canvas to try it on would be one of the sixteen that browsers keep alive
    return new MeshCat.Viewer(pane, false);
  } catch {}
  const { prototype } = HTMLCanvasElement, { getContext } = prototype;
  prototype.getContext = function (kind, ...rest) {
    return kind.includes("webgl") ? NOTHING : getContext.call(this, kind, ...rest);
  };
  const viewer = new MeshCat.Viewer(pane, false);
  prototype.getContext = getContext;
  viewer.render = () => { viewer.needs_render = false; };
  const told = document.createElement("p");
  told.style = "position: absolute; top: 40%; left: 15%; right: 15%; text-align: center";
  told.textContent = "The robot cannot be drawn, because WebGL is off in this browser. "
    + "Switch on its hardware acceleration to see it.";
  pane.append(told);
  return viewer;
}
async function openScene(pane, script, commands) {  // MeshCat's viewer, with what it shows
  if (!window.DecompressionStream) {
    pane.textContent = "This page needs a browser of 2023 or later.";
  }
  const code = document.createElement("script");
  code.textContent = new TextDecoder().decode(await unpacked(script));
  document.head.append(code);
  const viewer = openViewer(pane);
  viewer.animate = () => {};  // a loop of its own would be a second one
  viewer.moved = () => {};  // told before each picture
  viewer.held = () => false;  // whether something else is more urgent than pictures
  const canvas = viewer.renderer.domElement;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "the robot");
  await draw(viewer, commands);
  run(viewer);
  return viewer;
}
function say(words) {
  for (const [name, text] of Object.entries(words)) {
    document.getElementById(name).innerHTML = text;
  }
  document.title = document.getElementById("title").textContent;
}
