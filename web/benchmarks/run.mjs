// Measure the page in a real browser and print every figure: `npm run bench`.
import { existsSync } from 'node:fs'
import { mkdtemp, readFile, rm } from 'node:fs/promises'
import { createServer } from 'node:http'
import { tmpdir } from 'node:os'
import { extname, join } from 'node:path'
import { fileURLToPath } from 'node:url'
import { chromium } from 'playwright-core'
import { build } from 'vite'
import vue from '@vitejs/plugin-vue'

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css' }
const BROWSERS = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome']

const folder = await mkdtemp(join(tmpdir(), 'labrun-bench-'))
await build({
  root: fileURLToPath(new URL('./page', import.meta.url)), base: './', plugins: [vue()], logLevel: 'error', configFile: false,
  define: { __VUE_OPTIONS_API__: 'false', __VUE_PROD_DEVTOOLS__: 'false' }, build: { outDir: folder, emptyOutDir: true, target: 'es2022' },
})
const server = createServer(async (request, response) => {
  const name = request.url === '/' ? '/index.html' : new URL(request.url, 'http://bench').pathname
  try {
    const file = await readFile(join(folder, name))
    response.writeHead(200, { 'content-type': TYPES[extname(name)] ?? 'application/octet-stream' }).end(file)
  } catch {
    response.writeHead(404).end()
  }
})
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve))
const browser = await chromium.launch({ executablePath: BROWSERS.find((one) => one && existsSync(one)), args: ['--no-sandbox', '--disable-dev-shm-usage'] })

const share = (sorted, part) => sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))]
let over = false
try {
  for (const what of process.argv.length > 2 ? process.argv.slice(2) : ['first', 'outline', 'spectrum', 'map', 'hour']) {
    const page = await browser.newPage({ viewport: { width: 1360, height: 860 } })
    const faults = []
    page.on('pageerror', (error) => faults.push(error.message))
    // Vue tells what a view throws there.
    page.on('console', (told) => told.type() === 'error' && !told.location().url.endsWith('/favicon.ico') && faults.push(told.text()))
    const debug = await page.context().newCDPSession(page)
    await page.exposeFunction('heapUsed', async () => {
      await debug.send('HeapProfiler.collectGarbage')
      return (await debug.send('Runtime.getHeapUsage')).usedSize
    })
    await page.goto(`http://127.0.0.1:${server.address().port}/`)
    await page.waitForFunction('window.measure !== undefined')
    const { title, ms, budget_ms, unit = 'ms' } = await page.evaluate((name) => window.measure(name), what)
    await page.close()
    const sorted = [...ms].sort((a, b) => a - b)
    const p95 = share(sorted, 0.95)
    over ||= p95 > budget_ms || faults.length > 0
    const figures = [['median', share(sorted, 0.5)], ['p95', p95], ['worst', sorted.at(-1)]].map(([name, value]) => `${name} ${value.toFixed(1)} ${unit}`)
    process.stdout.write(`${title}\n  ${figures.join(', ')} (${ms.length} times); budget ${budget_ms} ${unit} at p95: ${p95 <= budget_ms ? 'kept' : 'NOT KEPT'}\n${faults.map((fault) => `  ${fault}\n`).join('')}`)
  }
} finally {
  await browser.close()
  server.close()
  await rm(folder, { recursive: true, force: true })
}
process.exitCode = over ? 1 : 0
