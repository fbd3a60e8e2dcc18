// The ground under a path: what the bench allows, what it keeps out of, and the ruler.
import type { Told } from '../../api/types'
import type { Frame } from './drawing'

export type Colour = (name: string) => string
type Track = Told<'Track'>

/** What the bench allows is light; beyond it the contract may allow more, which is hatched. */
export function drawArea(brush: CanvasRenderingContext2D, { area, allowed }: Track, frame: Frame, colour: Colour): void {
  const rect = (one: Track['area'], pad: number): [number, number, number, number] => {
    const [left, right] = [one.x0 === null ? -pad : frame.px(one.x0), one.x1 === null ? frame.width + pad : frame.px(one.x1)]
    const [top, bottom] = [one.y1 === null ? -pad : frame.py(one.y1), one.y0 === null ? frame.height + pad : frame.py(one.y0)]
    return [left, top, right - left, bottom - top]
  }
  brush.save()
  brush.beginPath()
  brush.rect(...rect(allowed, 10))
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
  brush.fillRect(...rect(area, 10))
  brush.strokeStyle = colour('fail')
  brush.lineWidth = 1.5
  brush.setLineDash([6, 4])
  brush.strokeRect(...rect(area, 10))
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
    const [left, right] = [box.x0 === null ? -2 : frame.px(box.x0), box.x1 === null ? frame.width + 2 : frame.px(box.x1)]
    const [top, bottom] = [box.y1 === null ? -2 : frame.py(box.y1), box.y0 === null ? frame.height + 2 : frame.py(box.y0)]
    brush.fillStyle = colour('fail-bg')
    brush.strokeStyle = colour('fail')
    brush.fillRect(left, top, right - left, bottom - top)
    brush.strokeRect(left, top, right - left, bottom - top)
    brush.fillStyle = colour('fail')
    brush.font = '11px system-ui, sans-serif'
    brush.textAlign = 'left'
    brush.fillText(`✕ ${box.name}`, Math.max(left, 0) + 4, Math.max(top, 0) + 14)
  }
}
