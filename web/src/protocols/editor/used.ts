// The steps of used protocols, shown where they are used.
import { shallowRef } from 'vue'
import { api, read as ask } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import { toPointer, valueAt } from '../text/path'
import { read } from '../text/reading'
import { rowsOf, type Row } from '../text/rows'

/** A row of the outline; those of another file are read-only. */
export interface Line extends Row {
  file?: string
  /** Its number among the rows of this file; left out if no other file is shown. */
  own?: number
}

/** The rows of its steps; `skipped` rows come before them. */
export interface Used {
  file: string
  rows: Row[]
  skipped: number
}

/** The file that a `use` names, relative to the file that contains it. */
export function fileOf(name: string, use: string): string {
  const parts = [...name.split('/').slice(0, -1), ...use.split('/')]
  const path: string[] = []
  for (const part of parts) {
    if (part === '..') path.pop()
    else if (part !== '.') path.push(part)
  }
  return path.join('/')
}

export function useUsed(name: string, refuse: (reason: string) => void) {
  /** Pointer of a `use` step -> the rows of the other protocol. */
  const opened = shallowRef<ReadonlyMap<string, Used>>(new Map())

  async function toggle(row: Row, data: unknown): Promise<void> {
    const key = toPointer(row.path)
    const now = new Map(opened.value)
    if (!now.delete(key)) {
      const file = fileOf(name, String(valueAt(data, [...row.path, 'use'])))
      try {
        const told = await ask(api.GET('/api/v1/protocols/{name}', { params: { path: { name: file } } }))
        const reading = read(told.text)
        if (!reading.ok) throw new Error(`${file} has an error on line ${String(reading.line)}`)
        const all = rowsOf(reading)
        const skipped = all.filter((one) => one.kind === 'about' || one.kind === 'params' || one.kind === 'devices').length
        now.set(key, { file, rows: all.slice(skipped), skipped })
      } catch (failure) {
        refuse(sentenceOf(failure))
        return
      }
    }
    opened.value = now
  }

  return { opened, toggle }
}

/** The rows with those of opened protocols below the steps that use them. */
export function withUsed(rows: readonly Row[], opened: ReadonlyMap<string, Used>): readonly Line[] {
  if (opened.size === 0) return rows
  const lines: Line[] = []
  const placed = new Int32Array(rows.length + 1)
  for (const [own, row] of rows.entries()) {
    placed[own] = lines.length
    lines.push({ ...row, own })
    const used = row.kind === 'use' ? opened.get(toPointer(row.path)) : undefined
    if (used) addUsed(lines, row, used)
  }
  placed[rows.length] = lines.length
  for (const line of lines) {
    if (line.file !== undefined) continue
    line.parent = line.parent < 0 ? -1 : (placed[line.parent] ?? -1)
    line.end = placed[line.end] ?? lines.length
  }
  return lines
}

function addUsed(lines: Line[], row: Row, { file, rows, skipped }: Used): void {
  const base = lines.length - skipped
  for (const inner of rows) {
    const path = [...row.path, `${file}:${toPointer(inner.path)}`]
    const parent = inner.parent < 0 ? base + skipped - 1 : base + inner.parent
    lines.push({ ...inner, path, file, level: row.level + inner.level, parent, end: base + inner.end })
  }
}
