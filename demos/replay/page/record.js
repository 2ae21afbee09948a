// Inflates the two blobs in the file and turns the record's references into arrays.

function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

async function inflated(id) {
  const packed = new Blob([bytesOf(id)]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream('deflate'))).arrayBuffer();
}

const arrayTypes = {u8: Uint8Array, i8: Int8Array, u16: Uint16Array, i16: Int16Array, i32: Int32Array, u32: Uint32Array, f32: Float32Array};

// Replaces each {at, length, type} below `value` by an array over the buffer.
function withArrays(value, buffer, start) {
  if (value === null || typeof value !== 'object') return value;
  if (value.type in arrayTypes && 'at' in value)
    return new arrayTypes[value.type](buffer, start + value.at, value.length);
  for (const key of Object.keys(value)) value[key] = withArrays(value[key], buffer, start);
  return value;
}

function readRecord(buffer) {
  const length = new DataView(buffer).getUint32(4, true);
  const json = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  return withArrays(json, buffer, 8 + length);
}

// The last index with a time up to t; times ascend.
function indexAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

// The quantile of the positive numbers at `share`.
function quantile(numbers, share) {
  const positive = Array.from(numbers).filter(v => v > 0).sort((a, b) => a - b);
  return positive.length ? positive[Math.min(positive.length - 1, Math.floor(share * positive.length))] : 0;
}

function withUnit(value, unit) {
  if (!(Math.abs(value) > 0)) return '0 ' + unit;
  const steps = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, '\u00b5'], [1e-9, 'n']];
  const lengths = steps.filter(s => unit !== 'm' || s[0] <= 1);
  const [scale, prefix] = lengths.find(s => Math.abs(value) >= 0.9995 * s[0]) || lengths[lengths.length - 1];
  return Number((value / scale).toPrecision(3)) + ' ' + prefix + unit;
}
