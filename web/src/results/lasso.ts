// Which cells of a map are in a box or inside a freehand line.

export interface Place {
  x: number
  y: number
}

/** Cells are counted row by row from the lowest y; places are in cells, (0, 0) the centre of the first. */
export interface Plane {
  width: number
  height: number
}

/** All cells between two corners, both included, in any order. */
export function cellsInBox(plane: Plane, a: Place, b: Place): number[] {
  const [left, right] = between(a.x, b.x, plane.width)
  const [bottom, top] = between(a.y, b.y, plane.height)
  const found: number[] = []
  for (let row = bottom; row <= top; row++)
    for (let column = left; column <= right; column++) found.push(row * plane.width + column)
  return found
}

function between(a: number, b: number, size: number): [number, number] {
  const low = Math.max(0, Math.round(Math.min(a, b)))
  return [low, Math.min(size - 1, Math.round(Math.max(a, b)))]
}

/** Cells whose centre is inside the line (even-odd rule); the line is closed automatically. */
export function cellsInLasso(plane: Plane, line: readonly Place[]): number[] {
  if (line.length < 3) return []
  const found: number[] = []
  for (let row = 0; row < plane.height; row++) {
    const crossings = crossingsAt(line, row)
    for (let i = 0; i + 1 < crossings.length; i += 2) {
      const first = Math.max(0, Math.ceil(crossings[i] ?? Infinity))
      const last = Math.min(plane.width - 1, Math.floor(crossings[i + 1] ?? -Infinity))
      for (let column = first; column <= last; column++) found.push(row * plane.width + column)
    }
  }
  return found
}

function crossingsAt(line: readonly Place[], y: number): number[] {
  const found: number[] = []
  line.forEach((a, i) => {
    const b = line[(i + 1) % line.length] ?? a
    if (a.y <= y !== b.y <= y) found.push(a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x))
  })
  return found.sort((p, q) => p - q)
}
