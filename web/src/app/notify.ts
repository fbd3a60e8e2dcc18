// Notifies a person, even one who looks elsewhere, when a run ends, fails or needs an answer, and when a device is lost.
import { onScopeDispose, watch } from 'vue'
import { useRouter } from 'vue-router'
import { useConnection } from '../api/updates/connection'
import type { RunSummary } from '../api/types'
import { endWords } from '../runs/status'
import { counted } from '../ui/format'
import { useNotices } from './notices'
import { usePreferences } from './preferences'
import { useStop } from './stop'

/** The notice for a run that changed from one state to another; null for none. */
export function noticeOf(before: RunSummary | undefined, now: RunSummary): { problem: boolean; text: string } | null {
  if (before === undefined) return null
  if (now.questions > before.questions) return { problem: false, text: `${now.protocol} is waiting for you` }
  if (!before.live || now.live) return null
  if (now.fate === 'succeeded') return { problem: false, text: `✓ ${now.protocol} is done${now.holes > 0 ? `, with ${counted(now.holes, 'hole')}` : ''}` }
  return { problem: true, text: `${now.protocol} ${endWords(now.fate, now.reason)}` }
}

type Reaches = Readonly<Record<string, string>>

/** The devices that answered before and do not now. */
export function lostSince(before: Reaches, now: Reaches): string[] {
  return Object.keys(now).filter((name) => now[name] === 'lost' && before[name] === 'online')
}

const GATHER_MS = 1_500

/** How the last run that ended while the page was hidden ended. */
let unseen = ''

/** Notices of the server and news of runs, while the calling scope lives. */
export function useNotifications(): void {
  const connection = useConnection()
  const notices = useNotices()
  const stop = useStop()
  const router = useRouter()
  let known = false
  let gone: string[] = []
  /** Of many devices that are lost together one notification tells, and of one that is back at once none. */
  const tellLost = (): void => {
    const lost = gone.filter((name) => connection.bench.devices[name]?.reach === 'lost')
    gone = []
    const [device] = lost
    if (device === undefined) return
    const words = lost.length > 1 ? `${String(lost.length)} devices are lost: ${lost.join(', ')}` : `${device} is lost`
    void elsewhere(words, 'devices', () => router.push({ name: 'devices', params: { device } }))
  }
  holdWhileInView()
  onScopeDispose(connection.onNotice((told) => {
    // The person who pressed STOP ALL reads it in the alarm; everyone else here.
    if (stop.state !== 'calm' && told.text.includes('did not confirm the stop')) return
    notices.tell(told.text, { level: told.level, run: told.run, device: told.device })
  }))

  watch(() => ({ ...connection.bench.runs }), (now, before) => {
    for (const run of Object.values(now)) {
      if (before[run.id] === run) continue
      const told = before[run.id] ?? (known && run.live ? { ...run, questions: 0 } : undefined)
      if (run.live) over(`${run.id} ends`)
      if (run.questions === 0) over(`${run.id} asks`)
      const news = noticeOf(told, run)
      if (news === null) continue
      notices.tell(news.text, { level: news.problem ? 'problem' : 'info', run: run.id })
      void elsewhere(news.text, `${run.id} ${run.live ? 'asks' : 'ends'}`, () => router.push({ name: 'run', params: { run: run.id } }))
      if (document.hidden && !run.live) unseen = news.problem ? '✕' : '✓'
    }
    known ||= connection.bench.seq >= 0
    markTitle(Object.values(now))
  })
  watch((): Reaches => Object.fromEntries(Object.values(connection.bench.devices).map(({ name, reach }) => [name, reach])), (now, before) => {
    for (const device of lostSince(before, now)) {
      notices.tell(`${device} is lost`, { level: 'problem', device })
      if (gone.length === 0) setTimeout(tellLost, GATHER_MS)
      gone.push(device)
    }
    if (!Object.values(now).includes('lost')) over('devices')
    for (const one of notices.shown) if (one.device && now[one.device] === 'online' && one.text === `${one.device} is lost`) notices.drop(one.id)
  })
  const seen = (): void => {
    if (document.hidden) return
    unseen = ''
    markTitle(Object.values(connection.bench.runs))
  }
  document.addEventListener('visibilitychange', seen)
  onScopeDispose(() => document.removeEventListener('visibilitychange', seen))
}

const IN_VIEW = 'labrun.in-view'

/** While this tab is before a person it holds a lock, and no other tab sends them a notification. */
function holdWhileInView(): void {
  let leave: (() => void) | undefined
  const look = (): void => {
    leave?.()
    if (!window.isSecureContext || !document.hasFocus()) return
    const left = new Promise<void>((resolve) => (leave = resolve))
    void navigator.locks.request(IN_VIEW, { mode: 'shared' }, () => left)
  }
  look()
  for (const event of ['focus', 'blur']) window.addEventListener(event, look)
  onScopeDispose(() => {
    leave?.()
    for (const event of ['focus', 'blur']) window.removeEventListener(event, look)
  })
}

const away = new Map<string, Notification>()

/** A notification of the system: one of each tag, though several tabs send it. */
async function elsewhere(text: string, tag: string, open: () => unknown): Promise<void> {
  if (!usePreferences().notifications || !('Notification' in window) || Notification.permission !== 'granted') return
  const { held } = await navigator.locks.query()
  if (held?.some((one) => one.name === IN_VIEW)) return
  try {
    const shown = new Notification('labrun', { body: text, tag, icon: '/icon.svg' })
    away.set(tag, shown)
    shown.onclick = () => {
      window.focus()
      open()
      shown.close()
    }
  } catch {
    // A telephone's browser has the word, but makes none without a service worker.
  }
}

/** What it said is no longer so. */
function over(tag: string): void {
  away.get(tag)?.close()
  away.delete(tag)
}

/** `(!)` before the title while a run waits for a person; ✓ or ✕ for one that ended while the page was hidden. */
function markTitle(runs: RunSummary[]): void {
  const waits = runs.some((run) => run.live && run.questions > 0)
  const bare = document.title.replace(/^(\(!\)|✓|✕) /, '')
  const mark = waits ? '(!)' : unseen
  document.title = mark ? `${mark} ${bare}` : bare
}
