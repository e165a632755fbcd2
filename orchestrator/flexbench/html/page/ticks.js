// Ticks and numbers of axes.

/** Return the step between ticks of an axis: 1, 2 or 5 times a power of ten. */
function stepFor(span, most) {
  const raw = span / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(raw));
  for (const factor of [1, 2, 5]) if (factor * power >= raw * 0.999) return factor * power;
  return 10 * power;
}

/** Format a number with few digits, with an exponent only if needed. */
function formatNumber(value, digits = 4) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
}

/** Format a power of ten with raised digits. */
function powerOfTen(power) {
  return `10${String(power).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻")}`;
}

/**
 * Return value and text of the ticks of a logarithmic axis between two powers of ten, all of one notation: over two
 * decades or more whole powers, seven at most; else 1, 2 and 5 times them; in less room even steps.
 */
function logarithmicTicks(low, high) {
  const ticks = [], factors = high - low >= 2 ? [1] : [1, 2, 5];
  const every = Math.max(1, Math.ceil((high - low) / 7));
  for (let power = Math.floor(low); power <= high; power += every) for (const factor of factors) {
    const value = factor * 10 ** power;
    if (value >= 10 ** low * (1 - 1e-9) && value <= 10 ** high * (1 + 1e-9)) ticks.push([factor, power]);
  }
  if (ticks.length < 2) {
    const power = Math.floor(high), from = 10 ** (low - power), to = 10 ** (high - power), step = stepFor(to - from, 4);
    ticks.length = 0;
    for (let k = Math.ceil(from / step); k * step <= to; k++) ticks.push([Number((k * step).toPrecision(3)), power]);
  }
  const decimal = ticks.every(([, power]) => power >= -3 && power <= 3);
  return ticks.map(([factor, power]) => {
    const value = factor * 10 ** power;
    return [value, decimal ? String(Number(value.toPrecision(3))) : `${factor === 1 ? "" : `${factor}·`}${powerOfTen(power)}`];
  });
}
