// Numbers with fractions in messages: the module sends their bits, since what writes them in digits is the browser's already.

const bits = new DataView(new ArrayBuffer(8));

// The fewest digits that are this f32 and no other.
function shortest(v) {
  for (let digits = 0; ; digits++) {
    const text = v.toExponential(digits);
    if (Math.fround(Number(text)) === v) return text;
  }
}

// As the engine writes them where it has digits of its own.
function written(form, v) {
  if (!Number.isFinite(v)) return String(v).replace('Infinity', 'inf');
  const sign = v < 0 || Object.is(v, -0) ? '-' : '';
  const abs = Math.abs(v);
  const forms = {
    e: () => shortest(abs).replace('e+', 'e'),
    x: () => abs.toExponential().replace('e+', 'e'),
    p: () => String(Number(shortest(abs))),
    q: () => String(abs),
  };
  return sign + (forms[form]?.() ?? abs.toFixed(Number(form)));
}

/** A text of the module with its numbers in digits. */
export const inDigits = (text) => text.replace(/\x01(\w)([0-9a-f]+);/g, (_, form, hex) => {
  bits.setBigUint64(0, BigInt(`0x${hex}`));
  return written(form, bits.getFloat64(0));
});
