// Figures as text for people. What is not a finite number, such as a null of a report, is "not finite".

const NOT_FINITE = "not finite";

/** Returns three significant digits of a value of at least 0.001. @param {number} value */
function threeDigits(value) {
  // The limits are the values from which rounding carries into the next decade.
  const size = Math.abs(value);
  return value.toFixed(size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.9995 ? 2 : 3);
}

/** Returns "1,234,567". @param {number} count */
export function countText(count) {
  return String(count).replace(/\B(?=(\d{3})+$)/g, ",");
}

/** Returns "1 asset" or "2 assets". @param {number} count @param {string} what one of them */
export function counted(count, what) {
  return `${count} ${what}${count === 1 ? "" : "s"}`;
}

/** Returns three significant digits in the unit that fits: "0 B", "21.3 KiB", "1020 KiB". @param {number} bytes */
export function bytesText(bytes) {
  if (bytes < 1024) return `${Math.round(bytes)} B`;
  let value = bytes / 1024, unit = 0;
  for (; value >= 1023.5 && unit < 5; ++unit) value /= 1024;
  return `${threeDigits(value)} ${["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"][unit]}`;
}

/** Returns "0 s", "0.250 ms", "340 ms", "12.3 s", "2 min 05 s", "1 h 02 min". @param {number} seconds */
export function secondsText(seconds) {
  if (!Number.isFinite(seconds)) return NOT_FINITE;
  if (seconds === 0) return "0 s";
  if (seconds < 0.9995) return seconds < 1e-6 ? "< 0.001 ms" : `${threeDigits(1e3 * seconds)} ms`;
  if (seconds < 59.95) return `${threeDigits(seconds)} s`;
  const whole = Math.round(seconds), two = (/** @type {number} */ value) => String(Math.floor(value)).padStart(2, "0");
  return whole < 3600 ? `${Math.floor(whole / 60)} min ${two(whole % 60)} s` : `${Math.floor(whole / 3600)} h ${two((whole % 3600) / 60)} min`;
}

/** Returns a ratio in percent: "1.23 %", "0.412 %", "< 0.001 %", "340 %". @param {number} ratio */
export function percentText(ratio) {
  if (!Number.isFinite(ratio)) return NOT_FINITE;
  const percent = 100 * ratio;
  if (percent === 0) return "0 %";
  if (Math.abs(percent) < 0.001) return percent > 0 ? "< 0.001 %" : "> -0.001 %";
  return `${Math.abs(percent) >= 1e6 ? percent.toPrecision(3) : threeDigits(percent)} %`;
}

/** Returns a value with so many significant digits, without zeros at its end. @param {number} value @param {number} [digits] */
export function shortText(value, digits = 3) {
  if (!Number.isFinite(value)) return NOT_FINITE;
  const rounded = Number(value.toPrecision(digits));
  return rounded !== 0 && Math.abs(rounded) < 1e-4 ? rounded.toExponential() : String(rounded);
}

/** Returns three significant digits without a unit: "8.00", "0.0123". @param {number} value */
export function numberText(value) {
  const isPlain = Math.abs(value) >= 0.1 && Math.abs(value) < 1e6;
  return Number.isFinite(value) && isPlain ? threeDigits(value) : shortText(value);
}

/** Returns a visible error. @param {number} value [Delta E ITP] */
export function visibleText(value) {
  return Number.isFinite(value) ? value.toFixed(2) : NOT_FINITE;
}

/** Returns all digits. @param {number} value */
export function exactText(value) {
  return Number.isFinite(value) ? String(value) : NOT_FINITE;
}
