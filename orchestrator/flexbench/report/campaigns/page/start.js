// Draw the page, and again when its size or colours change.

/** Draw everything in the colours and the size of now. */
function drawAll() {
  for (const one of distributions) one.draw();
  for (const cell of matrix.cells) cell.drawBase();
  for (const one of bandPlots) one.draw();
}

startDistributions();
startMatrix();
startBands();
drawAll();
let resizing = null;
window.addEventListener("resize", () => {
  clearTimeout(resizing);
  resizing = setTimeout(drawAll, 80);
});
darkScreen.addEventListener("change", drawAll);
window.addEventListener("beforeprint", () => { printing = true; drawAll(); });
window.addEventListener("afterprint", () => { printing = false; drawAll(); });
document.documentElement.dataset.ready = "";
