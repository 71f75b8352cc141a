// Lengths and times as text. Lower bounds are rounded down.

const DIGITS = 4;

// The unit of lengths, and its size in m. main.js sets it to the unit of the scene.
const lengthUnit = { name: "m", metres: 1 };

// Returns a length in m as text in the unit of the scene; `round` is Math.round, or Math.floor for lower bounds.
function lengthText(metres, round = Math.round) {
  return numberText(metres / lengthUnit.metres, round);
}

// Returns a length in the unit of the scene as text.
function numberText(value, round = Math.round) {
  if (!(value > 0)) return "0";
  const step = 10 ** (Math.floor(Math.log10(value)) + 1 - DIGITS);
  const number = Number((round(value / step) * step).toPrecision(DIGITS));
  return `${number < 1e-4 || number >= 1e15 ? number.toExponential().replace("+", "") : number} ${lengthUnit.name}`;
}

// Returns a time in s as text with at least some digits, or with more if microseconds need them.
function timeText(seconds, least = 6) {
  const digits = Math.abs(seconds) >= 1e5 ? Math.floor(Math.log10(Math.abs(seconds))) + 7 : least;
  return `${Number(seconds.toPrecision(digits))} s`;
}
