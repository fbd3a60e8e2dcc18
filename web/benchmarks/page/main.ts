// The pages that are measured, with a fake server; `window.measure` is called from outside.
import { createPinia } from 'pinia'
import { createApp, nextTick, type App } from 'vue'
import { createMemoryHistory, createRouter } from 'vue-router'
import { useConnection } from '../../src/api/updates/connection'
import RunPage from '../../src/runs/RunPage.vue'
import '../../src/ui/base.css'
import { frame, measureHour, measureMap, measureOutline, type Figures } from './measures'
import { Pretended, RUN } from './pretended'
import { measureSpectrum } from './spectrum'

declare global {
  interface Window {
    /** Bytes on the heap after a collection, from the browser's debugger. */
    heapUsed: () => Promise<number>
    measure: (what: 'first' | 'hour' | 'outline' | 'map' | 'spectrum') => Promise<Figures>
  }
}
const empty = { template: '' }
const NAMES = ['devices', 'protocols', 'protocol', 'runs', 'results', 'run-results', 'settings']

async function runPage(server: Pretended): Promise<App> {
  globalThis.fetch = (asked) => {
    const url = new URL(asked instanceof Request ? asked.url : String(asked), location.href)
    return Promise.resolve(server.answer(url.pathname, url.searchParams))
  }
  const routes = NAMES.map((name) => ({ path: `/${name}/:a?`, name, component: empty }))
  const router = createRouter({ history: createMemoryHistory(), routes: [{ path: '/runs/:run', name: 'run', props: true, component: RunPage }, ...routes] })
  const app = createApp(RunPage, { run: RUN }).use(createPinia()).use(router)
  await router.push(`/runs/${RUN}`)
  app.mount('#app')
  useConnection().listen(() => Promise.resolve(true), () => server.socket())
  while (!document.querySelector('[aria-label="Outline"]')) await new Promise((resolve) => setTimeout(resolve, 20))
  await nextTick()
  return app
}

window.measure = async (what) => {
  if (what === 'spectrum') return measureSpectrum()
  const server = what === 'map' ? new Pretended(21, 51) : new Pretended(400, 250)
  const began = performance.now()
  const app = await runPage(server)
  await frame()
  await frame()
  const first: Figures = { title: '100,000 points: from opening the run to its first picture', ms: [performance.now() - began], budget_ms: 3_000 }
  const figures = what === 'first' ? first : await (what === 'outline' ? measureOutline(server) : what === 'hour' ? measureHour(server) : measureMap(server))
  app.unmount()
  return figures
}
