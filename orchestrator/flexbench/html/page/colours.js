// Colours of what is drawn, for light and dark screens and for paper.

const darkScreen = matchMedia("(prefers-color-scheme: dark)");
// Series: Okabe and Ito (2008), distinguishable with colour-vision deficiencies, the grey last; lighter on a dark page
const LIGHT = { ink: "#333b45", grid: "#e3e6ea", rule: "#9aa3ad", paper: "#ffffff", limit: "#b00020", selected: "#d55e00",
  systems: ["#0072b2", "#009e73", "#cc79a7", "#7a5195"], undeformed: "#c9ced6", cursor: "#888888",
  series: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#444444"] };
const DARK = { ink: "#c6ced8", grid: "#2c3540", rule: "#6b7683", paper: "#161b22", limit: "#ff8a8a", selected: "#ffab5e",
  systems: ["#6cb8ee", "#4fd1a5", "#eaa5cb", "#b9a0e0"], undeformed: "#55606d", cursor: "#9aa6b4",
  series: ["#5eb0ea", "#ff9248", "#3fcf9f", "#eaa5cb", "#f2bd4b", "#9bd5f7", "#bb9ee2", "#aab4bf"] };
let printing = false;

/** Return the colours of the page as it is shown, or printed. */
function colours() {
  return darkScreen.matches && !printing ? DARK : LIGHT;
}
