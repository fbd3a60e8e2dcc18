// Offer a file that was made on the page as a download.
import { exactSingle } from '../ui/format'
import type { Pixels } from './mapImage'

const CELL_PX = 16
const LONGEST_PX = 2400

export function saveBlob(name: string, blob: Blob): void {
  const link = document.createElement('a')
  link.href = URL.createObjectURL(blob)
  link.download = name.replaceAll(/[^\w.-]+/g, '_')
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000)
}

export function saveText(name: string, text: string, type: string): void {
  saveBlob(name, new Blob([text], { type }))
}

/** A drawing as PNG, as large as a slide. */
export async function savePng(name: string, svg: string): Promise<void> {
  const image = new Image()
  image.src = `data:image/svg+xml,${encodeURIComponent(svg)}`
  await image.decode()
  const scale = LONGEST_PX / Math.max(image.width, image.height)
  const canvas = new OffscreenCanvas(image.width * scale, image.height * scale)
  canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height)
  saveBlob(name, await canvas.convertToBlob())
}

/** The pixels, each as a sharp-edged rectangle. */
export function enlarged({ width, height, data }: Pixels, aspect: number): OffscreenCanvas {
  const small = new OffscreenCanvas(width, height)
  small.getContext('2d')?.putImageData(new ImageData(new Uint8ClampedArray(data), width, height), 0, 0)
  const canvas = new OffscreenCanvas(width * CELL_PX, Math.round(height * CELL_PX * aspect))
  const ctx = canvas.getContext('2d')
  if (ctx) {
    ctx.imageSmoothingEnabled = false
    ctx.drawImage(small, 0, 0, canvas.width, canvas.height)
  }
  return canvas
}

/** Rows as CSV (RFC 4180). */
export function csv(head: readonly string[], rows: readonly (readonly unknown[])[]): string {
  const cell = (value: unknown): string => {
    const text = value === null || value === undefined || Number.isNaN(value) ? '' : typeof value === 'number' && Math.fround(value) === value ? exactSingle(value) : String(value)
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text
  }
  return [head, ...rows].map((row) => row.map(cell).join(',')).join('\r\n') + '\r\n'
}
