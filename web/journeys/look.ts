// Run axe-core on the current page, and take pictures of it.
import { readFileSync } from 'node:fs'
import { mkdir } from 'node:fs/promises'
import { createRequire } from 'node:module'
import { join } from 'node:path'
import type { Page } from 'playwright-core'

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8')
const RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']

interface Found {
  id: string
  help: string
  nodes: { target: unknown[]; failureSummary: string }[]
}

/** The violations that axe finds, one per line. */
export async function axe(page: Page): Promise<string[]> {
  // Evaluated by the debugger, which a page's script policy does not restrict.
  await page.evaluate(AXE)
  const found = (await page.evaluate(`axe.run(document, {runOnly: ${JSON.stringify(RULES)}, resultTypes: ['violations']}).then(r => r.violations)`)) as Found[]
  return found.flatMap((one) => one.nodes.map((node) => `${one.id}: ${node.target.join(' ')}: ${node.failureSummary.replaceAll('\n', ' ')}`))
}

/** Save a picture to PICTURES, if that is set. */
export async function picture(page: Page, name: string): Promise<void> {
  const folder = process.env['PICTURES']
  if (folder === undefined) return
  await mkdir(folder, { recursive: true })
  await page.screenshot({ path: join(folder, `${name}.png`) })
}
