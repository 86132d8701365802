async function unpacked(text) {  // what was compressed, as bytes
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
async function draw(viewer, commands) {  // what MeshCat's viewer is to show or to move
  const bytes = await unpacked(commands), numbers = new DataView(bytes.buffer);
  for (let at = 0; at < bytes.length;) {
    const end = at + 4 + numbers.getUint32(at, true);  // its length stands before each command
    viewer.handle_command_bytearray(bytes.slice(at + 4, end));
    at = end;
  }
}
async function openScene(pane, script, commands) {  // MeshCat's viewer, with what it shows
  if (!window.DecompressionStream) {
    pane.textContent = "This page needs a browser of 2023 or later.";
  }
  const code = document.createElement("script");
  code.textContent = new TextDecoder().decode(await unpacked(script));
  document.head.append(code);
  const viewer = new MeshCat.Viewer(pane);
  await draw(viewer, commands);
  return viewer;
}
