import { mount, type VueWrapper } from '@vue/test-utils'
import { createPinia, setActivePinia } from 'pinia'
import { beforeEach, describe, expect, it } from 'vitest'
import { createMemoryHistory, createRouter, type Router } from 'vue-router'
import { useConnection } from '../api/updates/connection'
import StartPage from './StartPage.vue'

const nothing = { template: '<p />' }
let router: Router

async function opened(): Promise<VueWrapper> {
  await router.push('/')
  return mount({ template: '<RouterView />' }, { global: { plugins: [router], stubs: { StartWays: true } } })
}

async function lastStep(): Promise<VueWrapper> {
  const page = await opened()
  await page.find('form').trigger('submit')
  await page.findAll('button').find((one) => one.text() === 'Next')?.trigger('click')
  return page
}

async function pressed(page: VueWrapper, word: string): Promise<unknown> {
  const arrived = new Promise((resolve) => router.afterEach((to) => { resolve(to.name) }))
  await page.findAll('button').find((one) => one.text() === word)?.trigger('click')
  return arrived
}

beforeEach(() => {
  localStorage.clear()
  setActivePinia(createPinia())
  router = createRouter({
    history: createMemoryHistory(),
    routes: [
      { path: '/', name: 'start', component: StartPage },
      ...['protocols', 'devices', 'runs'].map((name) => ({ path: `/${name}`, name, component: nothing })),
      { path: '/runs/:run', name: 'run', component: nothing },
    ],
  })
  const { bench } = useConnection()
  Object.assign(bench, { seq: 1, runs: { 'run-1': { id: 'run-1', live: true } } })
})

describe('the first start, while a run is live', () => {
  it('leads where the person says', async () => {
    expect(await pressed(await lastStep(), 'Go to the protocols')).toBe('protocols')
  })

  it('leads to the devices as well', async () => {
    expect(await pressed(await lastStep(), 'Look at the devices')).toBe('devices')
  })

  it('leads to the run only if nothing was said', async () => {
    expect(await pressed(await opened(), 'Skip')).toBe('run')
  })
})
