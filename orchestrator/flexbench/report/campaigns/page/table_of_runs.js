// Which runs are selected, and the table that lists them.

const MOST_LISTED = 20;
const selection = { system: 0, runs: null, listeners: [] }; // runs: Uint8Array of flags, or null for no selection

/** Select runs of a system by flags, or none with null, and redraw what shows the selection. */
function select(system, flags) {
  selection.system = system;
  selection.runs = flags;
  for (const listener of selection.listeners) listener();
  showSelection();
}

/** Return the indices of selected runs of a system. */
function selectedOf(system) {
  const found = [];
  if (selection.runs && selection.system === system) selection.runs.forEach((flag, i) => flag && found.push(i));
  return found;
}

/** Write how many runs are selected, and list the first of them. */
function showSelection() {
  const system = contents.systems[selection.system];
  const found = selectedOf(selection.system);
  const text = document.getElementById("selected");
  const place = document.getElementById("runs-selected");
  place.replaceChildren();
  text.textContent = selection.runs ? `${found.length} of ${system.runs} runs selected` : "";
  document.getElementById("clear").disabled = !selection.runs;
  if (!found.length) return;
  const numbers = numbersOf(system), columns = shownColumns();
  const head = ["run", ...columns.map(labelOf)];
  const body = make("tbody");
  for (const i of found.slice(0, MOST_LISTED)) {
    const cells = columns.map((c) => {
      const v = valuesOf(c)[i];
      if (Number.isNaN(v)) return "failed";
      return c.categories ? c.categories[Math.round(v)] : formatNumber(v);
    });
    body.append(make("tr", {}, ...[String(numbers[i]), ...cells].map((cell) => make("td", { textContent: cell }))));
  }
  const header = make("thead", {}, make("tr", {}, ...head.map((cell) => make("th", { textContent: cell, scope: "col" }))));
  place.append(make("table", {}, header, body));
  if (found.length > MOST_LISTED) place.append(make("p", { className: "note", textContent: `and ${found.length - MOST_LISTED} more` }));
}
