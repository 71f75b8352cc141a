// Lengths and times in words. Lower bounds are rounded down, so that they stay true.

const UNITS = [
  ["km", 1e3, 1e4],
  ["m", 1, 1],
  ["mm", 1e-3, 1e-3],
  ["µm", 1e-6, 1e-6],
  ["nm", 1e-9, 0],
];
const DIGITS = 4;

// Returns a length in m as text; `round` is Math.round, or Math.floor for bounds.
function lengthText(metres, round = Math.round) {
  if (!(metres > 0)) return "0";
  const [unit, size] = UNITS.find(([, , from]) => metres >= from);
  const value = metres / size;
  const step = 10 ** (Math.floor(Math.log10(value)) + 1 - DIGITS);
  return `${Number((round(value / step) * step).toPrecision(DIGITS))} ${unit}`;
}

// Returns the unit that fits a length, as its name and m.
function unitOf(metres) {
  const [unit, size] = UNITS.find(([, , from]) => metres >= from);
  return { unit, size };
}

// Returns a time in s as text, in so many digits, or in whole microseconds where those are more.
function timeText(seconds, least = 6) {
  const digits = Math.abs(seconds) >= 1e5 ? Math.floor(Math.log10(Math.abs(seconds))) + 7 : least;
  return `${Number(seconds.toPrecision(digits))} s`;
}
