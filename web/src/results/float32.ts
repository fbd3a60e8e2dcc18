// Numbers in bulk as the server sends them: little-endian Float32, one after the other.

const LITTLE = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1

/** The numbers of an answer; `count`, where known, is how many there must be. */
export function decodeFloat32(bytes: ArrayBuffer, count?: number): Float32Array {
  if (bytes.byteLength % 4 !== 0) throw new RangeError(`${bytes.byteLength} bytes are not Float32 values`)
  const found = bytes.byteLength / 4
  if (count !== undefined && found !== count) throw new RangeError(`${found} values received, ${count} expected`)
  if (LITTLE) return new Float32Array(bytes)
  const view = new DataView(bytes)
  return Float32Array.from({ length: found }, (_, i) => view.getFloat32(i * 4, true))
}

export interface Fit {
  background: Float32Array
  fit: Float32Array
  residual: Float32Array
}

/** Background, fit and residual come one after the other, each as long as the axis. */
export function decodeFit(bytes: ArrayBuffer): Fit {
  const all = decodeFloat32(bytes)
  if (all.length % 3 !== 0) throw new RangeError(`${all.length} values are not three curves`)
  const size = all.length / 3
  return {
    background: all.subarray(0, size),
    fit: all.subarray(size, 2 * size),
    residual: all.subarray(2 * size),
  }
}
