// The ground under a path: allowed area, keep-out boxes and ruler.
import type { Received } from '../../api/types'
import type { Frame } from './drawing'
import type { Photograph } from './photograph'

/** Around the picture, for the rulers. */
export const MARGIN = 34

export type Colour = (name: string) => string
type Track = Received<'Track'>

/** A box in pixels; if unbounded, it reaches `pad` beyond the picture. */
function rectOf(box: Track['area'], frame: Frame, pad: number): [number, number, number, number] {
  const [left, right] = [box.x0 === null ? -pad : frame.px(box.x0), box.x1 === null ? frame.width + pad : frame.px(box.x1)]
  const [top, bottom] = [box.y1 === null ? -pad : frame.py(box.y1), box.y0 === null ? frame.height + pad : frame.py(box.y0)]
  return [left, top, right - left, bottom - top]
}

/** Up to the rulers, which stay readable. */
function drawPhotograph(brush: CanvasRenderingContext2D, { picture, x, y, width, height }: Photograph, frame: Frame): void {
  brush.save()
  brush.beginPath()
  brush.rect(MARGIN, 0, frame.width, frame.height - MARGIN)
  brush.clip()
  brush.drawImage(picture, frame.px(x), frame.py(y + height), width * frame.scale, height * frame.scale)
  brush.restore()
}

/** The area that the bench allows is light; beyond it the contract may allow more, which is hatched. */
export function drawArea(brush: CanvasRenderingContext2D, { area, allowed }: Track, frame: Frame, colour: Colour, photograph: Photograph | null): void {
  brush.save()
  brush.beginPath()
  brush.rect(...rectOf(allowed, frame, 10))
  brush.clip()
  brush.strokeStyle = colour('line')
  brush.beginPath()
  for (let at = -frame.height; at < frame.width; at += 9) {
    brush.moveTo(at, frame.height)
    brush.lineTo(at + frame.height, 0)
  }
  brush.stroke()
  brush.restore()
  brush.fillStyle = colour('bg')
  brush.fillRect(...rectOf(area, frame, 10))
  if (photograph) drawPhotograph(brush, photograph, frame)
  brush.strokeStyle = colour('fail')
  brush.lineWidth = 1.5
  brush.setLineDash([6, 4])
  brush.strokeRect(...rectOf(area, frame, 10))
  brush.setLineDash([])
  brush.lineWidth = 1
}

/** Round millimetres along both edges. */
export function drawRuler(brush: CanvasRenderingContext2D, frame: Frame, colour: string): void {
  const wanted = 70 / frame.scale
  const power = 10 ** Math.floor(Math.log10(wanted))
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= wanted) ?? power * 10
  const digits = Math.max(0, -Math.floor(Math.log10(step)))
  brush.fillStyle = brush.strokeStyle = colour
  brush.font = '11px system-ui, sans-serif'
  brush.textAlign = 'center'
  for (let x = Math.ceil(frame.xOf(20) / step) * step; frame.px(x) < frame.width - 20; x += step) {
    brush.fillText(x.toFixed(digits), frame.px(x), frame.height - 6)
    brush.fillRect(frame.px(x), frame.height - 20, 1, 4)
  }
  brush.textAlign = 'left'
  for (let y = Math.ceil(frame.yOf(frame.height - 30) / step) * step; frame.py(y) > 12; y += step) {
    brush.fillText(y.toFixed(digits), 4, frame.py(y) + 4)
  }
  brush.fillText('mm', 4, frame.height - 6)
}

/** Boxes that the machine does not enter, each with its name; some reach all along an axis. */
export function drawKeptOut(brush: CanvasRenderingContext2D, boxes: Track['keep_out'], frame: Frame, colour: Colour): void {
  for (const box of boxes) {
    const rect = rectOf(box, frame, 2)
    brush.fillStyle = colour('fail-bg')
    brush.strokeStyle = colour('fail')
    brush.fillRect(...rect)
    brush.strokeRect(...rect)
    brush.fillStyle = colour('fail')
    brush.font = '11px system-ui, sans-serif'
    brush.textAlign = 'left'
    brush.fillText(`✕ ${box.name}`, Math.max(rect[0], 0) + 4, Math.max(rect[1], 0) + 14)
  }
}
