// Routes: addresses hold the state, and each page is loaded on demand.
import { createRouter, createWebHistory, type RouteRecordRaw } from 'vue-router'

declare module 'vue-router' {
  interface RouteMeta {
    title: string
    place: 'devices' | 'protocols' | 'runs' | 'results' | 'settings' | 'start'
  }
}

export const routes: RouteRecordRaw[] = [
  { path: '/', name: 'start', component: () => import('./StartPage.vue'), meta: { title: 'labrun', place: 'start' } },
  {
    path: '/devices/:device?', name: 'devices', props: true,
    component: () => import('../devices/DevicesPage.vue'), meta: { title: 'Devices', place: 'devices' },
  },
  {
    path: '/protocols', name: 'protocols',
    component: () => import('../protocols/ProtocolsPage.vue'), meta: { title: 'Protocols', place: 'protocols' },
  },
  {
    path: '/protocols/:name(.*)', name: 'protocol', props: true,
    component: () => import('../protocols/EditorPage.vue'), meta: { title: 'Protocol', place: 'protocols' },
  },
  { path: '/runs', name: 'runs', component: () => import('../runs/RunsPage.vue'), meta: { title: 'Runs', place: 'runs' } },
  {
    path: '/runs/:run', name: 'run', props: true,
    component: () => import('../runs/RunPage.vue'), meta: { title: 'Run', place: 'runs' },
  },
  {
    path: '/results', name: 'results',
    component: () => import('../results/ResultsPage.vue'), meta: { title: 'Results', place: 'results' },
  },
  {
    path: '/results/:run', name: 'run-results', props: true,
    component: () => import('../results/RunResultsPage.vue'), meta: { title: 'Results', place: 'results' },
  },
  {
    path: '/compare', name: 'compare',
    component: () => import('../results/ComparePage.vue'), meta: { title: 'Compare', place: 'results' },
  },
  {
    path: '/samples/:sample(.*)?', name: 'samples', props: true,
    component: () => import('../results/SamplesPage.vue'), meta: { title: 'Samples', place: 'results' },
  },
  {
    path: '/settings', name: 'settings',
    component: () => import('../settings/SettingsPage.vue'), meta: { title: 'Settings', place: 'settings' },
  },
  { path: '/:rest(.*)*', name: 'nowhere', component: () => import('./NowherePage.vue'), meta: { title: 'Not found', place: 'start' } },
]

export function makeRouter() {
  const router = createRouter({
    history: createWebHistory(), routes,
    scrollBehavior: (to, from, saved) => saved ?? (to.path === from.path ? false : { top: 0 }),
  })
  router.afterEach((to) => {
    document.title = to.meta.place === 'start' ? 'labrun' : `${to.meta.title} · labrun`
  })
  return router
}
