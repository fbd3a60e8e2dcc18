// Numbers and times as people read them.

/** `12 s`, `4 min`, `2 h 05 min`, `3 d`. */
export function duration(seconds: number): string {
  const s = Math.max(0, Math.round(seconds))
  if (s < 60) return `${s} s`
  if (s < 3600) return `${Math.floor(s / 60)} min${s < 600 && s % 60 ? ` ${s % 60} s` : ''}`
  if (s < 48 * 3600) return `${Math.floor(s / 3600)} h ${String(Math.floor((s % 3600) / 60)).padStart(2, '0')} min`
  return `${Math.floor(s / 86_400)} d`
}

/** `1 point`, `1,071 points`. */
export function counted(count: number, one: string): string {
  return `${count.toLocaleString('en')} ${one}${count === 1 ? '' : 's'}`
}

/** `4:51`. */
export function countdown(seconds: number): string {
  const s = Math.max(0, Math.ceil(seconds))
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, '0')}`
}

/** The time of day; with the date unless it is today. */
export function clock(iso: string | null, now = new Date()): string {
  if (iso === null) return '–'
  const at = new Date(iso)
  if (Number.isNaN(at.getTime())) return '–'
  const time = at.toLocaleTimeString([], { hour: '2-digit', minute: '2-digit', hourCycle: 'h23' })
  if (at.toDateString() === now.toDateString()) return time
  return `${at.toLocaleDateString([], { day: 'numeric', month: 'short' })} ${time}`
}

/** With seconds, for what just happened. */
export function clockSeconds(iso: string | null): string {
  if (iso === null) return '–'
  return new Date(iso).toLocaleTimeString([], { hourCycle: 'h23' })
}

/** At most `digits` decimals, without trailing zeros. */
export function number(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return String(value)
  const size = Math.abs(value)
  if (size !== 0 && (size >= 1e7 || size < 10 ** -digits)) return value.toExponential(2)
  return String(Number(value.toFixed(digits))).replace('-', '−')
}

/** A typed number as programs read it, with or without a unit: `-0.5 mm` of `−0,5 mm`. */
export function pointed(text: string): string {
  return text.trim().replace(/^−/, '-').replace(/^([-+]?\d*),(\d+(?:e[-+]?\d+)?\s*(?:[^\s,\d][^,]*)?)$/i, '$1.$2')
}

/** Whether the text is a number and nothing else. */
export function isNumber(text: string): boolean {
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text) && Number.isFinite(Number(text))
}

/** The number that is typed; null if it is none. */
export function typedNumber(text: string): number | null {
  const plain = pointed(text)
  return isNumber(plain) ? Number(plain) : null
}

/** A number as it was measured, without the noise of its last binary digit. */
export function exact(value: number): string {
  return String(Number.isInteger(value) ? value : Number(value.toPrecision(15)))
}

/** A number where it is read: the digits that its error leaves, or six; a whole number has all of its own. */
export function figures(value: number, error = 0): string {
  const size = Math.abs(value)
  // Two digits of the error are as many as it is known to.
  const places = error > 0 && Number.isFinite(error) ? 1 - Math.floor(Math.log10(error)) : NaN
  if (Math.max(0, places) + Math.max(0, Math.log10(size)) < MOST_FIGURES) {
    return places > 0 ? value.toFixed(places).replace(/^-(0\.0+)$/, '$1') : String(Math.round(value * 10 ** places) * 10 ** -places)
  }
  if (Number.isInteger(value)) return String(value)
  return String(size >= 1e6 && size < 1e15 ? Math.round(value) : Number(value.toPrecision(6)))
}
const MOST_FIGURES = 10

/** The column that has the error of another: `area_err` of `area`, `temperature_error_k` of `temperature_k`. */
export function errorColumn(column: string, columns: readonly string[]): string | undefined {
  return columns.find((one) => {
    const [, stem = '', unit = ''] = /^(.+)_err(?:or)?(_.+)?$/.exec(one) ?? []
    return stem !== '' && (column === stem + unit || (unit === '' && !/_err/.test(column) && column.slice(0, column.lastIndexOf('_')) === stem))
  })
}

/** A value of a Float32Array as it was measured: the shortest number that is stored so. */
export function exactSingle(value: number): string {
  for (let digits = 1; digits < 9; digits++) {
    const short = Number(value.toPrecision(digits))
    if (Math.fround(short) === value) return String(short)
  }
  return exact(value)
}

/** A millimetre read-out: always two decimals, so that its width stays the same. */
export function mm(value: number): string {
  return value.toFixed(2).replace('-', '−')
}

export function bytes(size: number): string {
  if (size < 1000) return `${size} B`
  if (size < 1e6) return `${(size / 1e3).toFixed(1)} kB`
  return `${(size / 1e6).toFixed(1)} MB`
}

/** `Grid scan` of `grid-scan`: the name of a protocol, to be read. */
export function titleOf(name: string): string {
  const words = name.replace(/[-_]+/g, ' ').trim()
  return words.charAt(0).toUpperCase() + words.slice(1)
}
