// The location of a value in a protocol: its keys and indexes from the top, and as a JSON Pointer.

export type Path = readonly (string | number)[]

/** `/steps/0/with/x` (RFC 6901). */
export function toPointer(path: Path): string {
  return path.map((part) => `/${String(part).replaceAll('~', '~0').replaceAll('/', '~1')}`).join('')
}

/** Parts that are whole numbers become indexes only where `data` holds a list. */
export function fromPointer(pointer: string, data: unknown): Path {
  const path: (string | number)[] = []
  let here = data
  for (const raw of pointer.split('/').slice(1)) {
    const part = raw.replaceAll('~1', '/').replaceAll('~0', '~')
    const key = Array.isArray(here) ? Number(part) : part
    path.push(key)
    here = child(here, key)
  }
  return path
}

export function samePath(a: Path, b: Path): boolean {
  return a.length === b.length && startsWith(a, b)
}

/** Whether `path` is `root` or inside it. */
export function startsWith(path: Path, root: Path): boolean {
  return root.length <= path.length && root.every((part, i) => part === path[i])
}

export function child(data: unknown, part: string | number): unknown {
  if (Array.isArray(data)) return typeof part === 'number' ? (data as unknown[])[part] : undefined
  if (isMap(data)) return Object.hasOwn(data, part) ? data[part] : undefined
  return undefined
}

export function valueAt(data: unknown, path: Path): unknown {
  return path.reduce(child, data)
}

export function isMap(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value)
}
