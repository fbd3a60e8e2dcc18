// What the templates are called on the page, and a picture of each: strokes on a field of 48 by 32.

interface Picture {
  title: string
  path: string
}

const GRID = [6, 14, 22, 30, 38].flatMap((x) => [7, 16, 25].map((y) => `M${String(x)} ${String(y)}h4`)).join('')
const WELLS = [8, 16, 24, 32, 40].flatMap((x) => [9, 16, 23].map((y) => `M${String(x - 2)} ${String(y)}a2 2 0 1 0 4 0a2 2 0 1 0-4 0`)).join('')

const PICTURES: Readonly<Record<string, Picture>> = {
  grid_scan: { title: 'Map a core', path: `M2 2h44v28h-44z${GRID}` },
  line_scan: { title: 'A line across', path: 'M2 26c8-18 36-22 44-10M6 16h36M6 14v4M15 14v4M24 14v4M33 14v4M42 14v4' },
  single: { title: 'One place', path: 'M24 4v8M24 20v8M10 16h10M28 16h10M20 16a4 4 0 1 0 8 0a4 4 0 1 0-8 0' },
  fill_plate: { title: '96 wells', path: `M2 3h41l3 3v23h-44z${WELLS}` },
  dispense: { title: 'Dispense and weigh', path: 'M24 2v8l-2 4h4l-2-4M24 17v2M14 20v7h20v-7M8 30h32M12 27h24v3h-24z' },
  titrate: { title: 'Titrate', path: 'M4 28h40M4 28v-26M7 25c14-1 16-2 17-10c1-8 4-9 18-10M24 15h0' },
  calibrate_camera: { title: 'Calibrate a camera', path: 'M4 8h8l3-4h8l3 4h6v18h-28zM13 17a5 5 0 1 0 10 0a5 5 0 1 0-10 0M36 8h10v18h-10zM36 14h10M36 20h10M41 8v18' },
  minimal: { title: 'Smallest, explained', path: 'M8 4h24l8 8v16h-32zM32 4v8h8M14 14h12M14 19h20M14 24h16' },
}

const SHEET = 'M8 4h24l8 8v16h-32zM32 4v8h8'

export function pictureOf(template: string): Picture {
  return PICTURES[template] ?? { title: template.replaceAll('_', ' '), path: SHEET }
}
