// Numbers for people. An unknown value is a dash, never NaN.

const dash = '–';
const minus = (words) => words.replace(/-/g, '\u2212');

export function number(value, digits = 5) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return dash;
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    return minus(`${mantissa.includes('.') ? mantissa.replace(/\.?0+$/, '') : mantissa}e${Number(exponent)}`);
  }
  return minus(String(Number(value.toPrecision(digits))));
}

export function percent(share, digits = 3) {
  if (typeof share !== 'number' || !Number.isFinite(share)) return dash;
  const words = number(100 * share, digits);
  return `${share > 0 ? '+' : ''}${words} %`;
}

/** From a to b, relative to a. */
export const change = (a, b) =>
  (Number.isFinite(a) && Number.isFinite(b) && a !== 0 && a !== null && b !== null ? percent((b - a) / Math.abs(a)) : dash);

export function duration(seconds) {
  if (typeof seconds !== 'number' || !Number.isFinite(seconds)) return dash;
  if (seconds < 90) return `${number(seconds, seconds < 1 ? 2 : 3)} s`;
  const whole = Math.round(seconds);
  const hours = Math.floor(whole / 3600), minutes = Math.floor(whole / 60) % 60;
  return hours > 0 ? `${hours} h ${minutes} min` : `${minutes} min ${whole % 60} s`;
}

/** A parameter of the program; angles in degrees. */
export const parameterValue = (value, unit) =>
  (unit === 'rad' && typeof value === 'number' ? `${number((value * 180) / Math.PI)}°` : number(value));

export const plural = (count, word) => `${count} ${word}${count === 1 ? '' : 's'}`;
