// The layout of a map on its canvas: as large as fits, cells of equal size, y upwards.

export interface Frame {
  left: number
  top: number
  cellX: number
  cellY: number
  width: number
  height: number
}

const LARGEST_PX = 64

/** The frame of width × height cells in a box; `aspect` is the height of a cell over its width. */
export function frameIn(boxW: number, boxH: number, width: number, height: number, aspect = 1): Frame {
  const cell = Math.max(0.5, Math.min(boxW / width, boxH / (height * aspect), LARGEST_PX))
  const cellX = cell > 3 ? Math.floor(cell) : cell
  const cellY = cell > 3 ? Math.max(1, Math.floor(cell * aspect)) : cell * aspect
  return {
    left: Math.floor((boxW - cellX * width) / 2), top: Math.floor((boxH - cellY * height) / 2),
    cellX, cellY, width, height,
  }
}

/** The cell under a place of the canvas, -1 outside. */
export function cellAt(frame: Frame, px: number, py: number): number {
  const { x, y } = placeAt(frame, px, py)
  const [column, row] = [Math.round(x), Math.round(y)]
  if (column < 0 || row < 0 || column >= frame.width || row >= frame.height) return -1
  return row * frame.width + column
}

/** A place of the canvas in cells; (0, 0) is the centre of the lowest left one. */
export function placeAt(frame: Frame, px: number, py: number): { x: number; y: number } {
  return {
    x: (px - frame.left) / frame.cellX - 0.5,
    y: frame.height - 0.5 - (py - frame.top) / frame.cellY,
  }
}

/** The rectangle of a cell on the canvas. */
export function rectOf(frame: Frame, cell: number): [x: number, y: number, w: number, h: number] {
  const column = cell % frame.width
  const row = Math.floor(cell / frame.width)
  const y = frame.top + (frame.height - 1 - row) * frame.cellY
  return [frame.left + column * frame.cellX, y, frame.cellX, frame.cellY]
}

/** Where a key moves the cursor; null if it does not. */
export function moved(frame: { width: number; height: number }, cell: number, key: string): number | null {
  const column = cell % frame.width
  const row = Math.floor(cell / frame.width)
  const to = (c: number, r: number): number =>
    Math.min(frame.height - 1, Math.max(0, r)) * frame.width + Math.min(frame.width - 1, Math.max(0, c))
  switch (key) {
    case 'ArrowLeft': return to(column - 1, row)
    case 'ArrowRight': return to(column + 1, row)
    case 'ArrowUp': return to(column, row + 1)
    case 'ArrowDown': return to(column, row - 1)
    case 'Home': return to(0, row)
    case 'End': return to(frame.width - 1, row)
    case 'PageUp': return to(column, row + 10)
    case 'PageDown': return to(column, row - 10)
    default: return null
  }
}
