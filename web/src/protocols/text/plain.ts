// The same edits on plain data: the expected result of a patch.
import { isMap, type Path } from './path'

export function copyOf<T>(data: T): T {
  return structuredClone(data)
}

/** The list at a path of a copy; an empty one is added if a map has none. */
export function listAt(data: unknown, path: Path): unknown[] | null {
  let here: unknown = data
  for (const [i, part] of path.entries()) {
    if (Array.isArray(here)) here = (here as unknown[])[part as number]
    else if (isMap(here)) {
      if (i === path.length - 1 && here[part] == null) here[part] = []
      here = Object.hasOwn(here, part) ? here[part] : undefined
    } else return null
  }
  return Array.isArray(here) ? (here as unknown[]) : null
}

export function withValue(data: unknown, path: Path, value: unknown): unknown {
  const [part, ...rest] = path
  if (part === undefined) return value
  if (Array.isArray(data)) return (data as unknown[]).map((item, i) => (i === part ? withValue(item, rest, value) : item))
  const map = isMap(data) ? data : {}
  return { ...map, [part]: withValue(Object.hasOwn(map, part) ? map[part] : undefined, rest, value) }
}

export function without(data: unknown, path: Path): unknown {
  const [part, ...rest] = path
  if (part === undefined) return data
  const last = rest.length === 0
  if (Array.isArray(data)) {
    const list = data as unknown[]
    return last ? list.filter((_, i) => i !== part) : list.map((item, i) => (i === part ? without(item, rest) : item))
  }
  if (!isMap(data)) return data
  if (last) return Object.fromEntries(Object.entries(data).filter(([key]) => key !== String(part)))
  return { ...data, [part]: without(data[part], rest) }
}

/** The path of a value that is the very same object. */
export function pathOf(data: unknown, wanted: unknown, path: Path = []): Path | null {
  if (data === wanted) return path
  const inner: [string | number, unknown][] = Array.isArray(data)
    ? [...(data as unknown[]).entries()]
    : isMap(data) ? Object.entries(data) : []
  for (const [part, value] of inner) {
    if (typeof value !== 'object' || value === null) continue
    const found = pathOf(value, wanted, [...path, part])
    if (found) return found
  }
  return null
}
