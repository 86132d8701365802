const ROOM = 0.94;  // of the picture, for the robot
const reach = { side: 0, top: 0, bottom: 0 };  // of the robot, in halves of a square picture
function measure() {  // once for each posture to be shown
  const camera = viewer.camera;
  camera.zoom = camera.aspect = 1;
  camera.updateProjectionMatrix();
  viewer.controls.update();  // look at the robot
  viewer.scene.updateMatrixWorld(true);
  camera.updateMatrixWorld(true);
  for (const robot of ROBOTS) viewer.scene_tree.find(robot).object.traverse(part => {
    if (!part.geometry) return;
    if (!part.geometry.boundingBox) part.geometry.computeBoundingBox();
    const box = part.geometry.boundingBox;
    for (let corner = 0; corner < 8; corner++) {
      const point = box.min.clone();
      if (corner & 1) point.x = box.max.x;
      if (corner & 2) point.y = box.max.y;
      if (corner & 4) point.z = box.max.z;
      point.applyMatrix4(part.matrixWorld).project(camera);
      reach.side = Math.max(reach.side, Math.abs(point.x));
      reach.top = Math.max(reach.top, point.y);
      reach.bottom = Math.max(reach.bottom, -point.y);
    }
  });
}
function fit() {
  const pane = document.getElementById("pane"), camera = viewer.camera;
  const width = pane.offsetWidth, height = pane.offsetHeight;
  let above = 0, below = 0;  // what cards that span the window cover
  for (const card of document.querySelectorAll(".card")) {
    const box = card.getBoundingClientRect();
    if (box.width < 0.8 * width) continue;
    if (box.top < height / 2) above = box.bottom; else below = height - box.top;
  }
  const share = covered => Math.max(0.2, 1 - 2 * covered / height);
  camera.zoom = Math.min(1, ROOM * width / height / reach.side,
                         ROOM * share(above) / reach.top, ROOM * share(below) / reach.bottom);
  setSize(width, height);
}
const setSize = viewer.set_3d_pane_size.bind(viewer);
viewer.set_3d_pane_size = fit;  // by itself it is as high as the window
