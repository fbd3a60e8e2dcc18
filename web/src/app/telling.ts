// Tells a person, also one who looks elsewhere, when a run ends, fails or waits for them.
import { onScopeDispose, watch } from 'vue'
import { useLive } from '../api/push/live'
import type { RunSummary } from '../api/types'
import { useNotices } from './notices'
import { usePreferences } from './preferences'
import { useStop } from './stop'

/** What is to be told of a run that was so and is now so; null for nothing. */
export function newsOf(before: RunSummary | undefined, now: RunSummary): { problem: boolean; text: string } | null {
  if (before === undefined) return null
  if (now.questions > before.questions) return { problem: false, text: `${now.protocol} waits for you` }
  if (!before.live || now.live) return null
  if (now.fate === 'succeeded') return { problem: false, text: `✓ ${now.protocol} is done` }
  return { problem: true, text: `${now.protocol} ${now.fate}${now.reason ? `: ${now.reason}` : ''}` }
}

/** How the last run ended that ended while the page was hidden. */
let unseen = ''

/** Notices of the server and news of runs, for as long as the calling scope lives. */
export function useTelling(): void {
  const live = useLive()
  const notices = useNotices()
  const preferences = usePreferences()
  const stop = useStop()
  onScopeDispose(live.onNotice((told) => {
    // Whoever pressed STOP ALL reads it in the alarm; everybody else here.
    if (stop.state !== 'calm' && told.text.includes('did not confirm the stop')) return
    notices.tell(told.text, { level: told.level, run: told.run, device: told.device })
  }))

  watch(() => ({ ...live.bench.runs }), (now, before) => {
    for (const run of Object.values(now)) {
      if (before[run.id] === run) continue
      const news = newsOf(before[run.id], run)
      if (news === null) continue
      notices.tell(news.text, { level: news.problem ? 'problem' : 'info', run: run.id })
      if (preferences.notifications) elsewhere(news.text, run.id)
      if (document.hidden) unseen = news.problem ? '✕' : '✓'
    }
    markTitle(Object.values(now))
  })
  const seen = (): void => {
    if (document.hidden) return
    unseen = ''
    markTitle(Object.values(live.bench.runs))
  }
  document.addEventListener('visibilitychange', seen)
  onScopeDispose(() => document.removeEventListener('visibilitychange', seen))
}

function elsewhere(text: string, run: string): void {
  if (!document.hidden || !('Notification' in window) || Notification.permission !== 'granted') return
  const notification = new Notification('labrun', { body: text, tag: run, icon: '/icon.svg' })
  notification.onclick = () => window.focus()
}

/** `(!)` before the title while a run waits for a person; ✓ or ✕ for one that ended while nobody looked. */
function markTitle(runs: RunSummary[]): void {
  const waits = runs.some((run) => run.live && run.questions > 0)
  const bare = document.title.replace(/^(\(!\)|✓|✕) /, '')
  const mark = waits ? '(!)' : unseen
  document.title = mark ? `${mark} ${bare}` : bare
}
