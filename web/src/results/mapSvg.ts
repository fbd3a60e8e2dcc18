// A map as SVG with its axes and colour bar: sharp at any size, without external resources.
import { cellAspect } from './aspect'
import { figures } from '../ui/format'
import { cssColour, type ColourMap } from './colours'
import type { Pixels } from './mapImage'
import { ticks, type Scale } from './scale'
import type { MapHead } from './useResults'

/** The width of a map at least, so that its words are small beside it; of a cell at least. */
const [WIDE, CELL] = [400, 10]
const LEFT = 56
const BOTTOM = 44
const TOP = 28
const RIGHT = 90

/** `colours` is null if the colours are not a scale. */
export function mapSvg(head: Pick<MapHead, 'x' | 'y' | 'unit' | 'column'>, pixels: Pixels, scale: Scale, colours: ColourMap | null): string {
  const cell = Math.max(CELL, Math.floor(WIDE / pixels.width))
  const cellY = cell * cellAspect(head.x, head.y)
  const [w, h] = [pixels.width * cell, pixels.height * cellY]
  const parts = [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${LEFT + w + RIGHT}" height="${round(TOP + h + BOTTOM)}" font-family="sans-serif" font-size="12">`,
    '<rect width="100%" height="100%" fill="#ffffff"/>',
    `<text x="${LEFT}" y="18" font-size="14">${escaped(head.column)}</text>`,
    `<g shape-rendering="crispEdges">${rects(pixels, cell, cellY)}</g>`,
    `<rect x="${LEFT}" y="${TOP}" width="${w}" height="${round(h)}" fill="none" stroke="#57606a"/>`,
    ...ends(head.x, (share) => [LEFT + cell / 2 + share * (w - cell), TOP + h + 16, 'middle']),
    ...ends(head.y, (share) => [LEFT - 6, TOP + h - cellY / 2 - share * (h - cellY) + 4, 'end']),
    `<text x="${LEFT + w / 2}" y="${round(TOP + h + 34)}" text-anchor="middle">x (${escaped(head.unit)})</text>`,
    `<text x="16" y="${round(TOP + h / 2)}" text-anchor="middle" transform="rotate(-90 16 ${round(TOP + h / 2)})">y (${escaped(head.unit)})</text>`,
    colours ? bar(scale, colours, LEFT + w + 16, h) : '',
    '</svg>',
  ]
  return parts.filter(Boolean).join('\n') + '\n'
}

function rects({ width, height, data }: Pixels, cell: number, cellY: number): string {
  const found: string[] = []
  for (let i = 0; i < width * height; i++) {
    if (!data[i * 4 + 3]) continue
    const colour = [0, 1, 2].map((part) => (data[i * 4 + part] ?? 0).toString(16).padStart(2, '0')).join('')
    const y = TOP + Math.floor(i / width) * cellY
    found.push(`<rect x="${LEFT + (i % width) * cell}" y="${round(y)}" width="${cell}" height="${round(cellY)}" fill="#${colour}"/>`)
  }
  return found.join('')
}

function ends(places: readonly number[], at: (share: number) => [number, number, string]): string[] {
  return [0, 1].map((end) => {
    const [x, y, anchor] = at(end)
    return `<text x="${round(x)}" y="${round(y)}" text-anchor="${anchor}">${figures(places.at(end ? -1 : 0) ?? 0)}</text>`
  })
}

function bar(scale: Scale, colours: ColourMap, x: number, h: number): string {
  const stops = Array.from({ length: 17 }, (_, i) => `<stop offset="${i / 16}" stop-color="${cssColour(colours, 1 - i / 16)}"/>`)
  const marks = ticks(scale).map(({ share, text }) => `<text x="${x + 20}" y="${round(TOP + h - share * h + 4)}">${text}</text>`)
  return `<defs><linearGradient id="bar" x1="0" y1="0" x2="0" y2="1">${stops.join('')}</linearGradient></defs><rect x="${x}" y="${TOP}" width="14" height="${round(h)}" fill="url(#bar)"/>${marks.join('')}`
}

function round(value: number): number {
  return Math.round(value * 100) / 100
}

function escaped(text: string): string {
  return text.replaceAll('&', '&amp;').replaceAll('<', '&lt;')
}
