// Notifies a person, even one who looks elsewhere, when a run ends, fails or needs an answer, and when a device is lost.
import { onScopeDispose, watch } from 'vue'
import { useConnection } from '../api/updates/connection'
import type { RunSummary } from '../api/types'
import { useNotices } from './notices'
import { usePreferences } from './preferences'
import { useStop } from './stop'

/** The notice for a run that changed from one state to another; null for none. */
export function noticeOf(before: RunSummary | undefined, now: RunSummary): { problem: boolean; text: string } | null {
  if (before === undefined) return null
  if (now.questions > before.questions) return { problem: false, text: `${now.protocol} is waiting for you` }
  if (!before.live || now.live) return null
  if (now.fate === 'succeeded') return { problem: false, text: `✓ ${now.protocol} is done` }
  return { problem: true, text: `${now.protocol} ${now.fate}${now.reason ? `: ${now.reason}` : ''}` }
}

type Reaches = Readonly<Record<string, string>>

/** The devices that answered before and do not now. */
export function lostSince(before: Reaches, now: Reaches): string[] {
  return Object.keys(now).filter((name) => now[name] === 'lost' && before[name] === 'online')
}

/** How the last run that ended while the page was hidden ended. */
let unseen = ''

/** Notices of the server and news of runs, while the calling scope lives. */
export function useNotifications(): void {
  const connection = useConnection()
  const notices = useNotices()
  const stop = useStop()
  onScopeDispose(connection.onNotice((told) => {
    // The person who pressed STOP ALL reads it in the alarm; everyone else here.
    if (stop.state !== 'calm' && told.text.includes('did not confirm the stop')) return
    notices.tell(told.text, { level: told.level, run: told.run, device: told.device })
  }))

  watch(() => ({ ...connection.bench.runs }), (now, before) => {
    for (const run of Object.values(now)) {
      if (before[run.id] === run) continue
      const news = noticeOf(before[run.id], run)
      if (news === null) continue
      notices.tell(news.text, { level: news.problem ? 'problem' : 'info', run: run.id })
      elsewhere(news.text, run.id)
      if (document.hidden) unseen = news.problem ? '✕' : '✓'
    }
    markTitle(Object.values(now))
  })
  watch((): Reaches => Object.fromEntries(Object.values(connection.bench.devices).map(({ name, reach }) => [name, reach])), (now, before) => {
    for (const device of lostSince(before, now)) {
      notices.tell(`${device} is lost`, { level: 'problem', device })
      elsewhere(`${device} is lost`, device)
    }
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

function elsewhere(text: string, tag: string): void {
  if (!usePreferences().notifications || !document.hidden || !('Notification' in window) || Notification.permission !== 'granted') return
  try {
    new Notification('labrun', { body: text, tag, icon: '/icon.svg' }).onclick = () => window.focus()
  } catch {
    // A telephone's browser has the word, but makes none without a service worker.
  }
}

/** `(!)` before the title while a run waits for a person; ✓ or ✕ for one that ended while the page was hidden. */
function markTitle(runs: RunSummary[]): void {
  const waits = runs.some((run) => run.live && run.questions > 0)
  const bare = document.title.replace(/^(\(!\)|✓|✕) /, '')
  const mark = waits ? '(!)' : unseen
  document.title = mark ? `${mark} ${bare}` : bare
}
