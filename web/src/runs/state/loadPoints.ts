// The points of a run's loops, loaded in windows; inner loops for each known iteration around them.
import { api, read } from '../../api/client'
import type { RunPicture } from '../picture'

const WINDOW = 10_000
/** Load no more points than this at once; the newest come with patches. */
const MOST = 200_000
const MOST_TURNS = 60

/** Fill the tables of a new picture. */
export async function loadPoints(picture: RunPicture): Promise<void> {
  const loops = [...picture.detail.loops].sort((a, b) => stars(a.path) - stars(b.path))
  for (const { path } of loops) {
    for (const within of turns(picture, path)) await loadTable(picture, path, within)
  }
}

async function loadTable(picture: RunPicture, loop: string, within: string): Promise<void> {
  let offset = 0
  let total: number | null = WINDOW
  while (offset < Math.min(total ?? 0, MOST)) {
    const window = await read(
      api.GET('/api/v1/runs/{id}/points', {
        params: { path: { id: picture.detail.id }, query: { loop, within, offset, limit: WINDOW } },
      }),
    )
    if (window.index.length) picture.load(loop, within, window)
    total = window.total ?? 0
    offset += WINDOW
    if (window.index.length < WINDOW) return
  }
}

/** The iterations around a loop whose points are known: `''` for an outermost one. */
function turns(picture: RunPicture, loop: string): string[] {
  const outer = outerLoop(picture, loop)
  if (outer === null) return ['']
  const found: string[] = []
  for (const table of picture.tables.get(outer) ?? [])
    for (const key of table.keys) if (key != null) found.push(table.within ? `${table.within}/${key}` : key)
  return found.slice(-MOST_TURNS)
}

function outerLoop(picture: RunPicture, loop: string): string | null {
  const around = picture.detail.loops
    .map((one) => one.path)
    .filter((path) => path !== loop && loop.startsWith(`${path}/*`))
  return around.sort((a, b) => b.length - a.length)[0] ?? null
}

function stars(path: string): number {
  return path.split('*').length
}
