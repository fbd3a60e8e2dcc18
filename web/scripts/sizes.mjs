// Compare what a browser loads, compressed, with the budgets; fail above them.
import { readdir, readFile } from 'node:fs/promises'
import { join } from 'node:path'
import { fileURLToPath } from 'node:url'

const FOLDER = fileURLToPath(new URL('../app-dist', import.meta.url))
const FIRST_KB = 150
const EDITOR_KB = 200
// Nobody loads all: what is rare has files of its own. It bounds how the whole grows.
const ALL_KB = 450

const html = await readFile(join(FOLDER, 'index.html'), 'utf8')
const names = (await readdir(join(FOLDER, 'assets'))).filter((name) => /\.(js|css)$/.test(name))
const content = new Map()
const size = new Map()
for (const name of names) {
  content.set(name, await readFile(join(FOLDER, 'assets', name), 'utf8'))
  const packed = join(FOLDER, 'assets', `${name}.gz`)
  const bytes = await readFile(packed).catch(() => readFile(join(FOLDER, 'assets', name)))
  size.set(name, bytes.length)
}

/** Everything that a file loads through static imports. */
function withImports(first) {
  const found = new Set()
  const waiting = [...first]
  while (waiting.length > 0) {
    const name = waiting.pop()
    if (found.has(name)) continue
    found.add(name)
    for (const [, from] of (content.get(name) ?? '').matchAll(/(?:from|import)\s*["']\.\/([^"']+)["']/g)) {
      waiting.push(from)
    }
  }
  return found
}

const kb = (set) => [...set].reduce((sum, name) => sum + (size.get(name) ?? 0), 0) / 1000
const entries = [...html.matchAll(/(?:src|href)="\/assets\/([^"]+)"/g)].map(([, name]) => name)
const first = withImports(entries)
const editors = names.filter((name) => /^EditorPage-.*\.(js|css)$/.test(name))
const editor = new Set([...withImports(editors)].filter((name) => !first.has(name)))

let over = false
function tell(what, is, most) {
  const word = is > most ? 'TOO LARGE' : 'ok'
  over ||= is > most
  process.stdout.write(`${what.padEnd(12)} ${is.toFixed(1).padStart(7)} kB gz of ${most}  ${word}\n`)
}
tell('first load', kb(first), FIRST_KB)
tell('editor', kb(editor), EDITOR_KB)
tell('all', kb(names), ALL_KB)
if (over) process.exit(1)
